//! Half-planes of a distribution and their symmetries: a file stores part of the circle, and the reader
//! expands it to all of it.

use super::error::Fault;

/// Angles within this many degrees are the same.
pub(super) const SAME: f64 = 0.01;

/// Half-planes in ascending order of their angle, each with its intensities.
#[derive(Clone, Debug)]
pub(super) struct Planes {
    /// Degrees, strictly ascending.
    pub(super) angles: Vec<f64>,
    /// One row per plane, all of one length.
    pub(super) rows: Vec<Vec<f64>>,
}

/// How the circle was completed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Closing {
    /// By a symmetry, or it was complete.
    Exact,
    /// The gap between the last plane and the first is bridged by interpolation.
    Bridged {
        /// The last angle of the file, degrees.
        last: f64,
    },
}

impl Planes {
    fn mirrored_at_end(mut self) -> Self {
        let Some(&end) = self.angles.last() else { return self };
        let mirrored: Vec<f64> = self.angles.iter().rev().skip(1).map(|angle| 2.0 * end - angle).collect();
        let rows: Vec<Vec<f64>> = self.rows.iter().rev().skip(1).cloned().collect();
        self.angles.extend(mirrored);
        self.rows.extend(rows);
        self
    }

    /// Expands one plane (rotational), a quarter, a half or nearly the whole circle to 360 degrees: the last
    /// plane stands 360 degrees after the first. Quarters and halves start at multiples of 90 degrees and
    /// are mirrored at their ends (LM-63-2002, horizontal angles; EULUMDAT, Isym).
    pub(super) fn closed(mut self) -> Result<(Self, Closing), String> {
        let (Some(&first), Some(&last)) = (self.angles.first(), self.angles.last()) else {
            return Err("there is no half-plane at all".to_owned());
        };
        if self.angles.len() == 1 {
            let row = self.rows.first().cloned().unwrap_or_default();
            let rows = vec![row.clone(), row];
            return Ok((Self { angles: vec![0.0, 360.0], rows }, Closing::Exact));
        }
        let span = last - first;
        let is = |wanted: f64| (span - wanted).abs() <= SAME;
        let at_quarter = (first / 90.0 - (first / 90.0).round()).abs() * 90.0 <= SAME;
        let widest = self.angles.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        let gap = 360.0 - span;
        let closing = if is(360.0) {
            Closing::Exact
        } else if is(180.0) && at_quarter {
            self = self.mirrored_at_end();
            Closing::Exact
        } else if is(90.0) && at_quarter {
            self = self.mirrored_at_end().mirrored_at_end();
            Closing::Exact
        } else if gap > 0.0 && gap <= (2.0 * widest).max(30.0) + SAME {
            self.angles.push(first + 360.0);
            let row = self.rows.first().cloned().unwrap_or_default();
            self.rows.push(row);
            if gap <= widest + SAME { Closing::Exact } else { Closing::Bridged { last } }
        } else {
            return Err(format!(
                "the horizontal angles run from {first} to {last} degrees, but must be 0 alone, or run from \
                0 to 90, 0 to 180, 90 to 270 or 0 to 360"
            ));
        };
        // Rounding in the file must not leave a gap.
        if let Some(end) = self.angles.last_mut() {
            *end = first + 360.0;
        }
        Ok((self, closing))
    }
}

/// A note where ascending `angles` span none of the `whole` ranges, so that light may be missing beyond them.
pub(super) fn uncovered(angles: &[f64], which: &str, whole: &[(f64, f64)]) -> Option<String> {
    let (first, last) = (*angles.first()?, *angles.last()?);
    let covers = |&(from, to): &(f64, f64)| (first - from).abs() <= SAME && (last - to).abs() <= SAME;
    (!whole.iter().any(covers)).then(|| {
        format!(
            "the {which} angles run from {first} to {last} degrees: there is no light beyond \
        them"
        )
    })
}

/// Vertical angles of type C over one or both hemispheres.
pub(super) const HEMISPHERES: [(f64, f64); 3] = [(0.0, 90.0), (90.0, 180.0), (0.0, 180.0)];

/// Negative intensities: measurement noise becomes zero, anything larger is a fault.
#[derive(Debug, Default)]
pub(super) struct Noise {
    greatest: f64,
    least: f64,
    line: usize,
    count: usize,
}

/// Negative intensities down to this share of the greatest are noise.
const NOISE: f64 = 0.01;

impl Noise {
    /// The intensity at a line of the file, zero instead of a negative one.
    pub(super) fn without(&mut self, value: f64, line: usize) -> f64 {
        self.greatest = self.greatest.max(value);
        if value < 0.0 {
            self.count += 1;
            if value < self.least {
                (self.least, self.line) = (value, line);
            }
        }
        value.max(0.0)
    }

    /// Whether all negative intensities were noise; a note says how many there were.
    pub(super) fn judge(&self, notes: &mut Vec<String>) -> Result<(), Fault> {
        if self.least < -NOISE * self.greatest {
            return Err(Fault::at(
                self.line,
                format!("the intensity {} cd is negative; correct it or export the file again", self.least),
            ));
        }
        if self.count > 0 {
            notes.push(format!("slightly negative intensities ({}) are taken as 0", self.count));
        }
        Ok(())
    }
}
