//! One solve from a scene to its light, step by step, and what it takes.

mod arriving;
mod daylight_factor;
mod direct;
mod effect_costs;
mod element_light;
mod error;
mod glimpse;
mod memory;
mod pipeline;
mod rows;
mod solution;
mod store;
mod uneven;
mod watched;

pub use daylight_factor::{Overcast, daylight_factor};
pub use effect_costs::{effect_costs, measured};
pub use element_light::ElementLight;
pub use error::PipelineError;
pub use memory::{Predicted, predicted};
pub use pipeline::{
    Control, DirectTarget, Prepared, Progress, Run, SolveSettings, Stage, Timings, patch_reflectance,
    prepare, solve, system, without_light,
};
pub use solution::Solution;
pub use store::RowStore;
pub use uneven::UnevenLight;
