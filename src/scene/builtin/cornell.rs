//! The measured Cornell box (Cornell University Program of Computer Graphics, 1998), in millimetres.

use super::writer::{Model, Output, Paint};
use glam::{DVec3, dvec3};

/// Measured spectra as linear sRGB reflectances. Its shell is seen from inside alone.
const WHITE: Paint = Paint::solid("white", [0.738, 0.736, 0.739]);
const GREEN: Paint = Paint::solid("green", [0.068, 0.399, 0.087]);
const RED: Paint = Paint::solid("red", [0.494, 0.049, 0.051]);

/// Radiance of the lamp, W/m²/sr, and its reflectance.
const LAMP_RADIANCE: [f64; 3] = [20.79, 10.85, 2.77];
const LAMP_REFLECTANCE: [f64; 3] = [0.78; 3];

pub(crate) fn model() -> Model {
    let mut m = Model::new(("mm", 1e-3), 0.03);
    m.view("Front", [278.0, 273.0, -800.0], [278.0, 273.0, 0.0], 39.3077);
    m.view("Inside", [300.0, 300.0, 20.0], [270.0, 200.0, 559.0], 75.0);
    let lamp = m.lamp("Ceiling lamp", Output::Radiance(LAMP_RADIANCE), true);

    m.object("floor").paint(&WHITE);
    polygon(&mut m, &[[552.8, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 559.2], [549.6, 0.0, 559.2]]);

    // The measured lamp lies in the plane of the ceiling, which is cut around it here.
    let (y, back, right) = (548.8, 559.2, 556.0);
    m.object("ceiling");
    for [x0, x1, z0, z1] in [
        [0.0, right, 0.0, 227.0],
        [0.0, 213.0, 227.0, 332.0],
        [343.0, right, 227.0, 332.0],
        [0.0, right, 332.0, back],
    ] {
        polygon(&mut m, &[[x1, y, z0], [x1, y, z1], [x0, y, z1], [x0, y, z0]]);
    }
    m.glow(lamp, 1.0, LAMP_REFLECTANCE);
    polygon(&mut m, &[[343.0, y, 227.0], [343.0, y, 332.0], [213.0, y, 332.0], [213.0, y, 227.0]]);

    m.object("back_wall").paint(&WHITE);
    polygon(&mut m, &[[549.6, 0.0, back], [0.0, 0.0, back], [0.0, y, back], [right, y, back]]);
    m.object("right_wall").paint(&GREEN);
    polygon(&mut m, &[[0.0, 0.0, back], [0.0, 0.0, 0.0], [0.0, y, 0.0], [0.0, y, back]]);
    m.object("left_wall").paint(&RED);
    polygon(&mut m, &[[552.8, 0.0, 0.0], [549.6, 0.0, back], [right, y, back], [right, y, 0.0]]);

    m.object("short_block").paint(&WHITE);
    prism(&mut m, [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]], 165.0);
    m.object("tall_block");
    prism(&mut m, [[423.0, 247.0], [265.0, 296.0], [314.0, 456.0], [472.0, 406.0]], 330.0);
    m
}

fn polygon(m: &mut Model, corners: &[[f64; 3]]) {
    let corners: Vec<DVec3> = corners.iter().map(|&c| c.into()).collect();
    m.polygon(&corners);
}

/// A block on the floor without its bottom; corners x, z in the measured order of its top.
fn prism(m: &mut Model, corners: [[f64; 2]; 4], height: f64) {
    let at = |k: usize, y: f64| dvec3(corners[k % 4][0], y, corners[k % 4][1]);
    m.polygon(&[at(0, height), at(1, height), at(2, height), at(3, height)]);
    for k in 0..4 {
        m.polygon(&[at(k, 0.0), at(k + 1, 0.0), at(k + 1, height), at(k, height)]);
    }
}
