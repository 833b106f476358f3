//! Small facets that share unknowns: a ball of thousands of facets in a closed room lights it, and is lit, as a ball
//! whose facets have a patch each.

mod common;

use common::{Model, lines, mean, rows, solved};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::{Patch, PatchTarget};
use lumenwalk::scene::Scene;
use lumenwalk::solve::{Solution, prepare};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How many patches are asked for.
const ASKED: usize = 1500;

/// A room of 4 m x 3 m x 5 m with a lamp in its ceiling, and a ball of such rings of flat fields, red below.
fn room_with_ball(rings: usize, around: usize) -> Arc<Scene> {
    let mut m = Model::new();
    m.grey("wall", 0.6).grey("light", 0.7).paint("red", [0.6, 0.2, 0.2], [0.0; 3]);
    m.paint("glow", [0.0; 3], [40.0; 3]);
    let wall = Some("wall");
    m.room(DVec3::ZERO, dvec3(4.0, 3.0, 5.0), [wall, None, wall, wall, wall, wall]);
    m.object("ceiling").ceiling_with_lamp("wall", [4.0, 3.0, 5.0], [1.5, 2.5, 2.0, 3.0]);
    // As much surface as a ball of 0.6 m, however many facets it has.
    let facets = globe(dvec3(1.6, 1.0, 2.2), 0.6, rings, around);
    m.object("ball");
    for (ring, facet) in facets {
        m.polygon(if 2 * ring >= rings { "red" } else { "light" }, &facet);
    }
    m.scene()
}

/// Triangles of a ball that look outwards, each with its ring from the top, scaled to the surface of the sphere.
fn globe(centre: DVec3, radius: f64, rings: usize, around: usize) -> Vec<(usize, [DVec3; 3])> {
    let at = |ring: usize, k: usize| {
        let (polar, azimuth) = (PI * ring as f64 / rings as f64, TAU * (k % around) as f64 / around as f64);
        radius * dvec3(polar.sin() * azimuth.cos(), polar.cos(), polar.sin() * azimuth.sin())
    };
    let mut facets: Vec<(usize, [DVec3; 3])> = Vec::new();
    for ring in 0..rings {
        for k in 0..around {
            let [a, b, c, d] = [at(ring, k), at(ring, k + 1), at(ring + 1, k + 1), at(ring + 1, k)];
            if ring > 0 {
                facets.push((ring, [a, b, c]));
            }
            if ring + 1 < rings {
                facets.push((ring, [a, c, d]));
            }
        }
    }
    let area: f64 = facets.iter().map(|(_, [a, b, c])| 0.5 * (*b - *a).cross(*c - *a).length()).sum();
    let scale = (4.0 * PI * radius * radius / area).sqrt();
    facets.iter().map(|(ring, facet)| (*ring, facet.map(|c| centre + c * scale))).collect()
}

/// Mean irradiance on the patches of each object, the ball's by material, in the first band.
fn means(solved: &Solution) -> Vec<(String, f64)> {
    let light = solved.light(&solved.scene.lighting());
    let name = |p: &Patch| {
        let object = &solved.scene.objects[solved.mesh.regions[p.region as usize].object as usize];
        format!("{object} {}", solved.scene.materials[p.material as usize].name)
    };
    let patches = &solved.mesh.patches;
    let mut names: Vec<String> = patches.iter().map(name).collect();
    names.sort();
    names.dedup();
    let value = |i: usize| f64::from(light.irradiance[i][0]);
    let of = |wanted: &String| {
        let chosen: Vec<usize> = (0..patches.len()).filter(|&i| name(&patches[i]) == *wanted).collect();
        mean(patches, &chosen, value)
    };
    names.iter().map(|n| (n.clone(), of(n))).collect()
}

#[test]
fn a_ball_of_clusters_is_lit_and_lights_as_one_of_single_facets() {
    let single = solved(&room_with_ball(30, 36), &lines(PatchTarget::Count(ASKED)));
    let shared = solved(&room_with_ball(110, 60), &lines(PatchTarget::Count(ASKED)));
    assert!(single.mesh.clusters.is_empty());
    assert!(shared.mesh.clusters.len() > 50, "{} clusters", shared.mesh.clusters.len());
    let (patches, asked) = (shared.mesh.patches.len() as f64, ASKED as f64);
    assert!(patches < 1.5 * asked && patches > asked / 1.5, "{patches} for {asked}");
    for ((name, alone), (_, together)) in means(&single).into_iter().zip(means(&shared)) {
        let off = together / alone - 1.0;
        println!("{name}: {alone:.3} W/m², {together:.3} with clusters, {:+.2} %", 100.0 * off);
        assert!(off.abs() < 0.03, "{name}: {together} W/m² for {alone}");
    }
    let light = shared.light(&shared.scene.lighting());
    let (mut emitted, mut absorbed) = (0.0, 0.0);
    for (i, p) in shared.mesh.patches.iter().enumerate() {
        let [b, h] = [light.radiosity[i][0], light.irradiance[i][0]].map(f64::from);
        emitted += p.area * (b - p.reflectance[0] * h);
        absorbed += p.area * (1.0 - p.reflectance[0]) * h;
    }
    assert!((absorbed / emitted - 1.0).abs() < 1e-4, "{absorbed} W of {emitted} W absorbed in a closed room");
}

#[test]
fn rows_of_clusters_obey_the_laws_of_closed_scenes_before_they_are_balanced() {
    let scene = room_with_ball(110, 60);
    let prepared = prepare(scene, &lines(PatchTarget::Count(ASKED))).expect("a mesh");
    let mesh = &prepared.mesh;
    let rows = rows(&prepared);
    let (mut out, mut back, mut area) = (0.0, 0.0, 0.0);
    for (patch, row) in mesh.patches.iter().zip(&rows) {
        assert!((row.sum() - 1.0).abs() < 5e-3, "a row of a closed room sums to {}", row.sum());
        let to = |cluster: bool| -> f64 {
            let seen = row.patches.iter().zip(&row.values);
            seen.filter(|(j, _)| mesh.patches[**j as usize].is_cluster == cluster)
                .map(|(_, f)| f64::from(*f))
                .sum()
        };
        if patch.is_cluster {
            area += patch.area;
            out += patch.area * to(false);
            // A ball sees nothing of itself.
            assert!(to(true) < 5e-3, "{} of a cluster's row falls on the ball", to(true));
        } else {
            back += patch.area * to(true);
        }
        for piece in mesh.pieces_of(patch) {
            let region = &mesh.regions[piece.region as usize];
            assert_eq!(region.material, patch.material, "a patch of two materials");
            assert_eq!(mesh.patches[piece.patches[patch.side as usize] as usize].area, patch.area);
            let cosine = mesh.normal_of(piece, patch.side).dot(patch.normal);
            assert!(cosine > -0.35, "facets of a cluster face one way: {cosine}");
        }
    }
    assert!((out / area - 1.0).abs() < 5e-3, "{out} m² of {area} m²");
    assert!((back / out - 1.0).abs() < 0.02, "{back} m² seen from the walls, {out} m² from the ball");
}
