//! The background worker: requests in, immutable snapshots out. Knows neither GPU nor window.

mod failure;
mod recompute;
mod threads;
mod wanted;
mod worker;

pub use worker::{MaterialEdit, Session, Snapshot};
