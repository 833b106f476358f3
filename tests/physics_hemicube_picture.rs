//! What Cohen and Greenberg 1985 point out in their picture, on the room made after it.

mod common;

use common::{Assembled, assembled, builtin, lines, mean};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::illuminance;
use lumenwalk::solve::Solution;
use std::sync::{Arc, LazyLock};

/// The room as it is, and its light; solved once for all tests.
static ROOM: LazyLock<(Assembled, Solution)> = LazyLock::new(|| {
    let scene = builtin("hemicube");
    (assembled(&scene, &lines(PatchTarget::Auto)), common::solved(&scene, &lines(PatchTarget::Auto)))
});

/// Irradiance of all patches, with the red and the blue wall painted grey if asked for.
fn irradiance(grey_walls: bool) -> Vec<[f32; 3]> {
    let made = &ROOM.0;
    let materials = &made.prepared.scene.materials;
    let reflectance: Vec<[f64; 3]> = made
        .patches()
        .iter()
        .map(|p| match materials[p.material as usize].name.as_str() {
            "red" | "blue" if grey_walls => [0.25; 3],
            _ => p.reflectance,
        })
        .collect();
    made.irradiance(&made.system(Some(&reflectance)), 1e-6)
}

fn at(points: &[DVec3], normal: DVec3) -> Vec<[f64; 3]> {
    let solution = &ROOM.1;
    let light = solution.light(&solution.scene.lighting());
    let lifted: Vec<(DVec3, DVec3)> = points.iter().map(|&p| (p, normal)).collect();
    solution.irradiance_at(&lifted, &light)
}

#[test]
fn colours_bleed_onto_the_boxes() {
    let made = &ROOM.0;
    let (colour, grey) = (irradiance(false), irradiance(true));
    // Red over blue on some faces, against the same with grey walls: the lamp's own colour falls out.
    let tint = |faces: &[usize]| {
        let ratio = |h: &[[f32; 3]]| {
            mean(made.patches(), faces, |i| h[i][0].into()) / mean(made.patches(), faces, |i| h[i][2].into())
        };
        ratio(&colour) / ratio(&grey)
    };
    // The white box stands beside the red wall, and between it and the yellow one.
    for object in ["white_box", "yellow_box"] {
        let towards = |sign: f64| -> Vec<usize> {
            let faces = made.of(|o| o == object);
            faces.into_iter().filter(|&i| sign * made.patches()[i].normal.x > 0.8).collect()
        };
        let top: Vec<usize> =
            made.of(|o| o == object).into_iter().filter(|&i| made.patches()[i].normal.y > 0.8).collect();
        // The top looks at the white ceiling: what is redder than it leans to one wall, what is bluer
        // to the other.
        let (to_red, above, to_blue) = (tint(&towards(-1.0)), tint(&top), tint(&towards(1.0)));
        assert!(to_red > 1.02 * above, "{object}: {to_red} times as red towards the red wall, {above} above");
        assert!(
            to_blue < 0.9 * above,
            "{object}: {to_blue} times as red towards the blue wall, {above} above"
        );
        assert!(
            to_red > 1.25 * to_blue,
            "{object}: {to_red} towards the red wall, {to_blue} towards the blue"
        );
    }
}

#[test]
fn a_red_shadow_lies_beside_the_box_next_to_the_red_wall() {
    // On the floor between the red wall and the white box; as far from the blue wall; and further
    // along the red wall, where no box stands.
    let spots = at(&[dvec3(0.2, 0.0, 1.15), dvec3(3.0, 0.0, 1.15), dvec3(0.2, 0.0, 2.9)], DVec3::Y);
    let [shadow, mirrored, open] = [spots[0], spots[1], spots[2]];
    let redness = |h: [f64; 3]| h[0] / h[2];
    assert!(
        illuminance(shadow) < 0.6 * illuminance(mirrored),
        "{shadow:?} beside the box, {mirrored:?} opposite"
    );
    assert!(
        illuminance(shadow) < 0.6 * illuminance(open),
        "{shadow:?} beside the box, {open:?} along the wall"
    );
    assert!(redness(shadow) > 1.3 * redness(mirrored), "{} and {}", redness(shadow), redness(mirrored));
    assert!(redness(shadow) > 1.1 * redness(open), "{} and {}", redness(shadow), redness(open));
}

#[test]
fn brightness_falls_along_the_walls() {
    // Away from the lamp, which hangs over x 1.1 to 2.1, z 1.2 to 2.2: along the front wall to both
    // sides, and along the blue wall towards the front.
    let front = |x: f64, y: f64| dvec3(x, y, 4.0);
    let runs: [(&str, Vec<DVec3>, DVec3); 3] = [
        ("front wall to the left", (0..8).map(|k| front(1.6 - 0.2 * f64::from(k), 1.8)).collect(), -DVec3::Z),
        (
            "front wall to the right",
            (0..8).map(|k| front(1.6 + 0.2 * f64::from(k), 1.8)).collect(),
            -DVec3::Z,
        ),
        ("blue wall", (0..9).map(|k| dvec3(3.2, 2.0, 1.9 + 0.25 * f64::from(k))).collect(), -DVec3::X),
    ];
    for (name, points, normal) in runs {
        let lux: Vec<f64> = at(&points, normal).into_iter().map(illuminance).collect();
        for pair in lux.windows(2) {
            assert!(pair[1] < pair[0], "{name}: {lux:.0?}");
        }
        assert!(lux[lux.len() - 1] < 0.85 * lux[0], "{name}: {lux:.0?}");
    }
}

#[test]
fn two_ways_to_the_same_light_agree() {
    let (made, solution) = (&ROOM.0, &ROOM.1);
    assert_eq!(made.patches().len(), solution.mesh.patches.len());
    let scene: &Arc<_> = &solution.scene;
    let whole = solution.light(&scene.lighting()).irradiance;
    let direct = solution.element_light.as_ref().map(|elements| &elements.given);
    let parts = made.irradiance(&made.system(None).with_direct(direct), 1e-6);
    let largest = whole.iter().flatten().copied().fold(0.0, f32::max);
    for (a, b) in whole.iter().flatten().zip(parts.iter().flatten()) {
        assert!((a - b).abs() < 2e-4 * largest, "{a} and {b}");
    }
}
