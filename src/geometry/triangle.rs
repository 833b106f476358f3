use glam::DVec3;

/// The point of a triangle that is nearest to `p` (Ericson 2005, *Real-Time Collision Detection*,
/// section 5.1.5). A triangle without area counts as its corners and edges.
pub fn nearest_in_triangle(p: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    let (ab, ac, ap) = (b - a, c - a, p - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = p - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return a + ab * (d1 / (d1 - d3).max(f64::MIN_POSITIVE));
    }
    let cp = p - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return a + ac * (d2 / (d2 - d6).max(f64::MIN_POSITIVE));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        return b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)).max(f64::MIN_POSITIVE));
    }
    let sum = (va + vb + vc).max(f64::MIN_POSITIVE);
    a + ab * (vb / sum) + ac * (vc / sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inside_beside_an_edge_and_beyond_a_corner() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let cases = [
            ([0.2, 0.3, 0.7], [0.2, 0.3, 0.0]),
            ([0.4, -2.0, 0.1], [0.4, 0.0, 0.0]),
            ([1.0, 1.0, 0.0], [0.5, 0.5, 0.0]),
            ([-1.0, -3.0, 2.0], [0.0, 0.0, 0.0]),
            ([3.0, -1.0, 0.0], [1.0, 0.0, 0.0]),
        ];
        for (point, expected) in cases {
            let found = nearest_in_triangle(point.into(), &triangle);
            assert!(found.distance(expected.into()) < 1e-12, "{point:?}: {found}");
        }
    }
}
