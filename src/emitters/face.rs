use super::{Emitter, HalfSpace};
use crate::geometry::polygon;
use glam::DVec3;

/// A convex flat face of a lamp that shines by Lambert's law towards its front.
#[derive(Clone, Debug, PartialEq)]
pub struct Face {
    corners: Vec<DVec3>,
    normal: DVec3,
    region: u32,
    /// Nearer to its plane than this nothing is in front of it, metres.
    thickness: f64,
}

impl Face {
    /// `corners` run counter-clockwise as seen from where it shines, metres; it is a part of a region of the mesh.
    pub fn new(corners: Vec<DVec3>, region: u32, thickness: f64) -> Self {
        let normal = polygon::area_vector(&corners).normalize_or_zero();
        Self { corners, normal, region, thickness }
    }

    /// Unit normal of the side that shines.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }
}

impl Emitter for Face {
    fn hull(&self) -> &[DVec3] {
        &self.corners
    }

    fn is_part(&self, region: u32) -> bool {
        self.region == region
    }

    fn outline(&self, from: DVec3, corners: &mut Vec<DVec3>) -> Option<HalfSpace> {
        corners.clear();
        let height = self.normal.dot(from - self.corners[0]);
        if height <= self.thickness {
            return None;
        }
        corners.extend(self.corners.iter().map(|corner| corner - from));
        Some(HalfSpace { normal: self.normal, offset: self.thickness - height })
    }
}

#[cfg(test)]
mod tests {
    use super::super::lambert;
    use super::*;

    #[test]
    fn a_square_overhead_gives_what_its_closed_form_says_and_nothing_behind_it() {
        // Half a unit square's corner form factor times four: a = b = 0.5, distance 1 (Howell, configuration B-4).
        let below = [(-0.5, -0.5), (-0.5, 0.5), (0.5, 0.5), (0.5, -0.5)];
        let face = Face::new(below.map(|(x, y)| DVec3::new(x, y, 1.0)).to_vec(), 3, 1e-9);
        assert_eq!(face.normal(), DVec3::NEG_Z);
        let mut outline = Vec::new();
        let limit = face.outline(DVec3::ZERO, &mut outline).expect("in front");
        assert!((limit.offset + 1.0).abs() < 1e-6 && limit.normal == DVec3::NEG_Z);
        let side = 0.5_f64 / 1.25_f64.sqrt();
        let exact = 4.0 * 2.0 * side * (0.5 / 1.25_f64.sqrt()).atan() / std::f64::consts::TAU;
        assert!((lambert(DVec3::Z, &outline) - exact).abs() < 1e-12);
        for (k, &a) in outline.iter().enumerate() {
            let b = outline[(k + 1) % 4];
            assert!(b.cross(a).dot(DVec3::Z) > 0.0, "the middle is inside of every edge");
        }
        assert!(face.outline(DVec3::new(0.0, 0.0, 2.0), &mut outline).is_none());
        assert!(face.is_part(3) && !face.is_part(0));
    }
}
