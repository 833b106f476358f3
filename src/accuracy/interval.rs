//! From weighted samples of an error to its root mean square with a 95 % interval.

/// A root-mean-square error as a share of the light (0.01 is 1 %), with the interval that holds the truth in 95
/// of 100 cases.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The estimate; zero where noise leaves nothing.
    pub error: f64,
    /// Lower end of the interval; zero or above.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Estimate {
    /// Half of the interval's width over the estimate; infinite where there is none.
    pub fn relative_half_width(&self) -> f64 {
        if self.error > 0.0 { 0.5 * (self.high - self.low) / self.error } else { f64::INFINITY }
    }
}

/// What one receiver tells of an error e, relative to the mean irradiance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Its share of the receiving area over its probability of being drawn.
    pub weight: f64,
    /// e², free of the witness' noise on average; may be negative.
    pub square: f64,
    /// e itself.
    pub deviation: f64,
    /// Reflectance there times e.
    pub reflected: f64,
    /// The light that e is measured against there, over the mean irradiance; above zero.
    pub light: f64,
}

impl Default for Sample {
    fn default() -> Self {
        Self { weight: 0.0, square: 0.0, deviation: 0.0, reflected: 0.0, light: 1.0 }
    }
}

impl Sample {
    /// The same error measured against the mean irradiance.
    pub fn of_mean(self) -> Self {
        Self { light: 1.0, ..self }
    }
}

/// Quantile of the normal distribution for 95 % between both tails.
const Z: f64 = 1.959_963_984_540_054;

/// Root mean square of an error over the light h there, where the mean error is passed on with the factor `gain`: with
/// C = gain mean(rho e) the constant that later reflections add,
/// mean((e + C)² / h²) = mean(e² / h²) + 2 C mean(e / h²) + C² mean(1 / h²).
///
/// Bias and spread by the jackknife (Efron & Stein 1981: pseudo-values), the interval by Hall's
/// (1992) transformation of Student's t, which mends the skewness that few large squares cause.
/// Where noise leaves a mean square below zero, the interval reaches up to what is lost in that noise.
/// Deterministic. With fewer than two samples the interval is infinite.
pub fn estimate(samples: &[Sample], gain: f64) -> Estimate {
    let n = samples.len() as f64;
    if samples.len() < 2 {
        return Estimate { error: 0.0, low: 0.0, high: f64::INFINITY };
    }
    // The last two are those of one: over the light there, and by itself.
    let terms = |x: &Sample| {
        let over = x.weight / (x.light * x.light);
        [over * x.square, over * x.deviation, x.weight * x.reflected, over, x.weight]
    };
    let sums = samples.iter().fold([0.0; 5], |mut s, x| {
        s.iter_mut().zip(terms(x)).for_each(|(s, x)| *s += x);
        s
    });
    let value = |s: [f64; 5], n: f64| {
        let [square, mean, reflected] = [s[0], s[1], s[2]].map(|x| x / n);
        let passed_on = gain * reflected;
        let one = if s[4] > 0.0 { s[3] / s[4] } else { 1.0 };
        square + 2.0 * passed_on * mean + passed_on * passed_on * one
    };
    let whole = value(sums, n);
    let pseudo = samples.iter().map(|x| {
        let mut without = sums;
        without.iter_mut().zip(terms(x)).for_each(|(s, x)| *s -= x);
        n * whole - (n - 1.0) * value(without, n - 1.0)
    });
    let mean = pseudo.clone().sum::<f64>() / n;
    let moment = |power: i32| pseudo.clone().map(|p| (p - mean).powi(power)).sum::<f64>();
    let deviation = (moment(2) / (n - 1.0)).sqrt();
    let skewness = if deviation > 0.0 { moment(3) / n / deviation.powi(3) } else { 0.0 };
    let z = Z * (1.0 + (Z * Z + 1.0) / (4.0 * (n - 1.0)));
    let low = mean - deviation / n.sqrt() * unskewed(z, skewness, n);
    let high = mean - deviation / n.sqrt() * unskewed(-z, skewness, n);
    // A mean below zero is noise of the witness: an error that would drown in as much is not ruled out.
    let drowned = if mean < 0.0 { Z * deviation / n.sqrt() } else { 0.0 };
    let root = |x: f64| x.max(0.0).sqrt();
    Estimate { error: root(mean), low: root(low), high: root(high.max(drowned)) }
}

/// Quantile of Student's statistic where Hall's monotone cubic of it has the quantile `z`.
fn unskewed(z: f64, skewness: f64, n: f64) -> f64 {
    let a = skewness / n.sqrt();
    if a.abs() < 1e-6 {
        return z;
    }
    3.0 / a * ((1.0 + a * (z - a / 6.0)).cbrt() - 1.0)
}

#[cfg(test)]
mod tests {
    use super::super::sobol::unit;
    use super::*;

    fn normal(key: u64) -> f64 {
        (-2.0 * unit(2 * key).max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * unit(2 * key + 1)).cos()
    }

    fn sample(square: f64) -> Sample {
        Sample { weight: 1.0, square, ..Sample::default() }
    }

    /// Share of `runs` in which the interval from `count` squares holds `truth`.
    fn coverage(runs: u64, count: u64, truth: f64, square: impl Fn(u64) -> f64) -> f64 {
        let held = (0..runs).filter(|run| {
            let samples: Vec<Sample> = (0..count).map(|k| sample(square(run * count + k))).collect();
            let found = estimate(&samples, 0.0);
            found.low <= truth && truth <= found.high
        });
        held.count() as f64 / runs as f64
    }

    #[test]
    fn intervals_hold_the_truth_for_squares_of_many_shapes() {
        let chi = coverage(2000, 64, 1.0, |k| normal(k).powi(2));
        // e = exp(0.7 g): the mean square is exp(2 * 0.49).
        let heavy = coverage(2000, 128, (0.98_f64).exp().sqrt(), |k| (1.4 * normal(k)).exp());
        // A tenth of the area is wrong by one, the rest by nothing.
        let rare = coverage(2000, 128, 0.1_f64.sqrt(), |k| f64::from(unit(k ^ 0xabc) < 0.1));
        // Noise of the witness as large as the error: products of two deviations.
        let noisy = coverage(2000, 64, 1.0, |k| {
            let e = normal(3 * k);
            (e + normal(3 * k + 1_000_000_007)) * (e + normal(3 * k + 2_000_000_011))
        });
        println!("normal {chi}, heavy {heavy}, rare {rare}, noisy {noisy}");
        for (name, share) in [("normal", chi), ("heavy", heavy), ("rare", rare), ("noisy", noisy)] {
            assert!((0.90..0.995).contains(&share), "{name}: {share}");
        }
    }

    #[test]
    fn an_error_lost_in_noise_is_below_the_noise_and_not_none() {
        // Products of two independent deviations of 0.1 about an error of 0.001.
        let square = |k: u64| (0.001 + 0.1 * normal(2 * k)) * (0.001 + 0.1 * normal(2 * k + 1));
        let mut below_zero = 0;
        for run in 0..200 {
            let samples: Vec<Sample> = (0..100).map(|k| sample(square(run * 100 + k))).collect();
            let found = estimate(&samples, 0.0);
            below_zero += u32::from(found.error == 0.0);
            // The noise of the mean is 0.01 / 10; twice that is the square of 0.044.
            assert!((0.015..0.12).contains(&found.high), "{found:?}");
        }
        assert!(below_zero > 50, "{below_zero} of 200");
    }

    #[test]
    fn the_mean_of_an_error_is_passed_on_and_its_noise_is_not() {
        // e = 0.02 + noise; rho 0.5 in a closed scene: gain 2, so C = 2 * 0.5 * 0.02.
        let of = |bias: f64, spread: f64| {
            let samples: Vec<Sample> = (0..4000)
                .map(|k| {
                    let e = bias + spread * normal(k);
                    Sample { weight: 1.0, square: e * e, deviation: e, reflected: 0.5 * e, light: 1.0 }
                })
                .collect();
            estimate(&samples, 2.0)
        };
        let biased = of(0.02, 0.001);
        assert!((biased.error - 0.04).abs() < 0.001, "{biased:?}");
        let noise = of(0.0, 0.02);
        assert!((noise.error - 0.02).abs() < 0.001, "{noise:?}");
        assert!(noise.low < 0.02 && noise.high > 0.02);
    }

    #[test]
    fn an_exact_answer_has_no_error_and_too_few_samples_say_nothing() {
        assert_eq!(estimate(&[sample(0.0); 10], 1.0), Estimate::default());
        assert_eq!(estimate(&[sample(1.0)], 0.0).high, f64::INFINITY);
        assert_eq!(estimate(&[], 0.0).high, f64::INFINITY);
    }
}
