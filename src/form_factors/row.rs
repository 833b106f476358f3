//! One row of form factors, dense while it is gathered and sparse when it is kept.

use super::ReceivingPoints;

/// Accumulates the form factors from one patch to all others.
#[derive(Clone, Debug)]
pub struct RowBuffer {
    values: Vec<f64>,
    /// One bit a patch: whether it has been added to.
    touched: Vec<u64>,
    /// What amounts are multiplied by as they are added.
    weight: f64,
}

/// A row as it is kept: patch indices in rising order and their form factors.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Patches seen.
    pub patches: Vec<u32>,
    /// Form factors to them, each above zero.
    pub values: Vec<f32>,
    /// At how many points it was gathered; never [`ReceivingPoints::Auto`].
    pub points: ReceivingPoints,
    /// Of these points the ones that were left out, since they lie under something: one bit each.
    pub covered: u32,
    /// Share of the patch that lies open and not under something, 0 to 1, as far as its receiving points tell.
    pub open: f32,
}

impl RowBuffer {
    /// An empty row over `patches` patches.
    pub fn new(patches: usize) -> Self {
        Self { values: vec![0.0; patches], touched: vec![0; patches.div_ceil(64)], weight: 1.0 }
    }

    /// Weight of what is added from here on: a receiving point's share of its patch.
    pub fn set_weight(&mut self, weight: f64) {
        self.weight = weight;
    }

    /// Adds to the form factor to `patch`.
    #[inline]
    pub fn add(&mut self, patch: u32, amount: f64) {
        let i = patch as usize;
        self.values[i] += amount * self.weight;
        self.touched[i / 64] |= 1 << (i % 64);
    }

    /// Multiplies all form factors by `factor`.
    pub fn scale(&mut self, factor: f64) {
        for (word, &bits) in self.touched.iter().enumerate() {
            let mut rest = bits;
            while rest != 0 {
                self.values[word * 64 + rest.trailing_zeros() as usize] *= factor;
                rest &= rest - 1;
            }
        }
    }

    /// Calls `visit` with every patch added to and its form factor, in rising order, and empties the row.
    pub fn drain(&mut self, mut visit: impl FnMut(u32, f64)) {
        for (word, bits) in self.touched.iter_mut().enumerate() {
            let mut rest = std::mem::take(bits);
            while rest != 0 {
                let i = word * 64 + rest.trailing_zeros() as usize;
                rest &= rest - 1;
                visit(i as u32, std::mem::take(&mut self.values[i]));
            }
        }
    }

    /// The row in its sparse form; the buffer is empty afterwards. Leaves out what is not above zero
    /// in single precision.
    pub fn take(&mut self) -> Row {
        let count = self.touched.iter().map(|w| w.count_ones() as usize).sum();
        let mut row = Row {
            patches: Vec::with_capacity(count),
            values: Vec::with_capacity(count),
            points: ReceivingPoints::One,
            covered: 0,
            open: 1.0,
        };
        self.drain(|patch, value| {
            let value = value as f32;
            if value > 0.0 {
                row.patches.push(patch);
                row.values.push(value);
            }
        });
        row
    }
}

impl Default for Row {
    fn default() -> Self {
        Self { patches: Vec::new(), values: Vec::new(), points: ReceivingPoints::One, covered: 0, open: 1.0 }
    }
}

impl Row {
    /// Sum of the form factors: the fraction of the hemisphere that patches fill.
    pub fn sum(&self) -> f64 {
        self.values.iter().map(|&v| f64::from(v)).sum()
    }

    /// The form factor to `patch`; zero where it is not seen.
    pub fn get(&self, patch: u32) -> f64 {
        self.patches.binary_search(&patch).map_or(0.0, |i| f64::from(self.values[i]))
    }
}
