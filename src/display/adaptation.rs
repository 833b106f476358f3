use crate::scene::{Lighting, Scene, luminance_weighted};

/// Share of the way to white that eyes adapt in a room lit by coloured light.
const ADAPTATION: f64 = 0.65;

/// The lamps as they come with the file; all of them on where none is.
pub fn usual_lighting(scene: &Scene) -> Lighting {
    let mut lighting = scene.lighting();
    if lighting.lamps.iter().all(|lamp| !lamp.on) {
        lighting.lamps.iter_mut().for_each(|lamp| lamp.on = true);
    }
    lighting
}

/// Factors per band that turn the light of the lamps towards white: as much by the lamps as they
/// stand, on average over `lightings`, as by those of the file. They keep luminance and act on what
/// is shown alone, never on what was solved; 1 where nobody would adapt.
pub fn white_balance(scene: &Scene, lightings: &[&Lighting]) -> [f32; 3] {
    let usual = chromaticity(scene, &usual_lighting(scene));
    let share = 1.0 / lightings.len().max(1) as f64;
    let mut flux = usual;
    for lighting in lightings {
        let now = chromaticity(scene, lighting);
        for band in 0..3 {
            flux[band] += share * now[band];
        }
    }
    white_gains(flux)
}

/// Flux of the lamps per band at luminance one; black where nothing shines.
fn chromaticity(scene: &Scene, lighting: &Lighting) -> [f64; 3] {
    let mut flux = [0.0; 3];
    for (luminaire, lamp) in scene.luminaires.iter().zip(&lighting.lamps) {
        for (sum, output) in flux.iter_mut().zip(lamp.output()) {
            *sum += output * luminaire.area;
        }
    }
    let total = luminance_weighted(flux);
    if total > 0.0 { flux.map(|f| f / total) } else { [0.0; 3] }
}

/// Von Kries (1902) in the three bands, in part, and without a change of luminance.
fn white_gains(flux: [f64; 3]) -> [f32; 3] {
    let mean = luminance_weighted(flux);
    if mean <= 0.0 || flux.iter().any(|&f| f <= 0.01 * mean) {
        return [1.0; 3];
    }
    let gains = flux.map(|f| (mean / f).powf(ADAPTATION));
    let after = luminance_weighted(std::array::from_fn(|b| gains[b] * flux[b]));
    gains.map(|g| (g * mean / after) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneSource, load};

    #[test]
    fn warm_light_is_turned_towards_white_and_keeps_its_luminance() {
        let warm = [2.0, 1.0, 0.35];
        let gains = white_gains(warm).map(f64::from);
        let after: [f64; 3] = std::array::from_fn(|b| warm[b] * gains[b]);
        assert!((luminance_weighted(after) - luminance_weighted(warm)).abs() < 1e-6);
        let ratio = after[0] / after[2];
        assert!(ratio > 1.2 && ratio < 0.5 * warm[0] / warm[2], "still warm, but less so: {ratio}");
        assert_eq!(white_gains([1.0; 3]), [1.0; 3]);
        assert_eq!(white_gains([1.0, 0.0, 0.0]), [1.0; 3], "nobody adapts to one band");
    }

    #[test]
    fn lamps_that_are_off_leave_the_balance_to_those_of_the_file() {
        let scene = load(&SceneSource::from("builtin:cornell")).expect("an embedded scene");
        let on = scene.lighting();
        let mut off = on.clone();
        off.lamps.iter_mut().for_each(|lamp| lamp.on = false);
        let (lit, dark) = (white_balance(&scene, &[&on]), white_balance(&scene, &[&off]));
        for band in 0..3 {
            assert!((lit[band] - dark[band]).abs() < 1e-6, "{lit:?} {dark:?}");
        }
        assert!(lit[0] < 1.0 && lit[2] > 1.0, "a warm lamp: {lit:?}");
        assert_eq!(usual_lighting(&scene).lamps.len(), scene.luminaires.len());
    }
}
