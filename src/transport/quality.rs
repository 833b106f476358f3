//! What sampling got wrong about a row, before the rows were made reciprocal and closed.

use crate::form_factors::Row;
use crate::mesh::NO_PATCH;

/// How far a row as it was sampled is from what physics asks of it.
///
/// The two samples A_i F_ij and A_j F_ji of a pair should agree. Their relative gap by itself says
/// little: many small pairs are met by one of the two alone. So the worst is told as form factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RowQuality {
    /// Sum of the form factors as sampled: 1 where the patch sees no opening.
    pub sampled_sum: f32,
    /// Sum over the row's pairs of |A_i F_ij - A_j F_ji| over the sum of their means; 0 to 2.
    pub mean_reciprocity: f32,
    /// The largest |A_i F_ij - A_j F_ji| of the row over A_i: how far a form factor of the row is in
    /// dispute; 0 or more, of the size of a form factor.
    pub worst_reciprocity: f32,
    /// The gap of that pair over its own mean; 0 to 2, where 2 says that one of the two sees nothing.
    pub worst_pair_gap: f32,
    /// The other patch of that pair; [`NO_PATCH`] where all pairs agree.
    pub worst_partner: u32,
    /// Share of the patch that lies open and not under something, 0 to 1, as far as its receiving points tell.
    pub open: f32,
}

impl Default for RowQuality {
    fn default() -> Self {
        Self {
            sampled_sum: 0.0,
            mean_reciprocity: 0.0,
            worst_reciprocity: 0.0,
            worst_pair_gap: 0.0,
            worst_partner: NO_PATCH,
            open: 1.0,
        }
    }
}

/// Compares the two samples of each pair of one row.
pub(super) struct PairGaps {
    sampled_sum: f64,
    open: f32,
    area: f64,
    gap: f64,
    mean: f64,
    /// The largest gap, the mean of that pair, and the other patch.
    worst: (f64, f64, u32),
}

impl PairGaps {
    /// For a row of a patch of `area` m².
    pub(super) fn new(row: &Row, area: f64) -> Self {
        let (sampled_sum, open) = (row.sum(), row.open);
        Self { sampled_sum, open, area, gap: 0.0, mean: 0.0, worst: (0.0, 0.0, NO_PATCH) }
    }

    /// Takes a pair's samples: `out` = A_i F_ij of this row and `back` = A_j F_ji of row `j`, m².
    #[inline]
    pub(super) fn add(&mut self, j: u32, out: f64, back: f64) {
        let (gap, mean) = ((out - back).abs(), 0.5 * (out + back));
        self.gap += gap;
        self.mean += mean;
        if gap > self.worst.0 {
            self.worst = (gap, mean, j);
        }
    }

    /// Sums over the pairs of |out - back| and of their mean, m², and the row's quality.
    pub(super) fn finish(self) -> (f64, f64, RowQuality) {
        let over = |value: f64, of: f64| if of > 0.0 { (value / of) as f32 } else { 0.0 };
        let (worst, pair, partner) = self.worst;
        let quality = RowQuality {
            sampled_sum: self.sampled_sum as f32,
            mean_reciprocity: over(self.gap, self.mean),
            worst_reciprocity: over(worst, self.area),
            worst_pair_gap: over(worst, pair),
            worst_partner: partner,
            open: self.open,
        };
        (self.gap, self.mean, quality)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_symmetric_pair_has_no_gap() {
        let row = Row { patches: vec![3, 7], values: vec![0.25, 0.25], ..Row::default() };
        let mut pairs = PairGaps::new(&row, 2.0);
        pairs.add(3, 0.25, 0.25);
        pairs.add(7, 0.75, 0.75);
        let (gap, mean, quality) = pairs.finish();
        assert_eq!((gap, mean), (0.0, 1.0));
        assert_eq!(quality, RowQuality { sampled_sum: 0.5, ..RowQuality::default() });
    }

    #[test]
    fn the_worst_pair_is_the_one_with_the_largest_gap() {
        let mut pairs = PairGaps::new(&Row::default(), 4.0);
        pairs.add(1, 0.6, 0.5);
        pairs.add(2, 0.3, 0.1);
        // Met by one of the two alone, but a ten-thousandth of the row.
        pairs.add(5, 1e-4, 0.0);
        let (gap, mean, quality) = pairs.finish();
        assert!((gap - 0.3001).abs() < 1e-12 && (mean - 0.75005).abs() < 1e-12, "{gap} {mean}");
        assert_eq!(quality.worst_partner, 2);
        assert!((quality.worst_reciprocity - 0.2 / 4.0).abs() < 1e-6, "{quality:?}");
        assert!((quality.worst_pair_gap - 1.0).abs() < 1e-6, "0.2 over 0.2: {quality:?}");
        assert!((quality.mean_reciprocity - 0.3001 / 0.75005).abs() < 1e-6, "{quality:?}");
    }
}
