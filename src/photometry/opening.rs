//! The luminous opening of a luminaire: the simple shape that its light comes from.

use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Corners of what stands for a circle, of the same area.
const AROUND: u32 = 12;
/// A line is taken as wide as this share of its length.
const LINE: f64 = 1e-3;

/// The shape of a luminous opening. A disc or cylinder whose two extents differ is an ellipse or elliptical.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OpeningShape {
    /// No extent.
    Point,
    /// Flat and level, or a line where one extent is 0.
    Rectangle,
    /// Flat and level, round.
    Disc,
    /// With luminous sides.
    Box,
    /// Upright, with a luminous side.
    VerticalCylinder,
    /// A sphere or an ellipsoid.
    Ellipsoid,
    /// Horizontal, its axis along C0-C180.
    CylinderAlongC0,
    /// Horizontal, its axis along C90-C270.
    CylinderAlongC90,
    /// Upright and flat, facing C0.
    VerticalDiscFacingC0,
    /// Upright and flat, facing C90.
    VerticalDiscFacingC90,
}

/// A luminous opening: its shape and its extents along the axes of the luminaire, in metres.
///
/// The photometric centre is the middle of the opening. Lengths of LM-63 lie along C0-C180, those of EULUMDAT
/// along C90-C270; here both are given per axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// The shape.
    pub shape: OpeningShape,
    /// Extent along C0-C180, metres.
    pub along_c0: f64,
    /// Extent along C90-C270, metres.
    pub along_c90: f64,
    /// Extent upwards, metres; 0 for level openings.
    pub height: f64,
}

impl Opening {
    /// An opening without extent.
    pub const POINT: Self = Self { shape: OpeningShape::Point, along_c0: 0.0, along_c90: 0.0, height: 0.0 };

    /// Height of the photometric centre above the lowest point of the opening, metres.
    pub fn centre_height(&self) -> f64 {
        0.5 * self.height
    }

    /// Area as seen from below, square metres.
    pub fn level_area(&self) -> f64 {
        let bounds = self.along_c0 * self.along_c90;
        match self.shape {
            OpeningShape::Disc | OpeningShape::VerticalCylinder | OpeningShape::Ellipsoid => {
                bounds * std::f64::consts::FRAC_PI_4
            }
            _ => bounds,
        }
    }

    /// The greatest extent, metres; from about five times this distance on, the opening acts as a point
    /// source.
    pub fn longest(&self) -> f64 {
        self.along_c0.max(self.along_c90).max(self.height)
    }

    /// The surface of the opening as convex polygons in the frame of the luminaire (nadir -z, C0 +x) around the
    /// photometric centre, metres, counter-clockwise as seen from outside: one that faces down or sideways where the
    /// opening is flat, a closed convex body otherwise, none for a point. Circles are polygons of their area.
    pub fn faces(&self) -> Vec<Vec<DVec3>> {
        let longest = self.longest();
        if !(longest > 0.0 && longest.is_finite()) {
            return Vec::new();
        }
        let [x, y, z] =
            [self.along_c0, self.along_c90, self.height].map(|extent| 0.5 * extent.max(LINE * longest));
        let level = [DVec3::X * x, DVec3::NEG_Y * y];
        match self.shape {
            OpeningShape::Point => Vec::new(),
            OpeningShape::Rectangle => vec![rectangle(DVec3::ZERO, level)],
            OpeningShape::Disc => vec![circle(DVec3::ZERO, level)],
            OpeningShape::VerticalDiscFacingC0 => vec![circle(DVec3::ZERO, [DVec3::Y * y, DVec3::Z * z])],
            OpeningShape::VerticalDiscFacingC90 => {
                vec![circle(DVec3::ZERO, [DVec3::NEG_X * x, DVec3::Z * z])]
            }
            OpeningShape::Box => prism(rectangle(DVec3::NEG_Z * z, level), DVec3::Z * (2.0 * z)),
            OpeningShape::VerticalCylinder => prism(circle(DVec3::NEG_Z * z, level), DVec3::Z * (2.0 * z)),
            OpeningShape::CylinderAlongC0 => {
                prism(circle(DVec3::NEG_X * x, [DVec3::Z * z, DVec3::Y * y]), DVec3::X * (2.0 * x))
            }
            OpeningShape::CylinderAlongC90 => {
                prism(circle(DVec3::NEG_Y * y, [DVec3::X * x, DVec3::Z * z]), DVec3::Y * (2.0 * y))
            }
            OpeningShape::Ellipsoid => ellipsoid(DVec3::new(x, y, z)),
        }
    }
}

/// Counter-clockwise as seen from where `a` x `b` points.
fn rectangle(middle: DVec3, [a, b]: [DVec3; 2]) -> Vec<DVec3> {
    [-a - b, a - b, a + b, b - a].map(|corner| middle + corner).to_vec()
}

fn circle(middle: DVec3, [a, b]: [DVec3; 2]) -> Vec<DVec3> {
    let step = TAU / f64::from(AROUND);
    let larger = (step / step.sin()).sqrt();
    (0..AROUND)
        .map(|k| {
            let (sin, cos) = ((f64::from(k) + 0.5) * step).sin_cos();
            middle + (a * cos + b * sin) * larger
        })
        .collect()
}

/// The body between a polygon, as seen from outside, and the same `up` of it.
fn prism(bottom: Vec<DVec3>, up: DVec3) -> Vec<Vec<DVec3>> {
    let n = bottom.len();
    let mut faces: Vec<Vec<DVec3>> = (0..n)
        .map(|k| {
            let (a, b) = (bottom[k], bottom[(k + 1) % n]);
            vec![b, a, a + up, b + up]
        })
        .collect();
    faces.push(bottom.iter().rev().map(|&corner| corner + up).collect());
    faces.push(bottom);
    faces
}

fn ellipsoid(half: DVec3) -> Vec<Vec<DVec3>> {
    let rings = AROUND / 2;
    let at = |i: u32, j: u32| {
        let (sin, cos) = (PI * f64::from(j) / f64::from(rings)).sin_cos();
        let (y, x) = (TAU * f64::from(i % AROUND) / f64::from(AROUND)).sin_cos();
        match j {
            0 => half * DVec3::Z,
            j if j == rings => half * DVec3::NEG_Z,
            _ => half * DVec3::new(sin * x, sin * y, cos),
        }
    };
    let mut faces = Vec::new();
    for j in 0..rings {
        for i in 0..AROUND {
            let mut face = vec![at(i, j), at(i, j + 1), at(i + 1, j + 1), at(i + 1, j)];
            face.dedup();
            if face.first() == face.last() {
                face.pop();
            }
            faces.push(face);
        }
    }
    faces
}

/// The meaning of LM-63's signed width (along C90), length (along C0) and height, in metres, and a note where
/// the signs have no meaning.
///
/// `year` is that of the standard: negative width and height without length mean a sphere in 1995 and an
/// upright disc since 2002; width and length of opposite signs with a negative height mean an ellipsoid until
/// 1995 and a horizontal cylinder since (LM-63-1986, -1995, -2002 and -2019, tables of luminous dimensions).
pub(super) fn of_lm_63(year: u16, width: f64, length: f64, height: f64) -> (Opening, Option<String>) {
    use OpeningShape as Shape;
    let sign = |value: f64| if value == 0.0 { 0 } else { value.signum() as i8 };
    let new = year >= 2002;
    let (w, l, h) = (width.abs(), length.abs(), height.abs());
    let made = |shape, along_c0, along_c90, height| Opening { shape, along_c0, along_c90, height };
    let opening = match (sign(width), sign(length), sign(height)) {
        (0, 0, 0) => Opening::POINT,
        (0 | 1, 0 | 1, 0) => made(Shape::Rectangle, l, w, 0.0),
        (0 | 1, 0 | 1, 1) => made(Shape::Box, l, w, h),
        // Both negative: round; before 2002 the width alone is the diameter.
        (-1, -1, 0) => made(Shape::Disc, l, w, 0.0),
        (-1, -1, 1) => made(Shape::VerticalCylinder, l, w, h),
        (-1, -1, _) => made(Shape::Ellipsoid, l, w, h),
        (-1, 0, 0) => made(Shape::Disc, w, w, 0.0),
        (-1, 0, 1) => made(Shape::VerticalCylinder, w, w, h),
        (-1, 0, _) if !new => made(Shape::Ellipsoid, w, w, w),
        (-1, 0, _) => made(Shape::VerticalDiscFacingC0, 0.0, w, h),
        (0, -1, -1) if new => made(Shape::VerticalDiscFacingC90, l, 0.0, h),
        // One negative.
        (-1, 1, 0) | (1, -1, 0) => made(Shape::Disc, l, w, 0.0),
        (-1, 1, 1) if year < 1995 => made(Shape::Ellipsoid, l, w, h),
        (-1, 1, 1) | (1, -1, 1) => made(Shape::VerticalCylinder, l, w, h),
        (-1, 1, _) if new => made(Shape::CylinderAlongC0, l, w, h),
        (1, -1, _) if new => made(Shape::CylinderAlongC90, l, w, h),
        (-1, 1, _) | (1, -1, _) => made(Shape::Ellipsoid, l, w, h),
        // Horizontal cylinders of 1995: the height is the diameter.
        (0, 1, -1) => made(Shape::CylinderAlongC0, l, h, h),
        (1, 0, -1) => made(Shape::CylinderAlongC90, h, w, h),
        _ => {
            let shape = if h > 0.0 { Shape::Box } else { Shape::Rectangle };
            let note = format!(
                "the signs of the opening's width, length and height ({width}, {length}, {height} m) have \
                no meaning in LM-63: it is taken as a box"
            );
            return (made(shape, l, w, h), Some(note));
        }
    };
    (opening, None)
}

/// EULUMDAT's luminous area: length (or diameter, where the width is 0) along C90, width along C0 and the
/// greatest of the four luminous heights, in metres.
pub(super) fn of_eulumdat(length: f64, width: f64, height: f64) -> Opening {
    let round = width == 0.0;
    let shape = match (length > 0.0 || width > 0.0, height > 0.0, round) {
        (false, false, _) => return Opening::POINT,
        (_, false, true) => OpeningShape::Disc,
        (_, false, false) => OpeningShape::Rectangle,
        (_, true, true) => OpeningShape::VerticalCylinder,
        (_, true, false) => OpeningShape::Box,
    };
    Opening { shape, along_c0: if round { length } else { width }, along_c90: length, height }
}
