//! Form factors in closed form, without occlusion: the reference for the sampled ones, and the
//! value itself for pairs that stand close.

use crate::geometry::polygon;
use glam::DVec3;
use std::f64::consts::TAU;

/// Form factor from a point with unit normal `normal` to a polygon (Lambert 1760), what lies below
/// the point's horizon cut off. The polygon may be of either winding; 0 to 1.
pub fn point_to_polygon(point: DVec3, normal: DVec3, corners: &[DVec3]) -> f64 {
    let heights = |c: &DVec3| normal.dot(*c - point);
    if corners.iter().all(|c| heights(c) <= 0.0) {
        return 0.0;
    }
    let clipped = above(corners, point, normal);
    let mut sum = 0.0;
    for i in 0..clipped.len() {
        let (p, q) = (clipped[i] - point, clipped[(i + 1) % clipped.len()] - point);
        let cross = p.cross(q);
        let length = cross.length();
        if length > 0.0 {
            sum += cross.dot(normal) / length * length.atan2(p.dot(q));
        }
    }
    (sum.abs() / TAU).min(1.0)
}

/// The part of a polygon above a plane through `point` with unit normal `normal`.
fn above(corners: &[DVec3], point: DVec3, normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for i in 0..corners.len() {
        let (p, q) = (corners[i], corners[(i + 1) % corners.len()]);
        let (hp, hq) = (normal.dot(p - point), normal.dot(q - point));
        if hp >= 0.0 {
            kept.push(p);
        }
        if (hp > 0.0 && hq < 0.0) || (hp < 0.0 && hq > 0.0) {
            kept.push(p + (q - p) * (hp / (hp - hq)));
        }
    }
    kept
}

/// Exchange area A_1 F_12 = A_2 F_21 of two convex polygons that see each other without
/// occlusion, m²; each counter-clockwise as seen from the side that faces the other.
///
/// Stokes' theorem twice (Sparrow 1963): (1 / 2 pi) times the double contour integral of
/// ln r dx·dy. The inner integral is taken in closed form, the outer too between near parallel edges,
/// else by Gauss-Legendre quadrature with nodes drawn to both ends, where touching edges have their
/// logarithms. What one polygon has below the other's horizon is cut off first.
pub fn exchange_area(first: &[DVec3], second: &[DVec3]) -> f64 {
    let (normal_1, normal_2) =
        (polygon::area_vector(first).normalize_or_zero(), polygon::area_vector(second).normalize_or_zero());
    let first = above(first, second[0], normal_2);
    let second = above(second, first.first().copied().unwrap_or_default(), normal_1);
    if first.len() < 3 || second.len() < 3 {
        return 0.0;
    }
    let mut sum = 0.0;
    for i in 0..first.len() {
        let (a, b) = (first[i], first[(i + 1) % first.len()]);
        for j in 0..second.len() {
            let (c, d) = (second[j], second[(j + 1) % second.len()]);
            let cosine = (b - a).dot(d - c);
            if cosine != 0.0 {
                sum += cosine * mean_log_distance(a, b, c, d);
            }
        }
    }
    (sum / TAU).abs()
}

/// Nodes and weights of 10-point Gauss-Legendre on 0..1, mapped by s = t² (3 - 2 t).
fn graded_nodes() -> &'static [(f64, f64); 10] {
    const GAUSS: [(f64, f64); 5] = [
        (0.148_874_338_981_631_2, 0.295_524_224_714_752_9),
        (0.433_395_394_129_247_2, 0.269_266_719_309_996_4),
        (0.679_409_568_299_024_4, 0.219_086_362_515_982_04),
        (0.865_063_366_688_984_5, 0.149_451_349_150_580_6),
        (0.973_906_528_517_171_7, 0.066_671_344_308_688_14),
    ];
    static NODES: std::sync::OnceLock<[(f64, f64); 10]> = std::sync::OnceLock::new();
    NODES.get_or_init(|| {
        std::array::from_fn(|k| {
            let (x, w) = GAUSS[k / 2];
            let t = 0.5 + if k % 2 == 0 { -0.5 * x } else { 0.5 * x };
            (t * t * (3.0 - 2.0 * t), 0.5 * w * 6.0 * t * (1.0 - t))
        })
    })
}

/// Mean over both segments of ln |x - y|.
fn mean_log_distance(a: DVec3, b: DVec3, c: DVec3, d: DVec3) -> f64 {
    let along = d - c;
    let length = along.length();
    if length <= 0.0 {
        return 0.0;
    }
    let unit = along / length;
    if let Some(mean) = parallel_mean_log(a, b, c, unit, length) {
        return mean;
    }
    graded_nodes()
        .iter()
        .map(|&(s, weight)| {
            let from = c - (a + (b - a) * s);
            // ln sqrt(t² + h²) over t from t0 to t0 + length.
            let t0 = from.dot(unit);
            let h2 = (from - unit * t0).length_squared();
            let h = h2.sqrt();
            let antiderivative = |t: f64| {
                let r2 = t * t + h2;
                let log = if r2 > 0.0 { 0.5 * t * r2.ln() } else { 0.0 };
                let angle = if h > 0.0 { h * (t / h).atan() } else { 0.0 };
                log - t + angle
            };
            weight * (antiderivative(t0 + length) - antiderivative(t0)) / length
        })
        .sum()
}

/// Mean over both segments of ln |x - y| for parallel segments that lie near each other, from `a` to
/// `b` and from `c` along `unit` for `length`; `None` for others.
///
/// Second antiderivative of ln sqrt(t² + h²) at the four distances between the ends, along the
/// edges; its terms cancel where the segments are far apart, where quadrature is exact anyway.
fn parallel_mean_log(a: DVec3, b: DVec3, c: DVec3, unit: DVec3, length: f64) -> Option<f64> {
    const NEAR: f64 = 4.0;
    let first = b - a;
    let run = first.dot(unit);
    let off = first - unit * run;
    // To rounding, also far from the origin.
    if off.length_squared() > 1e-14 * run * run {
        return None;
    }
    let from = c - a;
    let t = from.dot(unit);
    let h2 = (from - unit * t).length_squared();
    // From a and from b to both ends of the other.
    let steps = [t, t + length, t - run, t - run + length];
    let longest = run.abs().max(length);
    let gap = steps.iter().fold(f64::INFINITY, |m, s| m.min(s.abs()));
    let overlap = steps.iter().any(|s| *s <= 0.0) && steps.iter().any(|s| *s >= 0.0);
    let apart = h2 + if overlap { 0.0 } else { gap * gap };
    if apart > (NEAR * run.abs().min(length)).powi(2) && apart > (0.1 * longest).powi(2) {
        return None;
    }
    let h = h2.sqrt();
    // Lengths over the longest, so that logarithms stay small; its own is added at the end.
    let scale = longest.recip();
    let second = |t: f64| {
        let (t, h) = (t * scale, h * scale);
        let (t2, h2) = (t * t, h * h);
        let log = if t2 + h2 > 0.0 { 0.25 * (t2 - h2) * (t2 + h2).ln() } else { 0.0 };
        let angle = if h > 0.0 { h * t * (t / h).atan() } else { 0.0 };
        log - 0.75 * t2 + angle
    };
    let sum = second(steps[1]) - second(steps[0]) - second(steps[3]) + second(steps[2]);
    // The four ends enter with signs that fit a run along the unit vector or against it.
    Some(sum / (run * length * scale * scale) + longest.ln())
}

/// Form factor between equal parallel rectangles `a` by `b` at distance `c` (Hottel 1931;
/// Howell, Mengüç & Siegel, configuration C-11). All lengths above zero.
pub fn parallel_rectangles(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (x2, y2) = (1.0 + x * x, 1.0 + y * y);
    2.0 / (std::f64::consts::PI * x * y)
        * ((x2 * y2 / (x2 + y * y)).sqrt().ln()
            + x * y2.sqrt() * (x / y2.sqrt()).atan()
            + y * x2.sqrt() * (y / x2.sqrt()).atan()
            - x * x.atan()
            - y * y.atan())
}

/// Form factor from a rectangle `w` by `l` to a perpendicular one `h` by `l` that shares the edge
/// `l` (Hamilton & Morgan 1952; configuration C-14). All lengths above zero.
pub fn perpendicular_rectangles(h: f64, w: f64, l: f64) -> f64 {
    let (h, w) = (h / l, w / l);
    let (h2, w2) = (h * h, w * w);
    let p = (1.0 + w2) * (1.0 + h2) / (1.0 + w2 + h2);
    let q = w2 * (1.0 + w2 + h2) / ((1.0 + w2) * (w2 + h2));
    let r = h2 * (1.0 + h2 + w2) / ((1.0 + h2) * (h2 + w2));
    let diagonal = (h2 + w2).sqrt();
    1.0 / (std::f64::consts::PI * w)
        * (w * (1.0 / w).atan() + h * (1.0 / h).atan() - diagonal * (1.0 / diagonal).atan()
            + 0.25 * (p.ln() + w2 * q.ln() + h2 * r.ln()))
}

/// Form factor from the first to the second of two coaxial parallel disks of radii `r1` and `r2`
/// at distance `h` (configuration C-41). All lengths above zero.
pub fn coaxial_disks(r1: f64, r2: f64, h: f64) -> f64 {
    let (a, b) = (r1 / h, r2 / h);
    let x = 1.0 + (1.0 + b * b) / (a * a);
    // Written so that small disks lose no digits: 2 y / (x + sqrt(x² - 4 y)), y = (b / a)².
    let y = (b / a).powi(2);
    2.0 * y / (x + (x * x - 4.0 * y).max(0.0).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(computed: f64, expected: f64, relative: f64) {
        assert!(
            (computed - expected).abs() <= relative * expected.abs(),
            "computed {computed:.15}, expected {expected:.15}"
        );
    }

    #[test]
    fn rectangles_and_disks_have_their_published_values() {
        for (a, b, c, f) in [
            (1.0, 1.0, 1.0, 0.199824895698387),
            (1.0, 1.0, 2.0, 0.0685895888185525),
            (1.0, 1.0, 0.5, 0.415253283577147),
            (1.0, 1.0, 0.1, 0.826994522397257),
            (1.0, 1.0, 0.01, 0.980416602925973),
            (1.0, 1.0, 10.0, 0.00316205683875760),
            (2.0, 1.0, 1.0, 0.285875384850715),
            (6.0, 4.0, 3.0, 0.341693913524762),
        ] {
            close(parallel_rectangles(a, b, c), f, 1e-12);
        }
        for (h, w, l, f) in [
            (1.0, 1.0, 1.0, 0.200043776075403),
            (1.0, 2.0, 1.0, 0.116426301397681),
            (2.0, 1.0, 1.0, 0.232852602795362),
            (0.1, 0.1, 1.0, 0.281887806787901),
            (10.0, 10.0, 1.0, 0.0550239795284106),
            (1.0, 0.001, 1.0, 0.498592023105068),
            (0.01, 1.0, 1.0, 0.00489584926850668),
            (3.0, 6.0, 4.0, 0.129616009955217),
        ] {
            close(perpendicular_rectangles(h, w, l), f, 1e-10);
        }
        for (r1, r2, h, f) in [
            (1.0, 1.0, 1.0, 0.381966011250105),
            (1.0, 1.0, 3.0, 0.0916730868040161),
            (1.0, 2.0, 1.0, 0.763932022500210),
            (0.5, 1.0, 2.0, 0.192235935955849),
        ] {
            close(coaxial_disks(r1, r2, h), f, 1e-13);
        }
    }

    #[test]
    fn a_point_sees_a_rectangle_under_its_corner() {
        let square = |u: DVec3, v: DVec3, at: DVec3| [at, at + u, at + u + v, at + v];
        let above = square(DVec3::X, DVec3::Y, DVec3::Z);
        close(point_to_polygon(DVec3::ZERO, DVec3::Z, &above), 0.138531605994893, 1e-13);
        let beside = square(DVec3::X, DVec3::Z, DVec3::Y);
        close(point_to_polygon(DVec3::ZERO, DVec3::Z, &beside), 0.0557341970025535, 1e-13);
        // Half of it below the horizon adds nothing.
        let sunk = square(DVec3::X, 2.0 * DVec3::Z, DVec3::Y - DVec3::Z);
        close(point_to_polygon(DVec3::ZERO, DVec3::Z, &sunk), 0.0557341970025535, 1e-13);
    }

    #[test]
    fn the_contour_integral_meets_the_closed_forms() {
        let rectangle = |u: DVec3, v: DVec3, at: DVec3| [at, at + u, at + u + v, at + v];
        for gap in [0.01, 0.1, 0.5, 1.0, 2.0, 10.0] {
            let floor = rectangle(DVec3::X, DVec3::Y, DVec3::ZERO);
            let ceiling = rectangle(DVec3::Y, DVec3::X, DVec3::Z * gap);
            close(exchange_area(&floor, &ceiling), parallel_rectangles(1.0, 1.0, gap), 2e-4);
        }
        for (h, w) in [(1.0, 1.0), (2.0, 1.0), (0.1, 0.1), (10.0, 10.0), (1.0, 0.01)] {
            let floor = rectangle(DVec3::X * w, DVec3::Y, DVec3::ZERO);
            let wall = rectangle(DVec3::Y, DVec3::Z * h, DVec3::ZERO);
            close(exchange_area(&floor, &wall) / w, perpendicular_rectangles(h, w, 1.0), 2e-4);
        }
        let pentagon =
            [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 2.0), (0.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
        let wall = rectangle(DVec3::Y, DVec3::Z, DVec3::ZERO);
        let area = polygon::area_vector(&pentagon).length();
        close(exchange_area(&pentagon, &wall) / area, 0.15412432, 1e-4);
    }
}
