//! The background worker: requests in, immutable snapshots out. Knows neither GPU nor window.

mod failure;
mod recompute;
mod snapshot;
mod threads;
mod wanted;
mod worker;

pub use recompute::Recompute;
pub use snapshot::Snapshot;
pub use worker::{MaterialEdit, Session};
