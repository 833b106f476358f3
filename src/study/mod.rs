//! What accuracy costs in this scene on this machine: whole solves, audited, compared and chosen.

mod audited;

pub use audited::{audit, shown};
