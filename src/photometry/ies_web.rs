//! The photometric web of LM-63: angles and intensities of types C, B and A.

use super::distribution::{Distribution, Pole};
use super::error::Fault;
use super::planes::{Closing, HEMISPHERES, Noise, Planes, SAME, uncovered};
use super::text::Words;

/// Photometric type: which axis the half-planes turn about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// About the vertical axis; vertical angles from nadir, horizontal angles counter-clockwise seen from
    /// above.
    C,
    /// About the axis C90-C270; vertical angles from nadir towards C0, horizontal angles clockwise from that
    /// plane.
    B,
    /// About the vertical axis; vertical angles from the horizontal (C0 is ahead), horizontal angles
    /// clockwise.
    A,
}

/// Reads `count` angles (vertical, horizontal) and the intensities, and expands the symmetries.
///
/// Types B and A after the definitions of LM-63-2002, section 3 (photometric zero, photometric horizontal,
/// horizontal angles): a direction e has in type B V = atan2(e.x, -e.z) and H = asin(-e.y), in type A V =
/// asin(e.z) and H = atan2(-e.y, e.x).
pub(super) fn read(
    words: &mut Words<'_>,
    kind: Kind,
    (vertical, horizontal): (usize, usize),
    factor: f64,
    notes: &mut Vec<String>,
) -> Result<Distribution, Fault> {
    let line = words.line();
    // Both counts are bounded, so that this cannot overflow; it is compared before anything is allocated.
    let wanted = vertical + horizontal + vertical * horizontal;
    if words.left() < wanted {
        return Err(Fault::at(
            line,
            format!(
                "{vertical} vertical and {horizontal} horizontal angles are announced, so {wanted} numbers \
                must follow, but only {} do; the file is incomplete or its counts are wrong",
                words.left()
            ),
        ));
    }
    let (v_range, h_range) = match kind {
        Kind::C => ((0.0, 180.0), (-360.0, 720.0)),
        Kind::B => ((-180.0, 180.0), (-90.0, 90.0)),
        Kind::A => ((-90.0, 90.0), (-180.0, 180.0)),
    };
    let angle_line = words.line();
    let v = angles(words, vertical, "vertical", v_range)?;
    let h_line = words.line();
    let h = angles(words, horizontal, "horizontal", h_range)?;
    if v.len() < 2 {
        return Err(Fault::at(
            angle_line,
            "there must be two or more vertical angles; a single one gives no distribution",
        ));
    }
    if h.len() < 2 && kind != Kind::C {
        return Err(Fault::at(
            h_line,
            "types A and B need two or more horizontal angles; a rotational distribution is of type C (1)",
        ));
    }
    let rows = intensities(words, &h, v.len(), factor, notes)?;
    match kind {
        Kind::C => {
            notes.extend(uncovered(&v, "vertical", &HEMISPHERES));
            let (made, closing) = Distribution::type_c(Planes { angles: h, rows }, v).map_err(|invalid| {
                Fault::at(h_line, format!("{invalid}; correct the horizontal angles or their number"))
            })?;
            if let Closing::Bridged { last } = closing {
                notes.push(format!(
                    "the horizontal angles end at {last} degrees: the rest of the circle is interpolated"
                ));
            }
            Ok(made)
        }
        Kind::B | Kind::A => {
            let (h, rows) = mirrored(h, rows);
            notes.extend(uncovered(&v, "vertical", &[(-90.0, 90.0), (-180.0, 180.0)]));
            let made = if kind == Kind::B { type_b(v, &h, &rows) } else { type_a(v, &h, rows) };
            made.map_err(|invalid| {
                Fault::at(h_line, format!("{invalid}; correct the angles or their number"))
            })
        }
    }
}

fn near(angle: Option<&f64>, wanted: f64) -> bool {
    angle.is_some_and(|angle| (angle - wanted).abs() <= SAME)
}

fn angles(
    words: &mut Words<'_>,
    count: usize,
    which: &str,
    (least, most): (f64, f64),
) -> Result<Vec<f64>, Fault> {
    let mut angles: Vec<f64> = Vec::with_capacity(count);
    for index in 1..=count {
        let line = words.line();
        let what = format!("{which} angle {index} of {count}");
        let angle = words.number(&what)?;
        if !(least - SAME..=most + SAME).contains(&angle) {
            return Err(Fault::at(
                line,
                format!(
                    "{what} is {angle} degrees, but must lie within {least} to {most} for this photometric \
                    type; check the numbers of angles and the type"
                ),
            ));
        }
        let angle = angle.clamp(least, most);
        if let Some(&last) = angles.last().filter(|&&last| last >= angle) {
            return Err(Fault::at(
                line,
                format!(
                    "{what} is {angle} degrees and does not ascend after {last}; check the numbers of angles"
                ),
            ));
        }
        angles.push(angle);
    }
    Ok(angles)
}

/// The intensities in candela, one row for each horizontal angle; noise below zero becomes zero.
fn intensities(
    words: &mut Words<'_>,
    horizontal: &[f64],
    vertical: usize,
    factor: f64,
    notes: &mut Vec<String>,
) -> Result<Vec<Vec<f64>>, Fault> {
    let mut rows = Vec::with_capacity(horizontal.len());
    let mut noise = Noise::default();
    for h in horizontal {
        let mut row = Vec::with_capacity(vertical);
        for index in 1..=vertical {
            let line = words.line();
            let value = words
                .number(&format!("intensity {index} of {vertical} at the horizontal angle {h}"))?
                * factor;
            if !value.is_finite() {
                return Err(Fault::at(
                    line,
                    "an intensity with its factors is beyond all bounds; correct the factors",
                ));
            }
            row.push(noise.without(value, line));
        }
        rows.push(row);
    }
    noise.judge(notes)?;
    Ok(rows)
}

/// Horizontal angles from 0 on stand for both sides of the vertical plane.
fn mirrored(h: Vec<f64>, rows: Vec<Vec<f64>>) -> (Vec<f64>, Vec<Vec<f64>>) {
    if !near(h.first(), 0.0) {
        return (h, rows);
    }
    let angles = h.iter().rev().map(|angle| -angle).chain(h.iter().skip(1).copied()).collect();
    let all = rows.iter().rev().chain(rows.iter().skip(1)).cloned().collect();
    (angles, all)
}

/// Type B: the vertical angles are the azimuths about C90, the horizontal angles run from that pole.
fn type_b(v: Vec<f64>, h: &[f64], rows: &[Vec<f64>]) -> Result<Distribution, super::InvalidDistribution> {
    let transposed =
        (0..v.len()).map(|i| rows.iter().filter_map(|row| row.get(i).copied()).collect()).collect();
    Distribution::from_planes(
        Pole::C90,
        Planes { angles: v, rows: transposed },
        h.iter().map(|angle| 90.0 + angle).collect(),
    )
}

/// Type A: C is minus the horizontal angle, gamma 90 more than the vertical angle.
fn type_a(
    v: Vec<f64>,
    h: &[f64],
    mut rows: Vec<Vec<f64>>,
) -> Result<Distribution, super::InvalidDistribution> {
    rows.reverse();
    Distribution::from_planes(
        Pole::Nadir,
        Planes { angles: h.iter().rev().map(|angle| -angle).collect(), rows },
        v.iter().map(|angle| 90.0 + angle).collect(),
    )
}
