//! The points of a patch at which its row is gathered.

use crate::geometry::{Frame, polygon};
use crate::mesh::{Patch, PatchMesh};
use glam::DVec3;

/// At how many points of a patch its row is gathered.
///
/// One point is wrong about what changes within the patch; where the light is smooth, by a share
/// that falls with the square of the patch size and that no resolution cures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ReceivingPoints {
    /// The centre, and up to sixteen where that lies under something: direct light, whose shadows are sharp, stands on
    /// elements and needs no more.
    #[default]
    Auto,
    /// The centre alone, as in 1985.
    One,
    /// 2 x 2 Gauss points of a quadrilateral, three of a triangle.
    Four,
    /// 4 x 4 Gauss points of a quadrilateral, six of a triangle.
    Sixteen,
}

impl ReceivingPoints {
    /// All choices, coarsest last named.
    pub const ALL: [Self; 4] = [Self::Auto, Self::One, Self::Four, Self::Sixteen];

    /// The name that `--receiving-points` takes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Auto => "auto",
            Self::One => "1",
            Self::Four => "4",
            Self::Sixteen => "16",
        }
    }

    /// Points of a quadrilateral.
    pub(crate) fn count(self) -> u32 {
        match self {
            Self::Auto | Self::One => 1,
            Self::Four => 4,
            Self::Sixteen => 16,
        }
    }
}

/// Points at most, so that a word has a bit for each.
const MOST: usize = 32;

/// Gauss-Legendre nodes and weights on 0..1 with 2 and with 4 points.
const TWO: [(f64, f64); 2] = [(0.211_324_865_405_187_13, 0.5), (0.788_675_134_594_812_9, 0.5)];
const FOUR: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
];

/// Symmetric rules on a triangle as (distance of a point from its nearest corner's opposite side, weight),
/// each for the three corners: exact to degree 2 (Strang & Fix 1973) and 4 (Dunavant 1985).
const DEGREE_TWO: [(f64, f64); 1] = [(2.0 / 3.0, 1.0 / 3.0)];
const DEGREE_FOUR: [(f64, f64); 2] = [
    (0.108_103_018_168_070_23, 0.223_381_589_678_011_47),
    (0.816_847_572_980_458_5, 0.109_951_743_655_321_87),
];

/// Points that stand for a patch with their shares of it, which sum to one; at most 32.
///
/// Gauss points of a quadrilateral; else those of the triangles that its pieces fan into, fewer of
/// each where there are many.
pub(super) fn points_of(mesh: &PatchMesh, patch: &Patch, how: ReceivingPoints) -> Vec<(DVec3, f64)> {
    if how == ReceivingPoints::One {
        return vec![(patch.centre, 1.0)];
    }
    let fine = how == ReceivingPoints::Sixteen;
    let polygons: Vec<Vec<DVec3>> =
        mesh.pieces_of(patch).map(|piece| mesh.polygon(piece, patch.side)).collect();
    if let [quad] = polygons.as_slice()
        && let &[a, b, c, d] = quad.as_slice()
    {
        return shares(if fine { on_quad([a, b, c, d], &FOUR) } else { on_quad([a, b, c, d], &TWO) }, patch);
    }
    let mut triangles: Vec<([DVec3; 3], f64)> = Vec::new();
    for outline in &polygons {
        for k in 1..outline.len() - 1 {
            let triangle = [outline[0], outline[k], outline[k + 1]];
            triangles.push((triangle, polygon::area_vector(&triangle).length()));
        }
    }
    let most = if fine { MOST } else { 8 };
    if triangles.len() > most {
        // The largest, where areas that differ by rounding alone count as equal.
        let unit = 1e-9 * patch.outline_area();
        triangles.sort_by_key(|triangle| std::cmp::Reverse((triangle.1 / unit) as u64));
        triangles.truncate(most);
    }
    let rule: &[(f64, f64)] = match triangles.len() {
        1..=5 if fine => &DEGREE_FOUR,
        6..=10 if fine => &DEGREE_TWO,
        1..=4 => &DEGREE_TWO,
        _ => &[],
    };
    let mut points = Vec::new();
    for ([a, b, c], area) in triangles {
        if rule.is_empty() {
            points.push(((a + b + c) / 3.0, area));
        }
        for &(near, weight) in rule {
            let far = 0.5 * (1.0 - near);
            for [p, q, r] in [[a, b, c], [b, c, a], [c, a, b]] {
                points.push((p * near + q * far + r * far, area * weight));
            }
        }
    }
    shares(points, patch)
}

/// Points of a cluster, each with the frame of its facet, spread evenly over the area in the order of the facets.
pub(super) fn points_of_cluster(mesh: &PatchMesh, patch: &Patch, count: u32) -> Vec<(DVec3, Frame)> {
    let mut points = Vec::with_capacity(count as usize);
    let step = patch.outline_area() / f64::from(count.max(1));
    let (mut passed, mut next) = (0.0, 0.5 * step);
    for piece in mesh.pieces_of(patch) {
        passed += piece.area;
        if next >= passed || points.len() >= count as usize {
            continue;
        }
        let corners = mesh.polygon(piece, patch.side);
        let frame = Frame::along(mesh.normal_of(piece, patch.side), corners[1] - corners[0]);
        // A facet that several points fall on gives them places of their own: towards one corner after the other.
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        for k in 0.. {
            if next >= passed || points.len() >= count as usize {
                break;
            }
            let share = if k == 0 { 0.0 } else { 0.5 };
            points.push((middle.lerp(corners[k % corners.len()], share), frame));
            next += step;
        }
    }
    points
}

/// Products of a Gauss rule on the bilinear map of a quadrilateral, with their area.
fn on_quad([a, b, c, d]: [DVec3; 4], rule: &[(f64, f64)]) -> Vec<(DVec3, f64)> {
    let mut points = Vec::with_capacity(rule.len() * rule.len());
    for &(t, t_weight) in rule {
        for &(s, s_weight) in rule {
            let at = a * (1.0 - s) * (1.0 - t) + b * s * (1.0 - t) + c * s * t + d * (1.0 - s) * t;
            let along_s = (b - a) * (1.0 - t) + (c - d) * t;
            let along_t = (d - a) * (1.0 - s) + (c - b) * s;
            points.push((at, s_weight * t_weight * along_s.cross(along_t).length()));
        }
    }
    points
}

fn shares(mut points: Vec<(DVec3, f64)>, patch: &Patch) -> Vec<(DVec3, f64)> {
    // A point of what has no area stands for nothing, and must not be all that is left of a patch.
    points.retain(|p| p.1 > 0.0);
    let total: f64 = points.iter().map(|p| p.1).sum();
    if total <= 0.0 {
        return vec![(patch.centre, 1.0)];
    }
    points.iter_mut().for_each(|p| p.1 /= total);
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean of x^i y^j over the unit square's half below the diagonal: i! j! / (i + j + 2)! * 2.
    #[test]
    fn triangle_rules_are_exact_to_their_degree() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let factorial = |n: u32| (1..=n).map(f64::from).product::<f64>();
        for (rule, degree) in [(&DEGREE_TWO[..], 2), (&DEGREE_FOUR[..], 4)] {
            for i in 0..=degree {
                for j in 0..=degree - i {
                    let mut sum = 0.0;
                    for &(near, weight) in rule {
                        let far = 0.5 * (1.0 - near);
                        for k in 0..3 {
                            let p = (0..3)
                                .fold(DVec3::ZERO, |p, c| p + corners[c] * if c == k { near } else { far });
                            sum += weight * p.x.powi(i as i32) * p.y.powi(j as i32);
                        }
                    }
                    let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                    assert!((sum - exact).abs() < 1e-14, "x^{i} y^{j}: {sum} for {exact}");
                }
            }
        }
    }

    #[test]
    fn no_point_stands_for_nothing() {
        // Three corners in a line: the first triangle of the fan has no area.
        let obj = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n";
        let scene = crate::scene::from_text("t", obj, "", None).expect("a scene");
        let settings = crate::mesh::MeshSettings {
            target: crate::mesh::PatchTarget::AsGiven,
            ..crate::mesh::MeshSettings::default()
        };
        let mesh = crate::mesh::build(&scene, &settings).expect("a mesh");
        let patch = &mesh.patches[0];
        let fan = mesh.pieces_of(patch).map(|piece| mesh.corners_of(piece).len() - 2).sum::<usize>();
        assert_eq!(fan, 3, "the corner in the edge is there");
        for how in [ReceivingPoints::Four, ReceivingPoints::Sixteen] {
            let points = points_of(&mesh, patch, how);
            assert!(points.iter().all(|p| p.1 > 1e-6), "{points:?}");
            assert!((points.iter().map(|p| p.1).sum::<f64>() - 1.0).abs() < 1e-12, "{points:?}");
        }
    }

    #[test]
    fn quadrilateral_rules_weigh_by_area() {
        // A trapezium: the mean of x over it is known.
        let quad =
            [DVec3::ZERO, DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 0.0), DVec3::new(0.0, 1.0, 0.0)];
        for rule in [&TWO[..], &FOUR[..]] {
            let points = on_quad(quad, rule);
            let area: f64 = points.iter().map(|p| p.1).sum();
            let mean = points.iter().map(|p| p.0.x * p.1).sum::<f64>() / area;
            assert!((area - 1.5).abs() < 1e-14, "{area}");
            // The square's 1/2 and the triangle's 4/3 by their areas.
            assert!((mean - (0.5 + 0.5 * 4.0 / 3.0) / 1.5).abs() < 1e-14, "{mean}");
        }
    }
}
