//! What accuracy costs in this scene on this machine: whole solves, audited, compared and chosen.
//!
//! [`audit()`] checks one solve; [`reach`] solves to an error or within a time; [`measure`] fills a
//! table of methods, resolutions and patch sizes; [`chart()`] draws it.

mod audited;
mod chart;
mod cost;
mod forecast;
mod goal;
mod goal_run;
mod points;
mod refine;
mod sweep;
pub mod table;
mod trial;
mod verdict;
mod until;

pub use audited::{audit, shown};
pub use chart::chart;
pub use cost::{CostModel, Fineness, Limits, Measured};
pub use forecast::{Forecast, Outlook};
pub use goal::{Attempt, Goal, MOST_PATCHES, News, Reached, Task, fewest, memory, reach};
pub use goal_run::{GoalRun, MOST_SOLVES, Step};
pub use points::{PointErrors, points};
pub use refine::refined;
pub use sweep::{Entry, entries, foreseen, measure, pareto};
pub use trial::{Pace, Trial, pace, trial};
pub use verdict::{Obstacle, Verdict};

use crate::scene::Scene;

/// A number that differs between scenes that differ in shape, materials or lamps, and between versions of the
/// program, whose measurements are not compared (FNV-1a, 64 bits).
pub fn scene_hash(scene: &Scene) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    let mut take = |bits: u64| {
        for byte in bits.to_le_bytes() {
            hash = (hash ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    };
    env!("CARGO_PKG_VERSION").bytes().for_each(|b| take(u64::from(b)));
    for x in scene.positions.iter().flat_map(|p| p.to_array()) {
        take(x.to_bits());
    }
    for surface in &scene.surfaces {
        take(u64::from(surface.material));
        take(u64::from(surface.object));
        surface.corners.iter().for_each(|c| take(u64::from(c.position)));
        surface.emission_weight.iter().for_each(|e| take(e.to_bits()));
    }
    for material in &scene.materials {
        material.reflectance.iter().for_each(|r| take(r.to_bits()));
        take(material.texture.map_or(0, |t| 1 + u64::from(t)));
        take(material.sides as u64);
    }
    for pixel in scene.textures.iter().flat_map(|t| &t.pixels).flatten() {
        take(u64::from(pixel.to_bits()));
    }
    for lamp in &scene.luminaires {
        lamp.initial.output().iter().for_each(|e| take(e.to_bits()));
    }
    for source in scene.photometric_sources() {
        let place = source.place;
        for axis in [place.centre, place.frame.tangent, place.frame.normal] {
            axis.to_array().iter().for_each(|x| take(x.to_bits()));
        }
        for k in 0..64_u32 {
            let e = crate::geometry::Frame::around(glam::DVec3::Z).turned(f64::from(k) * 2.4).tangent;
            let e = e + glam::DVec3::Z * (f64::from(k) / 16.0 - 2.0);
            take(source.intensity(place.frame.world(e)).to_bits());
        }
    }
    take(scene.patch_size.map_or(0, f64::to_bits));
    hash
}
