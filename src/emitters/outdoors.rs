use super::{Emitter, HalfSpace, lambert};
use crate::daylight::LUMINOUS_EFFICACY;
use crate::scene::Outdoors;
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// A part of the sky, of the ground beyond a model, or the disc of the sun: so far away that it is seen in the same
/// direction from everywhere in the scene.
#[derive(Clone, Debug)]
pub struct OutdoorEmitter {
    outdoors: Arc<Outdoors>,
    shape: Shape,
    /// Corners of its outline, metres.
    hull: Vec<DVec3>,
    /// Unit vector to its middle.
    middle: DVec3,
    /// Where directions count from, metres.
    centre: DVec3,
}

/// How its radiance differs within it: what it sends counts by its mean.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape {
    /// As that of the sky, whose mean is this, W/(m² sr).
    Sky(f64),
    /// Not at all; holds what its form factor counts.
    Even(f64),
}

/// An emitter of the sky or the ground, the part of the sky that it stands for, and what that counts at the hour.
#[derive(Clone, Debug)]
pub struct SkyPart {
    /// What sends out light: irradiance comes as a form factor, weighted by how the radiance differs within it.
    pub emitter: OutdoorEmitter,
    /// The same for all of the ground.
    pub part: u16,
    /// Its mean exitance for a unit of the sky.
    pub factor: f64,
}

/// How far away, over the size of the scene: from its edges parts of the sky are seen by a fiftieth of a degree too far
/// to the side, at most.
const FAR: f64 = 3000.0;
/// Parts of the rows of the sky from the horizon up, and how high a row is, degrees.
const SKY_ROWS: [usize; 7] = [24, 24, 24, 24, 12, 12, 6];
const HEIGHT: f64 = 12.0;
/// Corners of the sun's disc.
const SUN_CORNERS: usize = 12;
/// The ground beyond a model in so many sectors, and the rows that they are cut into, degrees below the horizon.
const SECTORS: usize = 12;
const ROWS: [[f64; 2]; 2] = [[-30.0, 0.0], [-75.0, -30.0]];

impl OutdoorEmitter {
    /// The sky and the ground beyond a scene of some `size` about its `centre`, metres: 1 W/m² of their lamp lights an
    /// unobstructed horizontal surface with as much. The parts are the same at every hour and fixed to the model; what is
    /// dark counts nothing and is taken as even.
    pub fn sky(outdoors: &Arc<Outdoors>, centre: DVec3, size: f64) -> Vec<SkyPart> {
        let unit = outdoors.sky_unit();
        let new = |corners: &[[f64; 2]]| {
            let corners = directions(corners).into_iter().map(|e| outdoors.upright.to_model(e)).collect();
            Self::new(outdoors, corners, centre, FAR * size)
        };
        let is_lit = outdoors.daylight.sky().horizontal() > 0.0;
        let mut parts: Vec<SkyPart> = sky_parts()
            .iter()
            .zip(0..)
            .map(|(corners, part)| {
                let mut emitter = new(corners);
                let mean = if is_lit { emitter.mean_radiance() } else { 0.0 };
                if mean > 0.0 {
                    emitter.shape = Shape::Sky(mean);
                }
                SkyPart { emitter, part, factor: PI * mean / unit }
            })
            .collect();
        // In all they send what the sky does.
        let up = outdoors.upright.to_model(DVec3::Z);
        let seen = |part: &SkyPart| part.emitter.irradiance(up, &part.emitter.relative(centre));
        let sent: f64 = parts.iter().map(|part| part.factor * seen(part)).sum();
        let sky = if is_lit { outdoors.daylight.sky().horizontal() / LUMINOUS_EFFICACY / unit } else { 0.0 };
        let scale = if sent > 0.0 { sky / sent } else { 0.0 };
        parts.iter_mut().for_each(|part| part.factor *= scale);
        let factor = PI * outdoors.daylight.ground_luminance() / LUMINOUS_EFFICACY / unit;
        let part = parts.len() as u16;
        let width = 360.0 / SECTORS as f64;
        for [low, high] in ROWS {
            parts.extend((0..SECTORS).map(|k| {
                let (from, to) = (width * k as f64, width * (k + 1) as f64);
                let corners = [[low, from], [low, to], [high, to], [high, from]];
                SkyPart { emitter: new(&corners), part, factor }
            }));
        }
        let corners: Vec<[f64; 2]> = (0..SECTORS).map(|k| [ROWS[1][0], width * k as f64]).collect();
        parts.push(SkyPart { emitter: new(&corners), part, factor });
        parts
    }

    /// Mean of the radiance of the sky over it as seen from everywhere, W/(m² sr).
    fn mean_radiance(&self) -> f64 {
        let [mut sum, mut whole] = [0.0; 2];
        self.triangles(self.middle, &self.relative(self.centre), |share, direction| {
            sum += share * self.outdoors.radiance(direction);
            whole += share;
        });
        if whole > 0.0 { sum / whole } else { 0.0 }
    }

    /// Calls `each` with the form factors of the triangles about the middle of what is seen, and a direction within each.
    fn triangles(&self, normal: DVec3, visible: &[DVec3], mut each: impl FnMut(f64, DVec3)) {
        let middle = visible.iter().map(|corner| corner.normalize_or_zero()).sum::<DVec3>();
        for (k, &p) in visible.iter().enumerate() {
            let q = visible[if k + 1 == visible.len() { 0 } else { k + 1 }];
            let triangle = [p.normalize_or_zero(), q.normalize_or_zero(), middle.normalize_or_zero()];
            let share = lambert(normal, &triangle);
            if share > 0.0 {
                each(share, triangle.iter().sum());
            }
        }
    }

    /// The sun's disc, where it shines: 1 W/m² of its lamp lights a surface that faces it with as much.
    pub fn sun(outdoors: &Arc<Outdoors>, centre: DVec3, size: f64) -> Option<Self> {
        if outdoors.sun_exitance() <= 0.0 {
            return None;
        }
        let to_sun = outdoors.daylight.sun().direction();
        let (across, along) = to_sun.any_orthonormal_pair();
        let half = (0.5 * crate::daylight::SUN_DIAMETER).to_radians().tan();
        let corners: Vec<DVec3> = (0..SUN_CORNERS)
            .map(|k| {
                let (sin, cos) = (TAU * k as f64 / SUN_CORNERS as f64).sin_cos();
                outdoors.compass.to_model((to_sun + half * (cos * across + sin * along)).normalize())
            })
            .collect();
        let mut disc = Self::new(outdoors, corners, centre, FAR * size);
        disc.shape = Shape::Even(1.0 / lambert(disc.middle, &disc.relative(centre)).max(f64::MIN_POSITIVE));
        Some(disc)
    }

    /// Of corners as unit vectors of the model, in turn about its middle; evenly bright.
    fn new(outdoors: &Arc<Outdoors>, mut corners: Vec<DVec3>, centre: DVec3, far: f64) -> Self {
        let middle = corners.iter().sum::<DVec3>().normalize_or(DVec3::Y);
        if corners[1].cross(corners[0]).dot(middle) < 0.0 {
            corners.reverse();
        }
        let hull = corners.into_iter().map(|corner| centre + far * corner).collect();
        Self { outdoors: Arc::clone(outdoors), shape: Shape::Even(1.0), hull, middle, centre }
    }

    /// Corners as seen from a point.
    fn relative(&self, from: DVec3) -> Vec<DVec3> {
        self.hull.iter().map(|corner| *corner - from).collect()
    }
}

/// Elevations and azimuths of the corners of parts that make up the sky: rows of equal height and a cap. The arcs of
/// great circles between neighbours are the same from both sides, so that they meet without gaps.
fn sky_parts() -> Vec<Vec<[f64; 2]>> {
    let low = |row: usize| HEIGHT * row as f64;
    let around = |count: usize, k: usize| 360.0 * k as f64 / count as f64;
    let mut parts = Vec::new();
    for (row, &count) in SKY_ROWS.iter().enumerate() {
        // Below lie as many or more, whose corners are its own as well.
        let below = SKY_ROWS[row.saturating_sub(1)];
        for k in 0..count {
            let (from, to) = (k * below / count, (k + 1) * below / count);
            let mut corners: Vec<[f64; 2]> = (from..=to).map(|k| [low(row), around(below, k)]).collect();
            corners.extend([[low(row + 1), around(count, k + 1)], [low(row + 1), around(count, k)]]);
            parts.push(corners);
        }
    }
    let last = SKY_ROWS[SKY_ROWS.len() - 1];
    parts.push((0..last).map(|k| [low(SKY_ROWS.len()), around(last, k)]).collect());
    parts
}

/// Unit vectors of the sky from elevations and azimuths, degrees.
fn directions(corners: &[[f64; 2]]) -> Vec<DVec3> {
    corners.iter().map(|&[elevation, azimuth]| crate::daylight::direction(elevation, azimuth)).collect()
}

impl Emitter for OutdoorEmitter {
    fn hull(&self) -> &[DVec3] {
        &self.hull
    }

    fn is_part(&self, _: u32) -> bool {
        false
    }

    fn outline(&self, from: DVec3, corners: &mut Vec<DVec3>) -> Option<HalfSpace> {
        corners.clear();
        corners.extend(self.hull.iter().map(|corner| *corner - from));
        // Everything in the scene is nearer.
        let far = self.hull[0].distance(self.centre);
        Some(HalfSpace { normal: -self.middle, offset: -far })
    }

    fn irradiance(&self, normal: DVec3, visible: &[DVec3]) -> f64 {
        match self.shape {
            Shape::Even(factor) => factor * lambert(normal, visible),
            Shape::Sky(mean) => {
                let mut sum = 0.0;
                self.triangles(normal, visible, |share, direction| {
                    sum += share * self.outdoors.radiance(direction);
                });
                sum / mean
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneSource, load};

    fn outdoors(sidecar: &str) -> Arc<Outdoors> {
        let folder = tempfile::tempdir().expect("a folder");
        let write = |name: &str, text: &str| {
            std::fs::write(folder.path().join(name), text).expect("written");
        };
        write("plate.obj", "v 0 0 0\nv 1 0 0\nv 1 0 -1\nv 0 0 -1\nf 1 2 3 4\n");
        write("plate.toml", sidecar);
        let scene = load(&SceneSource::File(folder.path().join("plate.obj"))).expect("a scene");
        Arc::new(scene.outdoors.expect("daylight"))
    }

    #[test]
    fn a_surface_that_faces_the_sun_has_all_of_it_and_one_turned_away_the_cosine() {
        let outdoors = outdoors("[daylight]\nsun = [35, 150]\nlux = [50000, 10000]\n");
        let sun = OutdoorEmitter::sun(&outdoors, DVec3::ZERO, 10.0).expect("it shines");
        let seen = sun.relative(DVec3::ZERO);
        assert!((sun.irradiance(outdoors.to_sun(), &seen) - 1.0).abs() < 1e-9);
        let up = sun.irradiance(DVec3::Y, &seen);
        assert!((up - 35.0_f64.to_radians().sin()).abs() < 1e-5, "{up}");
    }
}
