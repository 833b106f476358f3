//! The sky cut into bins.

use super::outdoors::Daylight;
use super::sun::{angles, direction};
use crate::geometry::gauss_legendre;
use glam::DVec3;

/// Bins of the rows of Tregenza's sky from the horizon up; the last one is the cap.
const TREGENZA: [usize; 8] = [30, 30, 24, 24, 18, 12, 6, 1];
/// Finer bins serve nobody: this makes about 590,000.
const MOST_SPLITS: usize = 64;

/// A row of bins of equal size between two elevations.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    /// Number of bins before it.
    first: usize,
    count: usize,
    /// Elevations of its edges, degrees.
    from: f64,
    to: f64,
}

/// The sky in bins, rows of equal height in elevation from the horizon to a cap around the zenith, and the
/// ground below the horizon as one more bin.
///
/// Tregenza 1987 (145 bins); finer ones as Reinhart splits them: each row in m rows of m times as many bins,
/// of 90/(7 m + 1/2) degrees. The first bin of each row is centred on north, and the others follow clockwise.
#[derive(Clone, Debug, PartialEq)]
pub struct SkyBins {
    rows: Vec<Row>,
    height: f64,
}

/// How a bin takes its value from a sky.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BinValue {
    /// The luminance at its centre. What arrives at windows from a sky in bins is nearest to the truth so.
    #[default]
    Centre,
    /// The mean luminance over its solid angle. What all bins together send is exact so.
    Mean,
}

impl SkyBins {
    /// Tregenza's 145 bins.
    pub fn tregenza() -> Self {
        Self::reinhart(1)
    }

    /// Reinhart's bins for a subdivision of 1 to 64: 145, 577, 1297, 2305, ... The nearest of these is taken.
    pub fn reinhart(splits: usize) -> Self {
        let splits = splits.clamp(1, MOST_SPLITS);
        let height = 90.0 / (7.0 * splits as f64 + 0.5);
        let [below @ .., cap] = TREGENZA;
        let counts = below.iter().flat_map(|&count| std::iter::repeat_n(count * splits, splits));
        let mut rows = Vec::new();
        let mut first = 0;
        for (index, count) in counts.chain([cap]).enumerate() {
            let from = height * index as f64;
            rows.push(Row { first, count, from, to: (from + height).min(90.0) });
            first += count;
        }
        Self { rows, height }
    }

    /// Number of bins of the sky. The ground is the bin of this index.
    pub fn len(&self) -> usize {
        self.rows.last().map_or(0, |row| row.first + row.count)
    }

    /// Never: there are at least 145.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Elevation and azimuth of the edges of a bin of the sky, degrees: from, to, from, to. The azimuth of
    /// its lower edge may be negative.
    ///
    /// # Panics
    /// For an index that is no bin of the sky.
    pub fn edges(&self, bin: usize) -> [f64; 4] {
        assert!(bin < self.len(), "there is no bin {bin} among {}", self.len());
        let row = self.rows[self.rows.partition_point(|row| row.first <= bin) - 1];
        let width = 360.0 / row.count as f64;
        let centre = width * (bin - row.first) as f64;
        [row.from, row.to, centre - 0.5 * width, centre + 0.5 * width]
    }

    /// Unit vector to the centre of a bin: x east, y north, z up. The cap has its centre at the zenith, the
    /// ground at the nadir.
    ///
    /// # Panics
    /// For an index beyond the ground.
    pub fn centre(&self, bin: usize) -> DVec3 {
        if bin == self.len() {
            return DVec3::NEG_Z;
        }
        if bin + 1 == self.len() {
            return DVec3::Z;
        }
        let [from, to, start, end] = self.edges(bin);
        direction(0.5 * (from + to), 0.5 * (start + end))
    }

    /// Solid angle of a bin, steradian; those of the sky add up to 2 pi, and the ground has as much.
    ///
    /// # Panics
    /// For an index beyond the ground.
    pub fn solid_angle(&self, bin: usize) -> f64 {
        if bin == self.len() {
            return std::f64::consts::TAU;
        }
        let [from, to, start, end] = self.edges(bin);
        (end - start).to_radians() * (to.to_radians().sin() - from.to_radians().sin())
    }

    /// The bin that holds a direction of any length; the ground for what points below the horizon or nowhere.
    pub fn bin_of(&self, e: DVec3) -> usize {
        let (elevation, azimuth) = angles(e);
        if elevation.is_nan() || elevation < 0.0 || e.length_squared() == 0.0 {
            return self.len();
        }
        let index = ((elevation / self.height) as usize).min(self.rows.len() - 1);
        let row = self.rows[index];
        let column = (azimuth * row.count as f64 / 360.0).round() as usize % row.count;
        row.first + column
    }

    /// Luminance of each bin in cd/m², the ground last, without the sun's disc.
    pub fn luminances(&self, daylight: &Daylight, value: BinValue) -> Vec<f64> {
        let sky = daylight.sky();
        let at = |bin| match value {
            BinValue::Centre => sky.luminance(self.centre(bin)),
            BinValue::Mean => self.mean(bin, |e| sky.luminance(e)),
        };
        (0..self.len()).map(at).chain([daylight.ground_luminance()]).collect()
    }

    /// Mean of a function over the solid angle of a bin of the sky.
    fn mean(&self, bin: usize, value: impl Fn(DVec3) -> f64) -> f64 {
        let [from, to, start, end] = self.edges(bin);
        let (low, high) = (from.to_radians().sin(), to.to_radians().sin());
        let columns = if start + 360.0 > end { 1 } else { 8 };
        let rule = gauss_legendre(6);
        let mut sum = 0.0;
        for &(t, weight) in &rule {
            let elevation = (low + (high - low) * t).clamp(-1.0, 1.0).asin().to_degrees();
            for column in 0..columns {
                for &(u, w) in &rule {
                    let share = (column as f64 + u) / columns as f64;
                    sum += weight * w / columns as f64
                        * value(direction(elevation, start + (end - start) * share));
                }
            }
        }
        sum
    }
}
