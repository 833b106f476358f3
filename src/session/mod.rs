//! The background worker: requests in, immutable snapshots out. Knows neither GPU nor window.

mod arriving;
mod effect_costs;
mod error;
mod memory;
mod pipeline;
mod recompute;
mod threads;
mod wanted;
mod watched;
mod worker;

pub use effect_costs::effect_costs;
pub use error::PipelineError;
pub use memory::available_bytes;
pub use pipeline::{
    Control, Prepared, Progress, Run, SolveSettings, Solved, Stage, Timings, patch_reflectance, prepare,
    solve, system, without_light,
};
pub use worker::{MaterialEdit, Session, Snapshot};
