//! Rows as they are sampled. Balancing gives every row of a closed scene its sum and makes all rows reciprocal,
//! whatever hides what, so that what rows see is held here before it: against rays that try all surfaces, and
//! against the laws of physics.

mod common;

use common::{Model, builtin, rows, settings};
use glam::{DVec2, DVec3};
use lumenwalk::form_factors::{Method, ReceivingPoints, Row};
use lumenwalk::geometry::Frame;
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::Scene;
use lumenwalk::solve::{Prepared, SolveSettings, prepare};
use lumenwalk::validate::scenes::{cluttered_room, l_shaped_room, room_with_blocks, rooms_in_a_row};
use std::sync::Arc;

const METHODS: [(Method, u32); 3] = [(Method::Lines, 192), (Method::Hemicube, 256), (Method::Rays, 4096)];

/// Closed scenes in which much hides much else, and by how much what their surfaces send to each other may differ
/// there and back: boxes that are cut through share patches with what is inside of others.
fn closed() -> Vec<(&'static str, Arc<Scene>, f64)> {
    let scene = |model: lumenwalk::validate::Model| Model::from(model).scene();
    vec![
        ("two blocks", scene(room_with_blocks(0.5)), 0.01),
        ("an L-shaped room", scene(l_shaped_room(0.5)), 0.01),
        ("three rooms with doors", scene(rooms_in_a_row(3, 0.5)), 0.01),
        ("six boxes cut through each other", scene(cluttered_room(6, 5)), 0.1),
        ("hemicube", builtin("hemicube"), 0.02),
    ]
}

fn prepared(scene: &Arc<Scene>, method: Method, resolution: u32, points: ReceivingPoints) -> Prepared {
    let settings = SolveSettings { points, ..settings(PatchTarget::Count(400), method, resolution) };
    prepare(scene.clone(), &settings).expect("a mesh")
}

/// The surfaces of a scene as outlines in their planes: nothing of the program's own geometry.
struct Outlines(Vec<(DVec3, Frame, Vec<DVec2>)>);

impl Outlines {
    fn new(scene: &Scene) -> Self {
        let outline = |surface| {
            let corners: Vec<DVec3> = scene.polygon(surface);
            let twice_area =
                |k: usize| (corners[k] - corners[0]).cross(corners[(k + 1) % corners.len()] - corners[0]);
            let frame = Frame::around((0..corners.len()).map(twice_area).sum::<DVec3>().normalize());
            let flat = corners.iter().map(|&c| frame.local(c - corners[0]).truncate()).collect();
            (corners[0], frame, flat)
        };
        Self(scene.surfaces.iter().map(outline).collect())
    }

    /// The lowest surface in the plane of each surface: patches may run over several in one plane.
    fn planes(&self) -> Vec<usize> {
        let in_plane = |(at, frame, _): &(DVec3, Frame, Vec<DVec2>), other: &(DVec3, Frame, Vec<DVec2>)| {
            frame.normal.cross(other.1.normal).length() < 1e-6 && frame.normal.dot(other.0 - *at).abs() < 1e-6
        };
        let lowest =
            |surface| self.0.iter().position(|other| in_plane(surface, other)).expect("itself at least");
        self.0.iter().map(lowest).collect()
    }

    /// The surface that a ray meets first.
    fn met(&self, origin: DVec3, direction: DVec3) -> Option<usize> {
        let mut nearest = (f64::INFINITY, None);
        for (index, (at, frame, corners)) in self.0.iter().enumerate() {
            let distance = (*at - origin).dot(frame.normal) / direction.dot(frame.normal);
            if distance > 0.0 && distance < nearest.0 {
                let p = frame.local(origin + direction * distance - *at).truncate();
                let crosses = |k: &usize| {
                    let (a, b) = (corners[*k], corners[(k + 1) % corners.len()]);
                    (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x)
                };
                if (0..corners.len()).filter(crosses).count() % 2 == 1 {
                    nearest = (distance, Some(index));
                }
            }
        }
        nearest.1
    }

    /// What a point sees of each surface by so many rays; they cover disk and azimuth evenly (R2, Roberts 2018).
    fn seen_from(&self, point: DVec3, normal: DVec3, rays: u32) -> Vec<f64> {
        let mut seen = vec![0.0; self.0.len()];
        let frame = Frame::around(normal);
        for k in 0..rays {
            let at = |step: f64| (0.5 + step * f64::from(k)).fract();
            let (u, azimuth) = (at(0.754_877_666_246_693), std::f64::consts::TAU * at(0.569_840_290_998_053));
            let direction = DVec3::new(u.sqrt() * azimuth.cos(), u.sqrt() * azimuth.sin(), (1.0 - u).sqrt());
            if let Some(met) = self.met(point + 1e-6 * normal, frame.world(direction)) {
                seen[met] += 1.0 / f64::from(rays);
            }
        }
        seen
    }
}

#[test]
fn rows_see_what_rays_see_that_try_every_surface() {
    for (name, scene, _) in closed() {
        let outlines = Outlines::new(&scene);
        let planes = outlines.planes();
        for (method, resolution) in METHODS {
            let prepared = prepared(&scene, method, resolution, ReceivingPoints::One);
            let patches = &prepared.mesh.patches;
            let open: Vec<usize> = (0..patches.len()).filter(|&i| !patches[i].buried).collect();
            let mut scratch = prepared.computer.scratch();
            let (mut worst, mut sum, mut count) = (0.0_f64, 0.0, 0.0);
            for &i in open.iter().step_by(open.len() / 40) {
                let row = prepared.computer.row(i as u32, &mut scratch);
                let mut difference = vec![0.0; planes.len()];
                let seen = outlines.seen_from(patches[i].centre, patches[i].normal, 4096);
                planes.iter().zip(seen).for_each(|(&plane, f)| difference[plane] += f);
                for (&j, &f) in row.patches.iter().zip(&row.values) {
                    difference[planes[patches[j as usize].surface as usize]] -= f64::from(f);
                }
                let apart = 0.5 * difference.iter().map(|d| d.abs()).sum::<f64>();
                worst = worst.max(apart);
                (sum, count) = (sum + apart, count + 1.0);
            }
            println!("{name}, {method:?}: {:.4} of a row on average, at most {worst:.4}", sum / count);
            // The rays' own error is some 0.003.
            assert!(sum / count < 0.006, "{name}, {method:?}: {} of a row is of other surfaces", sum / count);
            assert!(worst < 0.015, "{name}, {method:?}: {worst} of a row is of other surfaces");
        }
    }
}

/// Radiosity of each patch in a furnace of these reflectances by the rows as sampled; 1 where nothing gets lost.
fn furnace(rows: &[Row], active: &[usize], rho: impl Fn(usize) -> f64) -> Vec<f64> {
    let mut b = vec![1.0; rows.len()];
    active.iter().for_each(|&i| b[i] = 1.0 - rho(i));
    for _ in 0..400 {
        for &i in active {
            let row = rows[i].patches.iter().zip(&rows[i].values);
            let irradiance: f64 = row.map(|(&j, &f)| f64::from(f) * b[j as usize]).sum();
            b[i] = 1.0 - rho(i) + rho(i) * irradiance;
        }
    }
    b
}

#[test]
fn rows_as_sampled_obey_the_laws_of_closed_scenes() {
    for (name, scene, most) in closed() {
        for (method, resolution) in METHODS {
            let prepared = prepared(&scene, method, resolution, ReceivingPoints::default());
            let (patches, rows) = (&prepared.mesh.patches, rows(&prepared));
            let active: Vec<usize> = (0..patches.len()).filter(|&i| !patches[i].buried).collect();
            let row = active.iter().map(|&i| (rows[i].sum() - 1.0).abs()).fold(0.0, f64::max);
            let b = furnace(&rows, &active, |i| 0.9 * (0.618_033_988_749_895 * i as f64).fract());
            let furnace = active.iter().map(|&i| (b[i] - 1.0).abs()).fold(0.0, f64::max);
            // What surfaces send to each other is the same both ways.
            let surfaces = scene.surfaces.len();
            let mut exchange = vec![0.0; surfaces * surfaces];
            for &i in &active {
                let from = patches[i].surface as usize * surfaces;
                for (&j, &f) in rows[i].patches.iter().zip(&rows[i].values) {
                    exchange[from + patches[j as usize].surface as usize] += patches[i].area * f64::from(f);
                }
            }
            let (mut gap, mut mean) = (0.0, 0.0);
            for a in 0..surfaces {
                for b in 0..a {
                    let (out, back): (f64, f64) = (exchange[a * surfaces + b], exchange[b * surfaces + a]);
                    gap += (out - back).abs();
                    mean += 0.5 * (out + back);
                }
            }
            let reciprocity = gap / mean;
            println!(
                "{name}, {method:?}: rows {row:.1e}, furnace {furnace:.1e}, reciprocity {reciprocity:.4}"
            );
            assert!(row < 1e-6, "{name}, {method:?}: a row is off by {row}");
            assert!(furnace < 1e-6, "{name}, {method:?}: a furnace is off by {furnace}");
            assert!(reciprocity < most, "{name}, {method:?}: reciprocity is off by {reciprocity}");
        }
    }
}
