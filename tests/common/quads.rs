//! Models of quads.

use std::fmt::Write as _;

/// Quads with materials and texture coordinates from corner to corner, z up.
#[derive(Default)]
pub(crate) struct Quads {
    pub(crate) text: String,
    count: usize,
}

impl Quads {
    pub(crate) fn quad(mut self, material: &str, corners: [[f64; 3]; 4]) -> Self {
        writeln!(self.text, "o {material} {}\nusemtl {material}", self.count).expect("a string");
        for ([x, y, z], uv) in corners.into_iter().zip(["0 0", "1 0", "1 1", "0 1"]) {
            writeln!(self.text, "v {x} {y} {z}\nvt {uv}").expect("a string");
        }
        self.text += "f -4/-4 -3/-3 -2/-2 -1/-1\n";
        self.count += 1;
        self
    }

    /// A rectangle of constant z, facing up or down.
    pub(crate) fn level(self, material: &str, [x0, y0, x1, y1]: [f64; 4], z: f64, faces_up: bool) -> Self {
        let mut corners = [[x0, y0, z], [x1, y0, z], [x1, y1, z], [x0, y1, z]];
        if !faces_up {
            corners.reverse();
        }
        self.quad(material, corners)
    }

    /// The inside of a box, its walls of one material.
    pub(crate) fn room(self, material: &str, [x1, y1, z1]: [f64; 3]) -> Self {
        self.level(material, [0.0, 0.0, x1, y1], 0.0, true)
            .level(material, [0.0, 0.0, x1, y1], z1, false)
            .quad(material, [[0.0, 0.0, 0.0], [0.0, y1, 0.0], [0.0, y1, z1], [0.0, 0.0, z1]])
            .quad(material, [[x1, y1, 0.0], [x1, 0.0, 0.0], [x1, 0.0, z1], [x1, y1, z1]])
            .quad(material, [[x1, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, z1], [x1, 0.0, z1]])
            .quad(material, [[0.0, y1, 0.0], [x1, y1, 0.0], [x1, y1, z1], [0.0, y1, z1]])
    }
}
