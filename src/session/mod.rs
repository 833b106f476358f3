//! The background worker: requests in, immutable snapshots out. Knows neither GPU nor window.

mod pipeline;
mod worker;

pub use pipeline::{Control, PipelineError, Progress, SolveSettings, Solved, Stage, Timings, solve};
pub use worker::{MaterialEdit, Session, Snapshot};
