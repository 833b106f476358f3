//! What corners see of each part of the sky: their skylight at any hour is one sparse product.

use crate::emitters::Share;

/// Steps in which the value of a part is kept, of the largest at its corner.
const STEPS: f32 = 65_535.0;

/// Irradiance from each part of the sky for a unit of what it sends, corner by corner, as whole steps of the
/// corner's largest: four bytes a part.
#[derive(Clone, Debug, Default)]
pub(super) struct SkyParts {
    /// Where the entries of each corner end.
    ends: Vec<u32>,
    entries: Vec<(u16, u16)>,
    /// Of a step, for each corner.
    scales: Vec<f32>,
}

impl SkyParts {
    /// Adds the next corner with what it sees of parts.
    pub(super) fn push(&mut self, seen: &[(u16, f32)]) {
        let scale = seen.iter().map(|part| part.1).fold(0.0, f32::max) / STEPS;
        if scale > 0.0 {
            let steps = seen.iter().map(|&(part, value)| (part, (value / scale).round() as u16));
            self.entries.extend(steps.filter(|entry| entry.1 > 0));
        }
        self.scales.push(scale);
        self.ends.push(self.entries.len() as u32);
    }

    /// Adds a corner of another list.
    pub(super) fn push_from(&mut self, other: &Self, corner: usize) {
        if corner < other.ends.len() {
            self.entries.extend_from_slice(other.of(corner));
            self.scales.push(other.scales[corner]);
            self.ends.push(self.entries.len() as u32);
        }
    }

    fn of(&self, corner: usize) -> &[(u16, u16)] {
        let start = if corner == 0 { 0 } else { self.ends[corner - 1] as usize };
        &self.entries[start..self.ends[corner] as usize]
    }

    /// Calls `add` with each basis and what a corner has from the sky at an hour, by the shares of the parts then.
    pub(super) fn light(&self, corner: usize, shares: &[Option<Share>], mut add: impl FnMut(u32, f64)) {
        let Some(&scale) = self.scales.get(corner) else { return };
        for &(part, steps) in self.of(corner) {
            let value = f64::from(scale) * f64::from(steps);
            if let Some(Some(share)) = shares.get(usize::from(part)) {
                add(share.basis, share.factor * value);
            }
        }
    }

    /// How many corners and parts of them are kept.
    #[cfg(test)]
    pub(super) fn counts(&self) -> [usize; 2] {
        [self.ends.len(), self.entries.len()]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_lose_next_to_nothing() {
        let seen: Vec<(u16, f32)> = (0..128).map(|k| (k, 0.03 / (1.0 + f32::from(k)))).collect();
        let mut parts = SkyParts::default();
        parts.push(&[]);
        parts.push(&seen);
        let share = |k: u16| Share { basis: 3, factor: 1.0 + f64::from(k), band: None };
        let shares: Vec<Option<Share>> = (0..128).map(|k| Some(share(k))).collect();
        let mut sum = 0.0;
        parts.light(1, &shares, |basis, value| {
            assert_eq!(basis, 3);
            sum += value;
        });
        assert!((sum / (0.03 * 128.0) - 1.0).abs() < 1e-4, "{sum}");
        parts.light(0, &shares, |_, _| panic!("it sees nothing"));
        assert_eq!(parts.counts(), [2, 128]);
    }
}
