//! Scrambled Sobol points in four dimensions.

/// A randomised low-discrepancy sequence: Sobol's (directions of Joe & Kuo 2008) under the hashed
/// nested scrambling of Owen (Burley 2020). Each seed is an independent randomisation; every point
/// of it alone is uniform in the unit cube.
#[derive(Clone, Copy, Debug)]
pub struct Sobol {
    seeds: [u32; 4],
}

const DIRECTIONS: [[u32; 32]; 4] =
    [van_der_corput(), directions(1, 0, [1, 0, 0]), directions(2, 1, [1, 3, 0]), directions(3, 1, [1, 3, 1])];

const fn van_der_corput() -> [u32; 32] {
    let mut v = [0; 32];
    let mut i = 0;
    while i < 32 {
        v[i] = 1 << (31 - i);
        i += 1;
    }
    v
}

/// Direction numbers of the primitive polynomial of degree `s` with inner coefficients `a`.
const fn directions(s: usize, a: u32, m: [u32; 3]) -> [u32; 32] {
    let mut v = [0_u32; 32];
    let mut i = 0;
    while i < 32 {
        if i < s {
            v[i] = m[i] << (31 - i);
        } else {
            v[i] = v[i - s] ^ (v[i - s] >> s);
            let mut k = 1;
            while k < s {
                if (a >> (s - 1 - k)) & 1 == 1 {
                    v[i] ^= v[i - k];
                }
                k += 1;
            }
        }
        i += 1;
    }
    v
}

impl Sobol {
    /// The randomisation that belongs to `seed`.
    pub fn new(seed: u64) -> Self {
        Self {
            seeds: std::array::from_fn(|d| {
                (mix(seed ^ (d as u64 + 1).wrapping_mul(0xD1B5_4A32_D192_ED03)) >> 32) as u32
            }),
        }
    }

    /// Point `index` of the sequence, each coordinate in 0..1. Powers of two of them are best.
    pub fn point(&self, index: u32) -> [f64; 4] {
        std::array::from_fn(|d| {
            let mut x = 0;
            let mut rest = index;
            while rest != 0 {
                x ^= DIRECTIONS[d][rest.trailing_zeros() as usize];
                rest &= rest - 1;
            }
            (f64::from(scramble(x, self.seeds[d])) + 0.5) / 4_294_967_296.0
        })
    }
}

/// Owen scrambling of the digits of `x` by a hash in which no bit depends on a lower digit.
fn scramble(x: u32, seed: u32) -> u32 {
    let mut x = x.reverse_bits();
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

/// The finaliser of SplitMix64 (Steele et al. 2014).
pub(super) fn mix(key: u64) -> u64 {
    let mut z = key.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A number in 0..1 for a key.
pub(super) fn unit(key: u64) -> f64 {
    (mix(key) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_elementary_interval_of_each_pair_of_the_first_two_dimensions_holds_one_point() {
        // (0, 2)-nets: 256 points, every 2^-a by 2^-(8-a) box holds exactly one.
        for seed in [1, 2, 77] {
            let sequence = Sobol::new(seed);
            for a in 0..=8 {
                let mut counts = vec![0; 256];
                for i in 0..256 {
                    let [x, y, ..] = sequence.point(i);
                    let (column, row) =
                        ((x * f64::from(1 << a)) as usize, (y * f64::from(1 << (8 - a))) as usize);
                    counts[(column << (8 - a)) + row] += 1;
                }
                assert!(counts.iter().all(|&c| c == 1), "seed {seed}, 2^-{a}");
            }
        }
    }

    #[test]
    fn all_dimensions_are_stratified_and_errors_of_randomisations_are_independent() {
        let first = Sobol::new(3);
        for d in 0..4 {
            let mut strata = vec![false; 512];
            (0..512).for_each(|i| strata[(first.point(i)[d] * 512.0) as usize] = true);
            assert!(strata.iter().all(|&s| s), "dimension {d}");
        }
        // Errors of one integral by pairs of seeds: their products cancel, their squares do not.
        let error = |seed: u64| {
            let s = Sobol::new(seed);
            (0..100).map(|i| s.point(i).iter().map(|x| x + 0.5).product::<f64>()).sum::<f64>() / 100.0 - 1.0
        };
        let (mut products, mut squares) = (0.0, 0.0);
        for pair in 0..1000 {
            let (a, b) = (error(2 * pair), error(2 * pair + 1));
            products += a * b;
            squares += 0.5 * (a * a + b * b);
        }
        assert!(products.abs() < 0.1 * squares, "correlation {}", products / squares);
    }

    #[test]
    fn a_smooth_integral_in_four_dimensions_converges_faster_than_by_chance() {
        // The mean over seeds of the squared error of prod (x_d + 1/2), whose integral is one.
        let error = |n: u32| {
            let squares = (0..32).map(|seed| {
                let s = Sobol::new(seed);
                let mean = (0..n).map(|i| s.point(i).iter().map(|x| x + 0.5).product::<f64>()).sum::<f64>()
                    / f64::from(n);
                (mean - 1.0).powi(2)
            });
            (squares.sum::<f64>() / 32.0).sqrt()
        };
        let (coarse, fine) = (error(64), error(4096));
        // By chance: 8 times less. Standard deviation of the function is 0.61.
        assert!(fine < coarse / 30.0, "{coarse} {fine}");
        assert!(fine < 0.61 / 64.0 / 10.0, "{fine}");
    }
}
