//! What sampling got wrong about a row, before the rows were made reciprocal and closed.

use crate::mesh::NO_PATCH;

/// Pairs with less than this share of a row's exchange say little: a few lines meet them or none do.
const WEIGHTY: f64 = 1e-3;

/// How far a row as it was sampled is from what physics asks of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowQuality {
    /// Sum of the form factors as sampled: 1 where the patch sees no opening.
    pub sampled_sum: f32,
    /// Mean over the row's pairs of |A_i F_ij - A_j F_ji| relative to the mean of the two, each pair
    /// weighing as much as it exchanges; 0 to 2.
    pub mean_reciprocity: f32,
    /// The same of the worst pair among those with a thousandth of the row's exchange or more; 0 to 2.
    pub worst_reciprocity: f32,
    /// The other patch of that pair; [`NO_PATCH`] where no pair is worse than another.
    pub worst_partner: u32,
}

impl Default for RowQuality {
    fn default() -> Self {
        Self { sampled_sum: 0.0, mean_reciprocity: 0.0, worst_reciprocity: 0.0, worst_partner: NO_PATCH }
    }
}

/// Compares the two samples of each pair of one row.
pub(super) struct PairGaps {
    quality: RowQuality,
    /// Least mean exchange of a pair that counts for the worst, m².
    weighty: f64,
    gap: f64,
    mean: f64,
}

impl PairGaps {
    /// For a row whose samples sum to `sum`, of a patch of `area` m².
    pub(super) fn new(sum: f64, area: f64) -> Self {
        let quality = RowQuality { sampled_sum: sum as f32, ..RowQuality::default() };
        Self { quality, weighty: WEIGHTY * sum * area, gap: 0.0, mean: 0.0 }
    }

    /// Takes a pair's samples: `out` = A_i F_ij of this row and `back` = A_j F_ji of row `j`, m².
    #[inline]
    pub(super) fn add(&mut self, j: u32, out: f64, back: f64) {
        let (gap, mean) = ((out - back).abs(), 0.5 * (out + back));
        self.gap += gap;
        self.mean += mean;
        if mean > 0.0 && mean >= self.weighty {
            let relative = (gap / mean) as f32;
            if relative > self.quality.worst_reciprocity {
                self.quality.worst_reciprocity = relative;
                self.quality.worst_partner = j;
            }
        }
    }

    /// Sums over the pairs of |out - back| and of their mean, m², and the row's quality.
    pub(super) fn finish(mut self) -> (f64, f64, RowQuality) {
        if self.mean > 0.0 {
            self.quality.mean_reciprocity = (self.gap / self.mean) as f32;
        }
        (self.gap, self.mean, self.quality)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetric_pair_has_no_gap() {
        let mut pairs = PairGaps::new(0.5, 2.0);
        pairs.add(3, 0.25, 0.25);
        pairs.add(7, 0.75, 0.75);
        let (gap, mean, quality) = pairs.finish();
        assert_eq!((gap, mean), (0.0, 1.0));
        assert_eq!(quality, RowQuality { sampled_sum: 0.5, ..RowQuality::default() });
    }

    #[test]
    fn the_worst_pair_is_found_among_those_that_weigh() {
        let mut pairs = PairGaps::new(1.0, 1.0);
        pairs.add(1, 0.6, 0.5);
        pairs.add(2, 0.3, 0.2);
        // Met by one of the two alone, but a ten-thousandth of the row.
        pairs.add(5, 1e-4, 0.0);
        let (gap, mean, quality) = pairs.finish();
        assert!((quality.worst_reciprocity - 0.4).abs() < 1e-6, "0.1 over 0.25: {quality:?}");
        assert_eq!(quality.worst_partner, 2);
        assert!((f64::from(quality.mean_reciprocity) - gap / mean).abs() < 1e-6);
        assert!((gap / mean - 0.2001 / 0.80005).abs() < 1e-12, "{gap} {mean}");
    }
}
