//! Windings, sides and outlines.

use crate::common::{Model, assembled, builtin, lines};
use crate::geometry::room;
use crate::laws::{Kind, hold, hold_model};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::Sides;
use lumenwalk::validate::scenes;
use std::sync::Arc;

/// Mean irradiance over the floor.
fn on_the_floor(scene: &Arc<lumenwalk::scene::Scene>) -> f64 {
    let made = assembled(scene, &lines(PatchTarget::Count(400)));
    let irradiance = made.irradiance(&made.system(None), 1e-7);
    made.mean(&made.of(|o| o == "floor"), |i| f64::from(irradiance[i][0]))
}

#[test]
fn flipped_and_mixed_windings_do_not_matter() {
    let scene = room().scene();
    let expected = on_the_floor(&scene);
    for (name, flip) in [("all", 1), ("every second", 2), ("every third", 3)] {
        let mut flipped = (*scene).clone();
        for surface in flipped.surfaces.iter_mut().filter(|s| s.luminaire.is_none()).step_by(flip) {
            surface.corners.reverse();
        }
        let flipped = Arc::new(flipped);
        hold(&format!("{name} flipped"), &flipped, Kind::Closed);
        let found = on_the_floor(&flipped);
        // Rows are turned with their surfaces, so that their sampling errors differ.
        crate::common::close(&format!("{name} flipped"), found, expected, 2e-3);
    }
}

#[test]
fn sides_are_taken_by_their_word() {
    for (name, sides) in [("one-sided", Sides::Front), ("two-sided", Sides::Both)] {
        let mut scene = scenes::room_with_blocks(0.5).read(None).unwrap();
        scene.materials.iter_mut().for_each(|m| m.sides = sides);
        // The outside of a room that is lit from inside sees nothing, but takes part.
        hold(name, &Arc::new(scene), if sides == Sides::Front { Kind::Closed } else { Kind::Open });
    }
}

#[test]
fn a_closed_box_from_outside() {
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    m.block("box", "paint", DVec3::ZERO, DVec3::ONE);
    m.object("lamp").quad("glow", dvec3(0.2, 2.0, 0.2), DVec3::X, DVec3::Z);
    hold_model("a box under a lamp in space", &m, Kind::Open);
}

#[test]
fn the_measured_cornell_box_with_its_wall_that_is_not_planar() {
    hold("Cornell box", &builtin("cornell"), Kind::Open);
}

#[test]
fn concave_outlines_and_bridges() {
    hold_model("L-shaped room", &scenes::l_shaped_room(0.5).into(), Kind::Closed);
    // A ceiling with a hole cut by a bridge, and the lamp in the hole.
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    let paint = Some("paint");
    m.room(DVec3::ZERO, DVec3::splat(3.0), [paint, None, paint, paint, paint, paint]);
    let at = |x: f64, z: f64| dvec3(x, 3.0, z);
    m.object("ceiling").polygon(
        "paint",
        &[
            at(0.0, 0.0),
            at(3.0, 0.0),
            at(3.0, 3.0),
            at(0.0, 3.0),
            at(0.0, 0.0),
            at(1.0, 1.0),
            at(1.0, 2.0),
            at(2.0, 2.0),
            at(2.0, 1.0),
            at(1.0, 1.0),
        ],
    );
    m.object("lamp").quad("glow", at(1.0, 1.0), DVec3::X, DVec3::Z);
    hold_model("a hole by a bridge", &m, Kind::Closed);
    // A star-shaped room.
    let corner = |k: usize, y: f64| {
        let (angle, r) =
            (k as f64 * std::f64::consts::TAU / 10.0, if k.is_multiple_of(2) { 3.0 } else { 1.2 });
        dvec3(r * angle.cos(), y, r * angle.sin())
    };
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [20.0; 3]);
    m.object("floor").polygon("paint", &(0..10).rev().map(|k| corner(k, 0.0)).collect::<Vec<_>>());
    m.object("ceiling").polygon("glow", &(0..10).map(|k| corner(k, 2.0)).collect::<Vec<_>>());
    for k in 0..10 {
        let (a, b) = (corner(k, 0.0), corner((k + 1) % 10, 0.0));
        m.object(&format!("wall_{k}")).quad("paint", a, b - a, 2.0 * DVec3::Y);
    }
    hold_model("a star", &m, Kind::Closed);
}
