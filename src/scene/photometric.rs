//! Lamps whose light is that of a photometric file: which file, and how the luminaire hangs in the scene.

use super::finding::{Finding, FindingKind, Severity};
use super::lookup::{Files, reason};
use super::names;
use super::types::{Scene, UpAxis};
use crate::geometry::Frame;
use crate::photometry::{self, Photometry};
use glam::{DQuat, DVec3};
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// The light of a lamp by its photometry.
#[derive(Clone, Debug, PartialEq)]
pub struct PhotometricLight {
    /// The distribution and the opening; dark ones are refused.
    pub photometry: Arc<Photometry>,
    /// Where luminaires of it hang; at least one.
    pub places: Vec<PhotometricPlace>,
    /// Flux of its photometry, lumens; above 0.
    flux: f64,
    /// What of it leaves towards the nadir's side, 0 to 1.
    downward_share: f64,
}

/// Where a luminaire hangs, and how.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotometricPlace {
    /// The photometric centre, metres.
    pub centre: DVec3,
    /// The axes of the luminaire: C0, C90, and away from its nadir.
    pub frame: Frame,
    /// Its share of the lamp's flux, 0 to 1; those of a lamp add up to 1.
    pub share: f64,
}

/// One luminaire that shines by its photometry.
#[derive(Clone, Debug)]
pub struct PhotometricSource {
    /// Index into the scene's luminaires.
    pub luminaire: u32,
    /// Distribution and opening.
    pub photometry: Arc<Photometry>,
    /// Where it hangs.
    pub place: PhotometricPlace,
    /// What it sends out for a unit of the lamp's exitance, W per W/m²: its share of the lamp's area, m².
    pub area: f64,
    /// The share of its flux that leaves towards the nadir's side, 0 to 1.
    pub downward_share: f64,
    /// Of its area for a lumen of its photometry, m²/lm.
    per_lumen: f64,
}

impl PhotometricSource {
    /// A luminaire that is all of the first lamp, which shines with an `area`, m².
    #[cfg(test)]
    pub(crate) fn single(photometry: Photometry, centre: DVec3, frame: Frame, area: f64) -> Self {
        let per_lumen = area / photometry.flux().max(f64::MIN_POSITIVE);
        let place = PhotometricPlace { centre, frame, share: 1.0 };
        let downward_share = downward_share(&photometry);
        Self { luminaire: 0, photometry: Arc::new(photometry), place, area, downward_share, per_lumen }
    }

    /// Radiant intensity in a direction of any length, W/sr per W/m² of the lamp's exitance: over the sphere it
    /// adds up to [`Self::area`].
    pub fn intensity(&self, direction: DVec3) -> f64 {
        self.per_lumen * self.photometry.intensity(self.place.frame.local(direction))
    }

    /// The surface of its opening, as [`crate::photometry::Opening::faces`] has it, in the scene, metres.
    pub fn opening(&self) -> Vec<Vec<DVec3>> {
        let mut faces = self.photometry.opening.faces();
        for corner in faces.iter_mut().flatten() {
            *corner = self.place.centre + self.place.frame.world(*corner);
        }
        faces
    }
}

fn downward_share(photometry: &Photometry) -> f64 {
    photometry.distribution.downward_flux() / photometry.flux().max(f64::MIN_POSITIVE)
}

impl Scene {
    /// All that shines by photometry, lamp by lamp.
    pub fn photometric_sources(&self) -> Vec<PhotometricSource> {
        let mut sources = Vec::new();
        for (number, lamp) in (0_u32..).zip(&self.luminaires) {
            let Some(light) = &lamp.photometric else { continue };
            sources.extend(light.places.iter().map(|&place| {
                let area = place.share * lamp.area;
                PhotometricSource {
                    luminaire: number,
                    photometry: Arc::clone(&light.photometry),
                    place,
                    area,
                    downward_share: light.downward_share,
                    per_lumen: area / light.flux,
                }
            }));
        }
        sources
    }
}

/// How a luminaire is turned out of the position in which it shines straight down with C0 along +x.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Attitude {
    /// Degrees about its axis, counter-clockwise as seen from above.
    pub turn: f64,
    /// Degrees about its C0-C180 axis, after that: the nadir swings towards C90.
    pub tilt: f64,
    /// Where its axis is swung to last, the shortest way; a unit vector. Down if none is given.
    pub aim: Option<DVec3>,
}

impl Attitude {
    /// The axes of the luminaire: C0, C90, and away from its nadir.
    pub fn frame(&self, up: UpAxis) -> Frame {
        let up = up.vector();
        let level = Frame::along(up, DVec3::X).turned(self.turn.to_radians());
        let swing = match self.aim {
            // Straight up there is no shortest way.
            Some(aim) if aim.dot(up) > 1.0 - 1e-12 => DQuat::from_rotation_x(std::f64::consts::PI),
            Some(aim) => DQuat::from_rotation_arc(-up, aim),
            None => DQuat::IDENTITY,
        };
        let whole = swing * DQuat::from_axis_angle(level.tangent, self.tilt.to_radians());
        let (tangent, normal) = ((whole * level.tangent).normalize(), (whole * level.normal).normalize());
        Frame::along(normal, tangent)
    }

    /// What is wrong with the angles.
    pub(super) fn fault(&self) -> Option<String> {
        let is_angle = |degrees: f64| (-360.0..=360.0).contains(&degrees);
        if !is_angle(self.turn) || !is_angle(self.tilt) {
            return Some("must have a turn and a tilt between -360 and 360 degrees".to_owned());
        }
        None
    }
}

/// A factor on the light of a luminaire that hangs so, where its lamp burns differently when tilted.
fn tilt_factor(photometry: &Photometry, frame: &Frame, up: UpAxis) -> f64 {
    let tilt = frame.normal.dot(up.vector()).clamp(-1.0, 1.0).acos().to_degrees();
    photometry.tilt.as_ref().map_or(1.0, |factors| factors.factor(tilt))
}

impl PhotometricLight {
    /// Luminaires of one photometry at these centres, metres, that hang alike or not; and the flux of all, lumens.
    /// `None` where they are dark.
    pub(super) fn new(
        photometry: Arc<Photometry>,
        hung: &[(DVec3, Frame)],
        up: UpAxis,
    ) -> Option<(Self, f64)> {
        let factors: Vec<f64> = hung.iter().map(|(_, frame)| tilt_factor(&photometry, frame, up)).collect();
        let sum: f64 = factors.iter().sum();
        let flux = photometry.flux();
        let lumens = sum * flux;
        if !(lumens > 0.0 && lumens.is_finite()) {
            return None;
        }
        let place = |(&(centre, frame), factor): (&(DVec3, Frame), &f64)| PhotometricPlace {
            centre,
            frame,
            share: factor / sum,
        };
        let places = hung.iter().zip(&factors).map(place).collect();
        let downward_share = downward_share(&photometry);
        Some((Self { photometry, places, flux, downward_share }, lumens))
    }
}

/// The photometric files that a sidecar names; each is read once.
pub(super) struct PhotometricFiles<'a> {
    files: Files<'a>,
    known: HashMap<String, (Arc<Photometry>, PathBuf)>,
}

impl<'a> PhotometricFiles<'a> {
    pub(super) fn new(files: Files<'a>) -> Self {
        Self { files, known: HashMap::new() }
    }

    /// The photometry of a file beside the model, or why it cannot be had: the rest of a sentence on the lamp.
    pub(super) fn read(&mut self, name: &str) -> Result<Arc<Photometry>, String> {
        if let Some((known, _)) = self.known.get(name) {
            return Ok(Arc::clone(known));
        }
        let shown = names::short(name);
        let found = self
            .files
            .companion(name)
            .map_err(|error| format!("asks for the photometric file '{shown}', but {}", reason(&error)))?;
        let read = photometry::read(&shown, &found.bytes)
            .map_err(|error| format!("has a photometric file that cannot be used: {error}"))?;
        let read = Arc::new(read);
        self.known.insert(name.to_owned(), (Arc::clone(&read), found.path));
        Ok(read)
    }

    /// Where the files are that were read.
    pub(super) fn paths(&self) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = self.known.values().map(|(_, path)| path.clone()).collect();
        paths.sort();
        paths.dedup();
        paths
    }

    /// What the files that were read say of themselves and what is doubtful about them, by name.
    pub(super) fn findings(&self) -> Vec<Finding> {
        let mut told: Vec<(&String, Severity, String)> = Vec::new();
        for (name, (photometry, _)) in &self.known {
            for doubt in photometry.summary().warnings {
                let is_note = photometry.notes.contains(&doubt);
                told.push((name, if is_note { Severity::Note } else { Severity::Warning }, doubt));
            }
        }
        told.sort_by(|a, b| a.0.cmp(b.0));
        told.into_iter()
            .map(|(name, severity, doubt)| {
                let message = format!("photometric file '{}': {doubt}", names::short(name));
                Finding::new(FindingKind::Lamp, severity, message)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn luminaires_hang_as_they_are_turned_tilted_and_aimed() {
        let near = |a: DVec3, b: DVec3| assert!(a.abs_diff_eq(b, 1e-12), "{a} for {b}");
        let hung = Attitude::default().frame(UpAxis::Y);
        near(hung.tangent, DVec3::X);
        near(hung.bitangent, DVec3::NEG_Z);
        near(hung.normal, DVec3::Y);
        near(Attitude::default().frame(UpAxis::Z).bitangent, DVec3::Y);
        // A quarter turn brings C0 to where C90 was.
        let turned = Attitude { turn: 90.0, ..Attitude::default() }.frame(UpAxis::Z);
        near(turned.tangent, DVec3::Y);
        // Tilted by 90 degrees it shines towards C90.
        let tilted = Attitude { tilt: 90.0, ..Attitude::default() }.frame(UpAxis::Z);
        near(-tilted.normal, DVec3::Y);
        near(tilted.tangent, DVec3::X);
        for aim in [DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.0, -0.8, 0.6)]
        {
            let aimed = Attitude { aim: Some(aim), turn: 30.0, ..Attitude::default() }.frame(UpAxis::Z);
            near(-aimed.normal, aim);
            near(aimed.normal.cross(aimed.tangent), aimed.bitangent);
        }
    }
}
