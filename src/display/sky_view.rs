//! Sky, ground and sun as they are seen where there is no surface.

use crate::scene::{Lighting, Outdoors, Scene};
use glam::DVec3;
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// How strongly sky and sun shine, W/m² per band.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SkyLight {
    /// Irradiance of an unobstructed horizontal surface from the sky; the ground beyond a model follows it.
    pub sky: [f32; 3],
    /// Irradiance of a surface that faces the sun, from the sun alone.
    pub sun: [f32; 3],
}

impl SkyLight {
    /// As the two lamps stand; dark where `lighting` does not have them.
    pub fn of(outdoors: &Outdoors, lighting: &Lighting) -> Self {
        let output = |lamp: u32| {
            lighting
                .lamps
                .get(lamp as usize)
                .map_or([0.0; 3], |state| state.output().map(|watts| watts as f32))
        };
        Self { sky: output(outdoors.sky), sun: output(outdoors.sun) }
    }

    /// Each band times its gain.
    #[must_use]
    pub fn amplified(self, gains: [f32; 3]) -> Self {
        let amplified = |bands: [f32; 3]| std::array::from_fn(|b| bands[b] * gains[b]);
        Self { sky: amplified(self.sky), sun: amplified(self.sun) }
    }
}

/// What is outside of a scene, and how strongly it shines.
#[derive(Clone, Copy, Debug)]
pub struct SkyView<'a> {
    outdoors: &'a Outdoors,
    light: SkyLight,
}

impl<'a> SkyView<'a> {
    /// As the lamps stand; `None` for a scene without daylight.
    pub fn of(scene: &'a Scene, lighting: &Lighting) -> Option<Self> {
        let outdoors = scene.outdoors.as_ref()?;
        Some(Self { outdoors, light: SkyLight::of(outdoors, lighting) })
    }

    /// Radiosity in W/m² per band of a diffuse surface that would look as bright as what lies in a direction
    /// of the model: pi times the radiance of sky or ground, with the sun's disc.
    pub fn radiosity(&self, direction: DVec3) -> [f32; 3] {
        let in_sky = self.outdoors.compass.to_sky(direction);
        let sky = relative(self.outdoors, in_sky) as f32;
        let sun = match sun_chord(self.outdoors) {
            Some(chord) if self.outdoors.daylight.meets_sun(in_sky) => (chord * chord).recip() as f32,
            _ => 0.0,
        };
        std::array::from_fn(|b| self.light.sky[b] * sky + self.light.sun[b] * sun)
    }
}

/// Pi times the radiance of sky or ground in a direction of the sky, per W/m² of the sky's lamp.
fn relative(outdoors: &Outdoors, in_sky: DVec3) -> f64 {
    let unit = outdoors.sky_exitance();
    if unit > 0.0 { PI * outdoors.daylight.radiance(in_sky) / unit } else { 0.0 }
}

/// Distance between unit vectors to the middle and to the edge of the sun's disc; `None` where it does not
/// shine.
///
/// A disc of the solid angle w has the chord sqrt(w / pi), so that the sun's irradiance over the chord's
/// square is pi times its radiance.
fn sun_chord(outdoors: &Outdoors) -> Option<f64> {
    let daylight = &outdoors.daylight;
    let solid_angle = daylight.direct_normal() / daylight.sun_luminance();
    (daylight.direct_normal() > 0.0).then(|| (solid_angle / PI).sqrt())
}

/// Sky and ground as a map by direction, for a graphics card. It depends on the daylight alone and not on how
/// the lamps are switched and dimmed.
#[derive(Clone, Debug)]
pub struct Panorama {
    outdoors: Outdoors,
    sky: Vec<f32>,
}

impl Panorama {
    /// Texels from north clockwise once around.
    pub const COLUMNS: usize = 512;
    /// Texels from the horizon to the zenith, the first and the last ones exactly there.
    pub const ROWS: usize = 128;

    /// Maps the daylight of a scene.
    pub fn new(outdoors: &Outdoors) -> Self {
        let texel = |index: usize| {
            let azimuth = TAU * ((index % Self::COLUMNS) as f64 + 0.5) / Self::COLUMNS as f64;
            let elevation = FRAC_PI_2 * (index / Self::COLUMNS) as f64 / (Self::ROWS - 1) as f64;
            let (east, north) = azimuth.sin_cos();
            let (up, across) = elevation.sin_cos();
            relative(outdoors, DVec3::new(across * east, across * north, up)) as f32
        };
        let sky = (0..Self::COLUMNS * Self::ROWS).into_par_iter().with_min_len(4096).map(texel).collect();
        Self { outdoors: outdoors.clone(), sky }
    }

    /// Pi times the radiance per W/m² of the sky's lamp, row by row from the horizon to the zenith.
    pub fn sky(&self) -> &[f32] {
        &self.sky
    }

    /// The same for the ground, which is evenly bright.
    pub fn ground(&self) -> f32 {
        relative(&self.outdoors, DVec3::NEG_Z) as f32
    }

    /// A vector of the model in the frame of the map: x east, y north, z up.
    pub fn to_sky(&self, in_model: DVec3) -> DVec3 {
        self.outdoors.compass.to_sky(in_model)
    }

    /// Unit vector to the sun in the frame of the map, and the distance from its tip to that of a unit vector
    /// to the edge of the disc; `None` where the sun does not shine. Its irradiance over the square of that
    /// distance is pi times its radiance.
    pub fn sun(&self) -> Option<(DVec3, f64)> {
        Some((self.outdoors.daylight.sun().direction(), sun_chord(&self.outdoors)?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SUN, from_text};

    /// A floor under a clear sky, with the sun at 35 degrees in the south-east.
    fn scene() -> Scene {
        let obj = "mtllib a.mtl\nusemtl white\nv 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nf 1 2 3 4\n";
        let sidecar = "unit = \"m\"\n[daylight]\nsun = [35, 150]\nsky = \"clear\"\n";
        from_text("floor", obj, "newmtl white\nKd .5 .5 .5\n", Some(sidecar)).unwrap()
    }

    #[test]
    fn what_is_seen_is_pi_times_the_radiance_as_the_lamps_stand() {
        let scene = scene();
        let outdoors = scene.outdoors.as_ref().unwrap();
        let mut lighting = scene.lighting();
        let directions = [
            DVec3::new(0.3, 0.8, -0.5),
            DVec3::new(-0.9, 0.01, 0.2),
            DVec3::new(0.1, -0.4, 0.9),
            DVec3::Y,
            DVec3::NEG_Y,
        ];
        let view = SkyView::of(&scene, &lighting).unwrap();
        for direction in directions {
            let expected = PI * outdoors.radiance(direction);
            for seen in view.radiosity(direction) {
                assert!((f64::from(seen) / expected - 1.0).abs() < 1e-5, "{seen} and {expected}");
            }
        }
        // The disc adds its own: irradiance over its solid angle.
        let seen = f64::from(view.radiosity(outdoors.to_sun())[1]);
        let disc = PI * outdoors.sun_exitance() / 6.797e-5;
        assert!(
            (seen / (disc + PI * outdoors.radiance(outdoors.to_sun())) - 1.0).abs() < 1e-3,
            "{seen}, {disc}"
        );
        let aside = outdoors.to_sun().any_orthonormal_vector() * 0.3_f64.to_radians();
        assert!(f64::from(view.radiosity(outdoors.to_sun() + aside)[1]) < 1e-3 * disc, "beside the disc");
        // Half a warm sky, and no sun.
        let sky = &mut lighting.lamps[outdoors.sky as usize];
        (sky.dimmer, sky.exitance[2]) = (0.5, 0.0);
        lighting.lamps[outdoors.sun as usize].on = false;
        let view = SkyView::of(&scene, &lighting).unwrap();
        let (seen, expected) = (view.radiosity(outdoors.to_sun()), PI * outdoors.radiance(outdoors.to_sun()));
        assert!((f64::from(seen[0]) / (0.5 * expected) - 1.0).abs() < 1e-5 && seen[2] == 0.0, "{seen:?}");
        assert_eq!(scene.luminaires[outdoors.sun as usize].name, SUN);
    }

    #[test]
    fn the_map_has_the_sky_and_the_sun() {
        let scene = scene();
        let outdoors = scene.outdoors.as_ref().unwrap();
        let panorama = Panorama::new(outdoors);
        assert_eq!(panorama.sky().len(), Panorama::COLUMNS * Panorama::ROWS);
        // Irradiance of the horizontal over that of the lamp, by rings of the map.
        let step = FRAC_PI_2 / (Panorama::ROWS - 1) as f64;
        let sent: f64 = panorama
            .sky()
            .chunks(Panorama::COLUMNS)
            .enumerate()
            .map(|(row, texels)| {
                let mean = texels.iter().map(|&x| f64::from(x)).sum::<f64>() / Panorama::COLUMNS as f64;
                2.0 * mean * (step * row as f64).sin() * (step * row as f64).cos() * step
            })
            .sum();
        assert!((sent - 1.0).abs() < 2e-3, "{sent}");
        let brightest = panorama.sky().iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap().0;
        let azimuth = 360.0 * ((brightest % Panorama::COLUMNS) as f64 + 0.5) / Panorama::COLUMNS as f64;
        let elevation = (step * (brightest / Panorama::COLUMNS) as f64).to_degrees();
        assert!((azimuth - 150.0).abs() < 0.8 && (elevation - 35.0).abs() < 0.8, "{azimuth}, {elevation}");
        let (to_sun, chord) = panorama.sun().unwrap();
        assert!(to_sun.distance(panorama.to_sky(outdoors.to_sun())) < 1e-12);
        assert!((chord - 0.2665_f64.to_radians()).abs() < 1e-6, "{chord}");
    }
}
