//! Lamps of thousands of facets: globes and bulbs, met by few half-planes a facet.

mod common;

use common::{Model, lines, solved};
use glam::{DVec3, dvec3};
use lumenwalk::form_factors::closed_form::point_to_polygon;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::solve::Solution;
use lumenwalk::study;
use std::f64::consts::{PI, TAU};

/// Exitance of each facet, W/m².
const EXITANCE: f64 = 1000.0;

/// Triangles of a sphere that look outwards: two for each of `rings` by `around` fields, one at the poles.
fn globe(centre: DVec3, radius: f64, rings: usize, around: usize) -> Vec<[DVec3; 3]> {
    let at = |ring: usize, k: usize| {
        let (polar, azimuth) = (PI * ring as f64 / rings as f64, TAU * (k % around) as f64 / around as f64);
        centre + radius * dvec3(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin())
    };
    let mut facets = Vec::new();
    for ring in 0..rings {
        for k in 0..around {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            if ring > 0 {
                facets.push([a, b, c]);
            }
            if ring + 1 < rings {
                facets.push([a, c, d]);
            }
        }
    }
    facets
}

fn facet_normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (*b - *a).cross(*c - *a).normalize()
}

/// Irradiance on an element that sees every facet which faces it: Lambert's formula, facet by facet.
fn exact(facets: &[[DVec3; 3]], point: DVec3, normal: DVec3, visible: &dyn Fn(DVec3) -> bool) -> f64 {
    facets
        .iter()
        .filter(|facet| facet_normal(facet).dot(point - facet[0]) > 0.0)
        .flat_map(|facet| parts(*facet))
        .filter(|part| visible((part[0] + part[1] + part[2]) / 3.0))
        .map(|part| EXITANCE * point_to_polygon(point, normal, &part))
        .sum()
}

/// A facet in four, each of which is seen or not.
fn parts([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let [d, e, f] = [0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)];
    [[a, f, e], [f, b, d], [e, d, c], [d, e, f]]
}

fn add(m: &mut Model, name: &str, material: &str, facets: &[[DVec3; 3]]) {
    m.object(name);
    for facet in facets {
        m.polygon(material, facet);
    }
}

/// Mean and largest magnitude of these relative errors, mean signed.
fn told(what: &str, errors: &[f64]) -> (f64, f64) {
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    let worst = errors.iter().map(|e| e.abs()).fold(0.0, f64::max);
    println!("{what}: {} places, mean {:+.3} %, worst {:.3} %", errors.len(), 100.0 * mean, 100.0 * worst);
    (mean, worst)
}

/// Points on and over the floor, looking up, aside and towards the lamp.
fn probes(lamp: DVec3) -> Vec<(DVec3, DVec3)> {
    let mut probes = Vec::new();
    for k in 0..40 {
        let turn = |share: f64| (0.37 + share * f64::from(k)).fract();
        let point = dvec3(3.6 * turn(0.754_877_67) - 1.8, 1.2 * turn(0.287), 3.6 * turn(0.569_840_29) - 1.8);
        let aside = dvec3(turn(0.618) - 0.5, 0.4, turn(0.414) - 0.5).normalize();
        probes.extend([DVec3::Y, aside, (lamp - point).normalize()].map(|normal| (point, normal)));
    }
    probes
}

fn errors_at(solved: &Solution, probes: &[(DVec3, DVec3)], exact: impl Fn(DVec3, DVec3) -> f64) -> Vec<f64> {
    let lighting = solved.scene.lighting();
    let found = study::points(solved, &lighting, &solved.light(&lighting), probes);
    let largest = probes.iter().map(|&(p, n)| exact(p, n)).fold(0.0, f64::max);
    let compared = probes.iter().zip(found).map(|(&(p, n), h)| (h.irradiance[0], exact(p, n)));
    // Of what hardly sees the lamp little can be told.
    compared.filter(|(_, exact)| *exact > 0.02 * largest).map(|(h, exact)| h / exact - 1.0).collect()
}

#[test]
fn a_globe_of_thousands_of_facets_is_as_bright_as_a_sphere() {
    let lamp = dvec3(0.1, 2.0, -0.05);
    for (radius, rings, around) in [(0.1, 26, 100), (0.2, 26, 100), (0.15, 12, 24), (0.15, 50, 200)] {
        let facets = globe(lamp, radius, rings, around);
        let mut m = Model::new();
        m.grey("black", 0.0).paint("glow", [0.0; 3], [EXITANCE; 3]);
        m.object("floor").quad("black", dvec3(-2.0, 0.0, -2.0), DVec3::Z * 4.0, DVec3::X * 4.0);
        add(&mut m, "globe", "glow", &facets);
        let solved = solved(&m.scene(), &lines(PatchTarget::Size(0.3)));
        let what = format!("{} facets of radius {radius} m", facets.len());

        // Free points.
        let sees_all = |_: DVec3| true;
        let errors = errors_at(&solved, &probes(lamp), |p, n| exact(&facets, p, n, &sees_all));
        assert!(errors.len() > 60);
        let (mean, worst) = told(&format!("{what}, points"), &errors);
        assert!(mean.abs() < 0.005, "{what}: {mean}");
        assert!(worst < 0.015, "{what}: {worst}");

        // Patches of the floor, against (r / d)² cos t of a sphere with as much surface.
        let surface: f64 = facets.iter().map(|f| 0.5 * (f[1] - f[0]).cross(f[2] - f[0]).length()).sum();
        let sphere = |p: DVec3| {
            let to = lamp - p;
            EXITANCE * surface / (4.0 * PI) * to.y / to.length().powi(3)
        };
        let light = solved.light(&solved.scene.lighting());
        let patches =
            solved.mesh.patches.iter().zip(&light.irradiance).filter(|(p, _)| p.luminaire.is_none());
        let errors: Vec<f64> = patches
            .map(|(patch, h)| {
                let piece = solved.mesh.pieces_of(patch).next().expect("a piece");
                let corners = solved.mesh.polygon(piece, patch.side);
                // Gauss points of a rectangle.
                let (u, v) = (corners[1] - corners[0], corners[3] - corners[0]);
                let nodes = [0.112_701_665, 0.5, 0.887_298_335];
                let weights = [5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0];
                let mut mean = 0.0;
                for (s, ws) in nodes.into_iter().zip(weights) {
                    for (t, wt) in nodes.into_iter().zip(weights) {
                        mean += ws * wt * sphere(corners[0] + u * s + v * t);
                    }
                }
                f64::from(h[0]) / mean - 1.0
            })
            .collect();
        let (mean, worst) = told(&format!("{what}, patches"), &errors);
        assert!(mean.abs() < 0.005, "{what}: {mean}");
        assert!(worst < 0.015, "{what}: {worst}");
    }
}

#[test]
fn a_bulb_within_a_shade_sends_what_the_shade_lets_through() {
    // A bulb in an upright pipe of 48 facets, open above and below.
    let lamp = dvec3(0.1, 2.0, -0.05);
    let facets = globe(lamp, 0.05, 20, 40);
    let mut m = Model::new();
    m.grey("black", 0.0).paint("glow", [0.0; 3], [EXITANCE; 3]);
    m.object("floor").quad("black", dvec3(-2.0, 0.0, -2.0), DVec3::Z * 4.0, DVec3::X * 4.0);
    add(&mut m, "bulb", "glow", &facets);
    let rim = |k: usize, y: f64| {
        let azimuth = TAU * (k % 48) as f64 / 48.0;
        lamp + dvec3(0.12 * azimuth.cos(), y, 0.12 * azimuth.sin())
    };
    m.object("shade");
    for k in 0..48 {
        m.polygon("black", &[rim(k, -0.06), rim(k, 0.1), rim(k + 1, 0.1), rim(k + 1, -0.06)]);
    }
    let solved = solved(&m.scene(), &lines(PatchTarget::Size(0.3)));
    let rays = solved.computer.rays();
    let errors =
        errors_at(&solved, &probes(lamp), |p, n| exact(&facets, p, n, &|from: DVec3| rays.visible(from, p)));
    assert!(errors.len() > 30, "{}", errors.len());
    let (mean, worst) = told("bulb in a shade, points", &errors);
    assert!(mean.abs() < 0.005, "{mean}");
    // Deep in the penumbra few facets are left, and each that the rim cuts is seen in part by one line or ray.
    assert!(worst < 0.06, "{worst}");
}

#[test]
fn a_bowl_that_shines_inwards_hides_nothing_twice() {
    // Facets of the lower half of a sphere, turned inwards, seen over their rim: many are hidden by others.
    let lamp = dvec3(0.0, 1.5, 0.0);
    let bowl: Vec<[DVec3; 3]> = globe(lamp, 0.2, 36, 72)
        .into_iter()
        .filter(|f| f.iter().all(|p| p.y < lamp.y + 1e-9))
        .map(|[a, b, c]| [a, c, b])
        .collect();
    assert!(bowl.len() > 2000);
    let mut m = Model::new();
    m.grey("black", 0.0).paint("glow", [0.0; 3], [EXITANCE; 3]);
    m.object("ceiling").quad("black", dvec3(-2.0, 3.0, -2.0), DVec3::X * 4.0, DVec3::Z * 4.0);
    add(&mut m, "bowl", "glow", &bowl);
    let solved = solved(&m.scene(), &lines(PatchTarget::Size(0.3)));
    // What leaves the opening is what leaves a disk there: a polygon of 72 corners.
    let rim: Vec<DVec3> = (0..72)
        .map(|k| TAU * f64::from(k) / 72.0)
        .map(|azimuth| lamp + 0.2 * dvec3(azimuth.cos(), 0.0, azimuth.sin()))
        .collect();
    let above: Vec<(DVec3, DVec3)> =
        probes(lamp).into_iter().map(|(p, n)| (p.with_y(p.y + 1.7), -n)).collect();
    let errors = errors_at(&solved, &above, |p, n| EXITANCE * point_to_polygon(p, n, &rim));
    assert!(errors.len() > 60, "{}", errors.len());
    let (mean, worst) = told("bowl, points", &errors);
    assert!(mean.abs() < 0.005, "{mean}");
    // Where little but the rim's own facets is seen, each of them counts as hidden in part by one line.
    assert!(worst < 0.025, "{worst}");
}
