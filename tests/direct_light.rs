//! Direct light held against shadow rays and closed forms, and the elements that carry it.

use glam::DVec3;
use lumenwalk::direct::{DirectLight, ElementSettings, Elements, NO_ELEMENT, Scratch};
use lumenwalk::geometry::{Bvh, Ray};
use lumenwalk::mesh::{self, MeshSettings, PatchMesh, PatchTarget};
use lumenwalk::scene::{SceneSource, load};
use lumenwalk::watch::Watch;
use std::collections::{HashMap, HashSet};
use std::f64::consts::{PI, TAU};

fn meshed(name: &str, patches: usize) -> PatchMesh {
    let scene = load(&SceneSource::from(name)).expect("a scene");
    let settings = MeshSettings { target: PatchTarget::Count(patches), ..MeshSettings::default() };
    mesh::build(&scene, &settings).expect("a mesh")
}

/// Irradiance at a point by a grid of shadow rays to each triangle of each lamp, finer where it is near: W/m² per
/// W/m² of exitance in the green band, a value per lamp.
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
                let size = a.distance(b).max(b.distance(c)).max(c.distance(a));
                let near = [a, b, c, (a + b + c) / 3.0].map(|p| p.distance(point));
                let near = near.into_iter().fold(f64::INFINITY, f64::min);
                let n = (16.0 * size / near.max(1e-9)).clamp(4.0, 160.0) as u32;
                for i in 0..n * n {
                    let of = |k: u32| (f64::from(k) + 0.5) / f64::from(n);
                    let (root, v) = (of(i % n).sqrt(), of(i / n));
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
                    let form_factor = cos * cos_lamp / (PI * distance.powi(4)) * area / f64::from(n * n);
                    sums[lamp as usize] += patch.emission_weight[1] * form_factor;
                }
            }
        }
    }
    sums
}

/// The same by the program: a value per lamp.
fn exact(light: &DirectLight, point: DVec3, normal: DVec3, lamps: usize, scratch: &mut Scratch) -> Vec<f64> {
    let mut sums = vec![0.0; lamps];
    light.at(point, normal, true, scratch, |basis, value| {
        let basis = light.emitters().bases[basis as usize];
        sums[basis.lamp as usize] += value * basis.weight[1];
    });
    sums
}

#[test]
fn direct_light_is_that_of_shadow_rays_in_every_embedded_scene() {
    // The rest is the noise of the rays, which see a slit before a vault by a few of them.
    let scenes = [
        ("hemicube", 1500, 7, 3e-3),
        ("cornell", 1500, 7, 6e-3),
        ("gallery", 3000, 61, 1.5e-2),
        ("house", 5000, 91, 1.5e-2),
    ];
    for (name, patches, step, most) in scenes {
        let mesh = meshed(&format!("builtin:{name}"), patches);
        let lamps = mesh.patches.iter().filter_map(|p| p.luminaire).max().map_or(0, |l| l as usize + 1);
        let light = DirectLight::new(&mesh, true);
        let bvh = Bvh::build(&mesh.triangles().0);
        let mut scratch = Scratch::default();
        let (mut squares, mut sum, mut count) = (0.0, 0.0, 0.0);
        for patch in mesh.patches.iter().filter(|p| !p.buried && p.luminaire.is_none()).step_by(step) {
            let rays = by_rays(&mesh, &bvh, patch.centre, patch.normal, lamps);
            let found = exact(&light, patch.centre, patch.normal, lamps, &mut scratch);
            for (found, rays) in found.iter().zip(&rays) {
                squares += (found - rays) * (found - rays);
                sum += rays;
            }
            count += 1.0;
        }
        let (error, mean) = (f64::sqrt(squares / count), sum / count);
        println!("{name}: {:.3} % of the mean", 100.0 * error / mean);
        assert!(error < most * mean, "{name}: {error} of {mean}");
    }
}

/// A floor, and above it a globe of `n` x `n / 2` facets and radius 0.2 at a height of 2.
fn globe(n: u32) -> PatchMesh {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("globe.obj");
    let mut text = "mtllib globe.mtl\nv -1 0 -1\nv -1 0 1\nv 1 0 1\nv 1 0 -1\n".to_owned();
    let rows = n / 2;
    for j in 0..=rows {
        for i in 0..n {
            let (phi, theta) = (TAU * f64::from(i) / f64::from(n), PI * f64::from(j) / f64::from(rows));
            let [x, y, z] = [theta.sin() * phi.cos(), theta.cos(), theta.sin() * phi.sin()].map(|c| 0.2 * c);
            text += &format!("v {x} {} {z}\n", y + 2.0);
        }
    }
    text += "usemtl grey\nf 1 2 3 4\nusemtl lamp\n";
    let at = |i: u32, j: u32| 5 + j * n + i % n;
    for j in 0..rows {
        for i in 0..n {
            let quad = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            let corners = match j {
                0 => vec![at(0, 0), quad[2], quad[3]],
                _ if j + 1 == rows => vec![quad[0], quad[1], at(0, rows)],
                _ => quad.to_vec(),
            };
            text += &format!("f {}\n", corners.iter().map(u32::to_string).collect::<Vec<_>>().join(" "));
        }
    }
    std::fs::write(&path, text).expect("written");
    let materials = "newmtl grey\nKd 0.5 0.5 0.5\nnewmtl lamp\nKd 0 0 0\nKe 1 1 1\n";
    std::fs::write(folder.path().join("globe.mtl"), materials).expect("written");
    let scene = load(&SceneSource::File(path)).expect("a scene");
    let settings = MeshSettings { target: PatchTarget::Count(200), ..MeshSettings::default() };
    mesh::build(&scene, &settings).expect("a mesh")
}

#[test]
fn a_globe_of_thousands_of_facets_lights_as_a_sphere_does() {
    let mesh = globe(72);
    let light = DirectLight::new(&mesh, true);
    assert_eq!(light.emitters().sources.len(), 1, "one convex body");
    let mut scratch = Scratch::default();
    for (x, z) in [(0.0, 0.0), (0.5, -0.3), (-0.9, 0.9)] {
        let point = DVec3::new(x, 0.0, z);
        let to = DVec3::new(0.0, 2.0, 0.0) - point;
        // Lambert: sin² of the sphere's half angle times the cosine to its middle.
        let sphere = 0.04 / to.length_squared() * to.normalize().y;
        let found = exact(&light, point, DVec3::Y, 1, &mut scratch)[0];
        assert!((found / sphere - 1.0).abs() < 5e-3, "{found} for {sphere} at {point}");
    }
}

fn elements_of(mesh: &PatchMesh, light: &DirectLight, error: f64, most: usize) -> Elements {
    let exitance = vec![1.0; light.emitters().bases.len()];
    let settings = ElementSettings { error, most, work: u64::MAX, exitance, smooth: true, focus: None };
    Watch::nobody(|watch| Elements::build(mesh, light, &settings, watch)).expect("not cancelled")
}

#[test]
fn elements_meet_edge_to_edge_and_hold_every_point_of_their_triangles() {
    let mesh = meshed("builtin:gallery", 800);
    let light = DirectLight::new(&mesh, true);
    let elements = elements_of(&mesh, &light, 0.02, 4000);
    let roots = elements.roots.iter().filter(|&&root| root != NO_ELEMENT).count();
    assert!(elements.leaves().count() > roots + 1000, "divided: {} of {roots}", elements.leaves().count());
    // 1. No corner that was added lies within an edge.
    let of_mesh = elements.elements[..roots].iter().flat_map(|root| root.corners).max().expect("roots");
    let mut times: HashMap<(u32, u32), u32> = HashMap::new();
    for leaf in elements.leaves() {
        for k in 0..3 {
            let (a, b) = (leaf.corners[k], leaf.corners[(k + 1) % 3]);
            *times.entry((a.min(b), a.max(b))).or_default() += 1;
        }
    }
    let mut beside: HashMap<u32, HashSet<u32>> = HashMap::new();
    for &(a, b) in times.keys() {
        beside.entry(a).or_default().insert(b);
        beside.entry(b).or_default().insert(a);
    }
    let at = |corner: u32| elements.corners[corner as usize].position;
    for (&(a, b), &times) in &times {
        assert!(times <= 2, "an edge of {times} elements");
        let middle = 0.5 * (at(a) + at(b));
        let within =
            beside[&a].intersection(&beside[&b]).any(|&c| c > of_mesh && at(c).distance(middle) < 1e-9);
        assert!(!within, "a corner in the middle of the edge at {middle}");
    }
    // 2. A place is found again by the weights of the corners.
    for (side, &root) in elements.roots.iter().enumerate().filter(|entry| *entry.1 != NO_ELEMENT).step_by(7) {
        let of = |element: u32, weights: [f64; 3]| -> DVec3 {
            let corners = elements.positions(&elements.elements[element as usize]);
            corners.iter().zip(weights).map(|(&p, w)| p * w).sum()
        };
        let (u, v) = ((side as f64 * 0.618).fract(), (side as f64 * 0.324).fract());
        let weights = if u + v > 1.0 { [u + v - 1.0, 1.0 - u, 1.0 - v] } else { [1.0 - u - v, u, v] };
        let (leaf, inside) = elements.locate(root, weights);
        assert!(inside.iter().all(|&w| w > -1e-12), "{inside:?}");
        assert!(of(root, weights).distance(of(leaf, inside)) < 1e-12);
    }
}

#[test]
fn light_between_the_corners_of_elements_is_what_a_point_there_gets() {
    let mesh = meshed("builtin:hemicube", 1000);
    let light = DirectLight::new(&mesh, true);
    let mut scratch = Scratch::default();
    let mut off = |elements: &Elements| {
        let (mut squares, mut sum, mut area) = (0.0, 0.0, 0.0);
        for (k, leaf) in elements.leaves().enumerate() {
            let patch = &mesh.patches[leaf.patch as usize];
            if patch.buried || patch.luminaire.is_some() {
                continue;
            }
            let r = [0.618, 0.414].map(|step| (k as f64 * step).fract());
            let root = r[0].sqrt();
            let weights = [1.0 - root, root * (1.0 - r[1]), root * r[1]];
            let place: DVec3 = elements.positions(leaf).iter().zip(weights).map(|(&p, w)| p * w).sum();
            let shown: f64 = leaf
                .corners
                .iter()
                .zip(weights)
                .map(|(&c, w)| elements.light_at(c).iter().map(|entry| f64::from(entry.1)).sum::<f64>() * w)
                .sum();
            let truth = exact(&light, place, patch.normal, 1, &mut scratch)[0];
            let own = elements.area(leaf);
            squares += own * (shown - truth).powi(2);
            sum += own * truth;
            area += own;
        }
        f64::sqrt(squares / area) / (sum / area)
    };
    let coarse = off(&elements_of(&mesh, &light, 1.0, 0));
    let fine = elements_of(&mesh, &light, 0.003, 60_000);
    let [told, fine] = [fine.expected_error, off(&fine)];
    println!(
        "undivided {:.2} %, divided {:.2} %, expected {:.2} %",
        100.0 * coarse,
        100.0 * fine,
        100.0 * told
    );
    assert!(fine < 0.01 && fine < 0.2 * coarse, "{fine} after {coarse}");
}
