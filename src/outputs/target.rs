//! What work of a kind asks of light, and whether a room has it.

use crate::export::WorkPlaneReport;

/// What EN 12464-1:2011 asks of the light of a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Target {
    /// How the command line calls it.
    pub key: &'static str,
    /// What it is for.
    pub name: &'static str,
    /// Reference number in the standard.
    pub clause: &'static str,
    /// Maintained illuminance in the mean, lx.
    pub lux: f64,
    /// Least over mean illuminance.
    pub uniformity: f64,
}

/// Common places, with the requirements of EN 12464-1:2011, tables 5.1 to 5.36.
pub const TARGETS: [Target; 14] = [
    of("corridor", "Corridors and circulation areas", "5.1.1", 100.0, 0.4),
    of("stairs", "Stairs and escalators", "5.1.2", 100.0, 0.4),
    of("canteen", "Canteens and pantries", "5.2.1", 200.0, 0.4),
    of("toilet", "Cloakrooms, washrooms, bathrooms, toilets", "5.2.4", 200.0, 0.4),
    of("store", "Store and stockrooms", "5.4.1", 100.0, 0.4),
    of("filing", "Filing and copying", "5.26.1", 300.0, 0.4),
    of("office", "Writing, typing, reading, data processing", "5.26.2", 500.0, 0.6),
    of("drawing", "Technical drawing", "5.26.3", 750.0, 0.7),
    of("meeting", "Conference and meeting rooms", "5.26.5", 500.0, 0.6),
    of("reception", "Reception desks", "5.26.6", 300.0, 0.6),
    of("archive", "Archives", "5.26.7", 200.0, 0.4),
    of("sales", "Sales areas", "5.27.1", 300.0, 0.4),
    of("kitchen", "Kitchens of restaurants and hotels", "5.29.2", 500.0, 0.6),
    of("classroom", "Classrooms and tutorial rooms", "5.36.1", 300.0, 0.6),
];

const fn of(
    key: &'static str,
    name: &'static str,
    clause: &'static str,
    lux: f64,
    uniformity: f64,
) -> Target {
    Target { key, name, clause, lux, uniformity }
}

impl Target {
    /// The one of this key.
    pub fn of(key: &str) -> Option<Self> {
        TARGETS.into_iter().find(|target| target.key == key)
    }

    /// What is to be said of a room.
    pub fn verdict(&self, plane: &WorkPlaneReport) -> &'static str {
        match self.met(plane) {
            [true, true] => "met",
            [false, true] => "too dark",
            [true, false] => "too uneven",
            [false, false] => "too dark and uneven",
        }
    }

    /// Whether a room has the mean illuminance, and whether it has the uniformity.
    pub fn met(&self, plane: &WorkPlaneReport) -> [bool; 2] {
        // What is told with three digits is not to fail by the fourth.
        const ROUNDED: f64 = 1.0 - 5e-4;
        let uniformity = plane.uniformity.unwrap_or(0.0);
        [plane.illuminance_lx.mean >= ROUNDED * self.lux, uniformity >= ROUNDED * self.uniformity]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::GridReport;

    #[test]
    fn mean_and_uniformity_are_judged_by_themselves() {
        let office = Target::of("office").expect("known");
        assert_eq!((office.lux, office.uniformity, office.clause), (500.0, 0.6, "5.26.2"));
        assert!(Target::of("ballroom").is_none());
        let plane = |lux: &[f64]| {
            let found = GridReport::of(lux).expect("values");
            WorkPlaneReport {
                name: "Room 1".to_owned(),
                size_m: [4.0, 3.0],
                height_m: 0.8,
                spacing_m: [0.5; 2],
                points: lux.len(),
                illuminance_lx: found,
                uniformity: (found.mean > 0.0).then(|| found.minimum / found.mean),
                daylight_factor_percent: None,
            }
        };
        assert_eq!(office.met(&plane(&[499.9, 499.9])), [true, true]);
        assert_eq!(office.met(&plane(&[200.0, 1000.0])), [true, false]);
        assert_eq!(office.met(&plane(&[400.0, 420.0])), [false, true]);
        assert_eq!(office.met(&plane(&[0.0])), [false, false]);
    }
}
