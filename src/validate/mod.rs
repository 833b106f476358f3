//! Cases whose answer is known, run on the user's own machine: closed forms, published solutions
//! and the laws that any solution obeys.
//!
//! A [`Case`] names its source, its expected value and the ways of computing it, each with a
//! tolerance and the reason for it. [`cases`] lists them all; `lumenwalk validate` prints the table,
//! and the tests of physics build their scenes with the same [`Model`].

mod assembled;
mod case;
mod closed_scenes;
mod extremes;
mod lamps;
mod model;
mod open_scenes;
mod panes;
pub mod scenes;
mod solutions;
mod view_factors;

pub use assembled::Assembled;
pub use case::{Case, CaseError, Group, Outcome, Way};
pub use model::Model;

/// All cases, group by group.
pub fn cases() -> Vec<Case> {
    [
        view_factors::cases(),
        open_scenes::cases(),
        closed_scenes::cases(),
        solutions::cases(),
        panes::cases(),
        lamps::cases(),
        extremes::cases(),
    ]
    .into_iter()
    .flatten()
    .collect()
}
