//! Polygons: area vectors, centroids, triangulation and clipping.

use glam::{DVec2, DVec3};

/// Area vector of a polygon (Newell): its length is the area, its direction the normal of the
/// side from which the corners run counter-clockwise.
pub fn area_vector(corners: &[DVec3]) -> DVec3 {
    // Relative to the first corner, so that a far origin costs no digits.
    let Some((&first, rest)) = corners.split_first() else { return DVec3::ZERO };
    rest.windows(2).map(|e| (e[0] - first).cross(e[1] - first)).sum::<DVec3>() * 0.5
}

/// Signed area of a polygon in the plane, positive for counter-clockwise corners.
pub fn area_2d(corners: &[DVec2]) -> f64 {
    let Some((&first, rest)) = corners.split_first() else { return 0.0 };
    rest.windows(2).map(|e| (e[0] - first).perp_dot(e[1] - first)).sum::<f64>() * 0.5
}

/// Centroid of a polygon in the plane; the mean of its corners where it has no area.
pub fn centroid_2d(corners: &[DVec2]) -> DVec2 {
    let Some((&first, rest)) = corners.split_first() else { return DVec2::ZERO };
    let (mut moment, mut doubled_area) = (DVec2::ZERO, 0.0);
    for edge in rest.windows(2) {
        let (a, b) = (edge[0] - first, edge[1] - first);
        let cross = a.perp_dot(b);
        moment += (a + b) * cross;
        doubled_area += cross;
    }
    if doubled_area.abs() <= f64::MIN_POSITIVE {
        return corners.iter().sum::<DVec2>() / corners.len() as f64;
    }
    first + moment / (3.0 * doubled_area)
}

/// Whether a counter-clockwise polygon is convex to within `tolerance` (an area).
pub fn is_convex(corners: &[DVec2], tolerance: f64) -> bool {
    let n = corners.len();
    (0..n).all(|i| {
        let (a, b, c) = (corners[i], corners[(i + 1) % n], corners[(i + 2) % n]);
        (b - a).perp_dot(c - b) >= -tolerance
    })
}

/// Triangles of a simple polygon with holes, as indices into `outer` followed by `holes`.
///
/// Convexity and winding do not matter; corners on one line are allowed. Returns no triangle
/// where the polygon has no area.
pub fn triangulate(outer: &[DVec2], holes: &[Vec<DVec2>]) -> Vec<[u32; 3]> {
    let mut points: Vec<[f64; 2]> = outer.iter().map(|p| p.to_array()).collect();
    let mut starts = Vec::with_capacity(holes.len());
    for hole in holes {
        starts.push(points.len() as u32);
        points.extend(hole.iter().map(|p| p.to_array()));
    }
    let mut indices: Vec<u32> = Vec::new();
    earcut::Earcut::new().earcut(points.iter().copied(), &starts, &mut indices);
    indices.as_chunks::<3>().0.to_vec()
}

/// The part of a convex polygon where `inside(p) = a·p + c >= 0` (Sutherland & Hodgman 1974).
pub fn clip_2d(corners: &[DVec2], a: DVec2, c: f64, out: &mut Vec<DVec2>) {
    out.clear();
    let n = corners.len();
    for i in 0..n {
        let (p, q) = (corners[i], corners[(i + 1) % n]);
        let (fp, fq) = (a.dot(p) + c, a.dot(q) + c);
        if fp >= 0.0 {
            out.push(p);
        }
        if (fp > 0.0 && fq < 0.0) || (fp < 0.0 && fq > 0.0) {
            out.push(p + (q - p) * (fp / (fp - fq)));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Vec<DVec2> {
        [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)].map(DVec2::from).to_vec()
    }

    #[test]
    fn area_and_centroid_of_a_rectangle() {
        assert_eq!(area_2d(&square()), 2.0);
        assert_eq!(centroid_2d(&square()), DVec2::new(1.0, 0.5));
        let lifted: Vec<DVec3> = square().iter().map(|p| p.extend(7.0)).collect();
        assert_eq!(area_vector(&lifted), DVec3::new(0.0, 0.0, 2.0));
    }

    #[test]
    fn a_concave_polygon_with_a_hole_keeps_its_area() {
        let outer = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (2.0, 2.0), (0.0, 4.0)].map(DVec2::from);
        let hole = [(1.0, 0.5), (1.0, 1.0), (2.0, 1.0), (2.0, 0.5)].map(DVec2::from).to_vec();
        let all: Vec<DVec2> = outer.iter().chain(&hole).copied().collect();
        let area: f64 =
            triangulate(&outer, &[hole]).iter().map(|t| area_2d(&t.map(|i| all[i as usize])).abs()).sum();
        assert!((area - (12.0 - 0.5)).abs() < 1e-12, "{area}");
        assert!(!is_convex(&outer, 1e-9));
        assert!(is_convex(&square(), 1e-9));
    }

    #[test]
    fn clipping_a_square_halves_it() {
        let mut half = Vec::new();
        clip_2d(&square(), DVec2::new(-1.0, 0.0), 1.0, &mut half);
        assert_eq!(area_2d(&half), 1.0);
    }
}
