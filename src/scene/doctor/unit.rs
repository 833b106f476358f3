//! Whether the size of a model is that of a building.

use crate::scene::finding::{Finding, FindingKind, Severity};
use crate::scene::types::{LengthUnit, Scene};

/// Rooms and houses are this high, metres; other heights make one doubt the unit.
const BELIEVABLE_HEIGHT: std::ops::RangeInclusive<f64> = 0.3..=60.0;

/// Doubts the unit where the height is not that of a building.
pub(super) fn check(scene: &Scene, findings: &mut Vec<Finding>) {
    let height = scene.bounds().size().dot(scene.up.vector());
    if BELIEVABLE_HEIGHT.contains(&height) || height <= 0.0 {
        return;
    }
    use LengthUnit::{Centimetre, Foot, Inch, Metre, Millimetre};
    let in_units = height / scene.unit.metres();
    let better = [Millimetre, Centimetre, Metre, Foot, Inch]
        .into_iter()
        .find(|unit| (2.0..=15.0).contains(&(in_units * unit.metres())));
    if let Some(unit) = better {
        let message = format!(
            "the model is {height:.3} m high; if that is wrong, try unit = \"{}\" in {}.toml, which makes it {:.2} m",
            unit.symbol(),
            scene.name,
            in_units * unit.metres()
        );
        findings.push(
            Finding::new(FindingKind::Unit, Severity::Warning, message)
                .with("lux stay the same in a model of any size, if lamps are given by Ke; lumens do not"),
        );
    }
}
