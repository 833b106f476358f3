//! Traps for whoever samples: small lamps, gratings, louvres, edges along the lines.

use crate::common::{METHODS, Model, assembled, lines, settings};
use crate::geometry::room;
use crate::laws::{Kind, hold_model, swept};
use glam::{DVec3, dvec3};
use lumenwalk::mesh::PatchTarget;

#[test]
fn a_lamp_smaller_than_any_cell_is_never_lost() {
    for size in [0.1, 0.01, 1e-3, 1e-4] {
        let mut m = Model::new();
        m.grey("paint", 0.5).paint("glow", [0.5; 3], [1.0 / (size * size); 3]);
        m.room(DVec3::ZERO, dvec3(10.0, 4.0, 10.0), [Some("paint"); 6]);
        let at = dvec3(5.03, 3.9, 4.91);
        m.object("lamp").quad("glow", at, DVec3::X * size, DVec3::Z * size);
        hold_model(&format!("a lamp of {size} m"), &m, Kind::Closed);
        for (method, resolution) in METHODS {
            let made =
                assembled(&m.scene(), &settings(PatchTarget::Count(300), method, resolution.min(4096)));
            let (bases, _) = swept(&made, &made.system(None), 1e-5);
            let irradiance = bases.mix(&made.prepared.mesh, &made.lighting(), &[]).irradiance;
            let rooms = made.of(|o| o != "lamp");
            let absorbed = made.area(&rooms) * made.mean(&rooms, |i| 0.5 * f64::from(irradiance[i][0]));
            // One watt, absorbed by the walls.
            assert!((absorbed - 1.0).abs() < 2e-3, "{size} m by {}: {absorbed} W", method.name());
        }
    }
}

#[test]
fn louvres_and_gratings() {
    // A lamp recessed in a housing behind louvres.
    let mut m = Model::new();
    m.grey("paint", 0.5).paint("glow", [0.5; 3], [200.0; 3]);
    let all = Some("paint");
    m.room(DVec3::ZERO, dvec3(3.0, 3.0, 3.0), [all, None, all, all, all, all]);
    m.object("ceiling");
    for (x, z, dx, dz) in
        [(0.0, 0.0, 3.0, 1.2), (0.0, 1.2, 1.2, 0.6), (1.8, 1.2, 1.2, 0.6), (0.0, 1.8, 3.0, 1.2)]
    {
        m.quad("paint", dvec3(x, 3.0, z), DVec3::X * dx, DVec3::Z * dz);
    }
    let (low, high) = (dvec3(1.2, 3.0, 1.2), dvec3(1.8, 3.3, 1.8));
    m.room(low, high, [None, Some("glow"), all, all, all, all]);
    m.object("louvres");
    for k in 1..12 {
        let z = 1.2 + 0.05 * f64::from(k);
        m.quad("paint", dvec3(1.2, 3.0, z), DVec3::X * 0.6, DVec3::Y * 0.05);
    }
    hold_model("louvres", &m, Kind::Closed);

    // Bars whose spacing beats with the lines.
    let mut m = room();
    m.object("grating");
    for k in 0..24 {
        m.quad("paint", dvec3(0.15 * f64::from(k) + 0.2, 2.0, 0.5), DVec3::X * 0.075, DVec3::Z * 4.0);
    }
    hold_model("a grating", &m, Kind::Closed);
}

#[test]
fn a_thousand_coincident_vertices() {
    // A cone of a thousand triangles with one apex each, all in one place.
    let mut m = room();
    m.object("cone");
    let apex = dvec3(2.0, 1.5, 2.5);
    let rim = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k % 1000) / 1000.0;
        dvec3(2.0 + 0.8 * angle.cos(), 0.2, 2.5 + 0.8 * angle.sin())
    };
    for k in 0..1000 {
        m.polygon("paint", &[apex, rim(k + 1), rim(k)]);
    }
    let made = crate::laws::hold_with(
        "a cone",
        &m.scene(),
        // Its base is open: the inside sees the floor alone.
        Kind::Closed,
        &lines(PatchTarget::Count(400)),
    );
    assert!(made.patches().len() > 1000);
}

#[test]
fn surfaces_along_the_axes_of_every_receiver() {
    // Steps whose edges run through the middle of patches and along the axes of their frames.
    let mut m = room();
    for k in 0..6 {
        let x = 0.5 * f64::from(k);
        m.block(
            &format!("step_{k}"),
            "paint",
            dvec3(x, 0.0, 0.0),
            dvec3(x + 0.5, 0.25 * f64::from(k + 1), 1.0),
        );
    }
    hold_model("steps", &m, Kind::Closed);
}

#[test]
fn the_solver_does_not_stop_before_the_light_of_a_small_lamp_is_right() {
    let mut m = Model::new();
    m.grey("paint", 0.9).paint("glow", [0.5; 3], [1e6; 3]);
    m.room(DVec3::ZERO, dvec3(10.0, 4.0, 10.0), [Some("paint"); 6]);
    m.object("lamp").quad("glow", dvec3(5.03, 3.9, 4.91), DVec3::X * 1e-3, DVec3::Z * 1e-3);
    let made = assembled(&m.scene(), &lines(PatchTarget::Count(300)));
    let (_, reports) = made.sweep(&made.system(None), 1e-4);
    let last = reports.last().unwrap();
    let missing = (last.absorbed + last.escaped - last.emitted).abs() / last.emitted;
    assert!(missing < 1e-3, "{missing} of the power is missing after {} sweeps", last.sweep);
}
