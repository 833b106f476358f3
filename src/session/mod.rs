//! The background worker: requests in, immutable snapshots out. Knows neither GPU nor window.

mod daylight;
mod failure;
mod handle;
mod leisure;
mod recompute;
mod snapshot;
mod threads;
mod wanted;
mod worker;

pub use handle::{MaterialEdit, Session};
pub use recompute::Recompute;
pub use snapshot::Snapshot;
