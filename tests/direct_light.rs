//! Direct light held against shadow rays and closed forms.

use glam::DVec3;
use lumenwalk::direct::{DirectLight, ElementSettings, Elements, NO_ELEMENT, Scratch};
use lumenwalk::geometry::{Bvh, Ray};
use lumenwalk::mesh::{self, MeshSettings, PatchMesh, PatchTarget};
use lumenwalk::scene::{SceneSource, load};
use lumenwalk::watch::Watch;
use std::time::Instant;

fn meshed(name: &str, patches: usize) -> PatchMesh {
    let scene = load(&SceneSource::from(name)).expect("a scene");
    let settings = MeshSettings { target: PatchTarget::Count(patches), ..MeshSettings::default() };
    mesh::build(&scene, &settings).expect("a mesh")
}

/// Irradiance at a point by a grid of shadow rays to each triangle of each lamp, a value per lamp.
fn by_rays(mesh: &PatchMesh, bvh: &Bvh, point: DVec3, normal: DVec3, lamps: usize) -> Vec<f64> {
    let mut sums = vec![0.0; lamps];
    let offset = 1e-6 * mesh.size;
    for patch in &mesh.patches {
        let Some(lamp) = patch.luminaire else { continue };
        for piece in mesh.pieces_of(patch) {
            let corners = mesh.polygon(piece, patch.side);
            for k in 1..corners.len() - 1 {
                let [a, b, c] = [corners[0], corners[k], corners[k + 1]];
                let area = 0.5 * (b - a).cross(c - a).length();
                // Finer where it is near.
                let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let near = point
                    .distance(a)
                    .min(point.distance(b))
                    .min(point.distance(c))
                    .min(point.distance((a + b + c) / 3.0));
                let n = (16.0 * size / near.max(1e-9)).clamp(4.0, 160.0) as u32;
                for i in 0..n * n {
                    let (u, v) =
                        ((f64::from(i % n) + 0.5) / f64::from(n), (f64::from(i / n) + 0.5) / f64::from(n));
                    let root = u.sqrt();
                    let to = a * (1.0 - root) + b * (root * (1.0 - v)) + c * (root * v) - point;
                    let (cos, cos_lamp) = (normal.dot(to), -patch.normal.dot(to));
                    if cos <= 0.0 || cos_lamp <= 0.0 {
                        continue;
                    }
                    let distance = to.length();
                    let ray = Ray { origin: point, direction: to / distance };
                    if bvh.occluded(&ray, offset, distance - offset) {
                        continue;
                    }
                    let form_factor = cos * cos_lamp / (std::f64::consts::PI * distance.powi(4)) * area;
                    sums[lamp as usize] += patch.emission_weight[1] * form_factor / f64::from(n * n);
                }
            }
        }
    }
    sums
}

#[test]
fn direct_light_agrees_with_shadow_rays_in_every_embedded_scene() {
    for (name, patches, step) in [
        ("builtin:hemicube", 1500, 7),
        ("builtin:cornell", 1500, 7),
        ("builtin:gallery", 3000, 31),
        ("builtin:house", 5000, 61),
    ] {
        let mesh = meshed(name, patches);
        let lamps = mesh.patches.iter().filter_map(|p| p.luminaire).max().map_or(0, |l| l as usize + 1);
        let clock = Instant::now();
        let light = DirectLight::new(&mesh);
        let built = clock.elapsed().as_secs_f64();
        let bvh = Bvh::build(&mesh.triangles().0);
        let mut scratch = Scratch::default();
        let (mut square, mut mean, mut count, mut seconds, mut viewing) = (0.0, 0.0, 0, 0.0, 0.0);
        let mut worst = (0.0, DVec3::ZERO, 0.0, 0.0);
        for patch in mesh.patches.iter().filter(|p| !p.buried && p.luminaire.is_none()).step_by(step) {
            let rays = by_rays(&mesh, &bvh, patch.centre, patch.normal, lamps);
            let mut exact = vec![0.0; lamps];
            let clock = Instant::now();
            let views = light.views(&[patch.centre; 3], patch.normal, &mut scratch);
            viewing += clock.elapsed().as_secs_f64();
            light.gather(patch.centre, patch.normal, &views, &mut scratch, |basis, value| {
                let basis = light.emitters().bases[basis as usize];
                exact[basis.lamp as usize] += value * basis.weight[1];
            });
            seconds += clock.elapsed().as_secs_f64();
            for lamp in 0..lamps {
                let error = exact[lamp] - rays[lamp];
                square += error * error;
                mean += rays[lamp];
                if f64::abs(error) > 0.001 {
                    println!(
                        "   {lamp} at {} n {}: {} by {}",
                        patch.centre, patch.normal, exact[lamp], rays[lamp]
                    );
                }
                if f64::abs(error) > f64::abs(worst.0) {
                    worst = (error, patch.centre, exact[lamp], rays[lamp]);
                }
            }
            count += 1;
        }
        let count = f64::from(count);
        let (rms, mean) = ((square / count).sqrt(), mean / count);
        println!(
            "{name}: {} emitters, {} bases, built in {built:.3} s, {:.1} us a point ({:.1} views), rms {:.3} % worst {worst:?}",
            light.emitters().sources.len(),
            light.emitters().bases.len(),
            1e6 * seconds / count,
            1e6 * viewing / count,
            100.0 * rms / mean
        );
        println!("{}", rms < 0.02 * mean);
        assert!(rms < 0.5 * mean, "{name}: {rms} of {mean}");
    }
}

#[test]
fn elements_follow_shadows() {
    for (name, patches) in [
        ("builtin:hemicube", 1500),
        ("builtin:cornell", 1500),
        ("builtin:gallery", 3000),
        ("builtin:house", 5000),
    ] {
        let mesh = meshed(name, patches);
        let light = DirectLight::new(&mesh);
        let exitance = vec![1.0; light.emitters().bases.len()];
        for error in [0.03, 0.01] {
            let settings = ElementSettings { error, most: 200_000, exitance: exitance.clone(), smooth: true };
            let clock = Instant::now();
            let elements = Watch::nobody(|watch| Elements::build(&mesh, &light, &settings, watch))
                .expect("not cancelled");
            println!(
                "{name} {error}: {} roots, {} leaves, {} corners, expected {:.3} %, {:.2} s",
                elements.roots.iter().filter(|&&r| r != NO_ELEMENT).count(),
                elements.leaves().count(),
                elements.corners.len(),
                100.0 * elements.expected_error,
                clock.elapsed().as_secs_f64()
            );
        }
    }
}
