//! Integrals over the part of the sky that a surface sees.

use crate::geometry::gauss_legendre;
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Points of the rule on each panel.
const POINTS: usize = 8;
/// Longest panel, radians.
const LONGEST: f64 = 0.45;
/// Shortest panel beside the sun, where a sky has a cusp, and beside the horizon, radians.
const SHORTEST: f64 = 0.02;

/// The integral over the upper hemisphere of `luminance(e)` max(0, normal . e): what a surface with this unit
/// `normal` receives from a sky, in the luminance's unit times steradian. `luminance` may have a cusp towards
/// `sun` and is smooth elsewhere. Frame: z up.
///
/// Rings of equal zenith angle, each from edge to edge of what the surface sees, both cut into panels that
/// shorten towards the cusp. Relative error about 1e-9 for the skies of this room.
pub(super) fn irradiance(normal: DVec3, sun: DVec3, luminance: impl Fn(DVec3) -> f64) -> f64 {
    let rule = gauss_legendre(POINTS);
    let sun_zenith = sun.z.clamp(-1.0, 1.0).acos();
    let sun_azimuth = sun.y.atan2(sun.x);
    let (level, axis) = (normal.x.hypot(normal.y), normal.y.atan2(normal.x));
    // The ring that only touches the plane of the surface.
    let tangent = normal.z.abs().atan2(level);
    let mut zeniths = vec![
        Break { at: 0.0, shortest: LONGEST },
        Break { at: sun_zenith.min(FRAC_PI_2), shortest: SHORTEST },
        Break { at: FRAC_PI_2, shortest: SHORTEST },
    ];
    if level > 1e-12 {
        zeniths.push(Break { at: tangent, shortest: SHORTEST });
    }
    let mut sum = 0.0;
    for (from, to) in panels(&mut zeniths) {
        for &(t, weight) in &rule {
            let zenith = from + (to - from) * t;
            let (sin, cos) = zenith.sin_cos();
            let Some((start, end)) = visible_arc(level * sin, normal.z * cos, axis) else { continue };
            // The cusp is the sharper, the nearer the ring passes to the sun.
            let shortest = ((zenith - sun_zenith).abs() / sin.max(1e-3)).clamp(SHORTEST, LONGEST);
            // A full circle begins at the cusp; an arc may end beside it.
            let (start, end) =
                if end - start > TAU - 1e-9 { (sun_azimuth, sun_azimuth + TAU) } else { (start, end) };
            let beside = |edge: f64| {
                let apart = (edge - sun_azimuth + PI).rem_euclid(TAU) - PI;
                Break { at: edge, shortest: apart.abs().clamp(shortest, LONGEST) }
            };
            let mut azimuths = vec![beside(start), beside(end)];
            let cusp = start + (sun_azimuth - start).rem_euclid(TAU);
            if cusp < end {
                azimuths.push(Break { at: cusp, shortest });
            }
            let mut ring = 0.0;
            for (a, b) in panels(&mut azimuths) {
                for &(u, w) in &rule {
                    let (y, x) = (a + (b - a) * u).sin_cos();
                    let e = DVec3::new(sin * x, sin * y, cos);
                    ring += w * (b - a) * luminance(e) * normal.dot(e).max(0.0);
                }
            }
            sum += weight * (to - from) * sin * ring;
        }
    }
    sum
}

/// The azimuths at which `slope` cos(azimuth - axis) + `offset` is above zero, from start to end; none if
/// nowhere.
fn visible_arc(slope: f64, offset: f64, axis: f64) -> Option<(f64, f64)> {
    if offset >= slope {
        return (offset > 0.0).then_some((axis - PI, axis + PI));
    }
    if offset <= -slope {
        return None;
    }
    let half = (-offset / slope).acos();
    Some((axis - half, axis + half))
}

/// Where panels must end, and how long they may be beside it.
struct Break {
    at: f64,
    shortest: f64,
}

/// The panels between the breaks in ascending order: none longer than [`LONGEST`], than the shortest of a
/// break that it touches, or than twice its distance from one.
fn panels(breaks: &mut [Break]) -> Vec<(f64, f64)> {
    breaks.sort_by(|a, b| a.at.total_cmp(&b.at));
    let mut found = Vec::new();
    for pair in breaks.windows(2) {
        let [a, b] = pair else { continue };
        let mut left = vec![(a.at, b.at)];
        while let Some((from, to)) = left.pop() {
            let length = to - from;
            if length <= 0.0 {
                continue;
            }
            let most =
                LONGEST.min(a.shortest.max(2.0 * (from - a.at))).min(b.shortest.max(2.0 * (b.at - to)));
            let middle = 0.5 * (from + to);
            // Beyond the digits of the numbers nothing is cut.
            if length <= most || middle <= from || middle >= to {
                found.push((from, to));
            } else {
                left.push((middle, to));
                left.push((from, middle));
            }
        }
    }
    found
}
