//! Rules for integrals.

use std::f64::consts::PI;

/// Nodes and weights of the Gauss-Legendre rule of `count` points on 0..1, in ascending order; exact for
/// polynomials up to the degree 2 count - 1. Newton's method on the Legendre polynomials. `count` is taken as
/// 1 at least.
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let count = count.max(1);
    let n = count as f64;
    (1..=count)
        .rev()
        .map(|index| {
            let mut x = (PI * (index as f64 - 0.25) / (n + 0.5)).cos();
            let mut slope = 1.0;
            // Converges quadratically from these guesses; the last step only confirms.
            for _ in 0..8 {
                let (mut before, mut value) = (1.0, x);
                for degree in 2..=count {
                    let k = degree as f64;
                    (before, value) = (value, ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k);
                }
                slope = n * (x * value - before) / (x * x - 1.0);
                x -= value / slope;
            }
            (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_integrated_exactly() {
        for count in [1, 2, 3, 8, 16, 48] {
            let rule = gauss_legendre(count);
            assert_eq!(rule.len(), count);
            assert!(rule.windows(2).all(|pair| pair[0].0 < pair[1].0));
            for degree in 0..2 * count as i32 {
                let integral: f64 = rule.iter().map(|&(x, w)| w * x.powi(degree)).sum();
                let exact = 1.0 / f64::from(degree + 1);
                assert!((integral - exact).abs() < 1e-14, "{count} points, degree {degree}: {integral}");
            }
        }
        // One degree more is too much.
        let miss: f64 = gauss_legendre(2).iter().map(|&(x, w)| w * x.powi(4)).sum::<f64>() - 0.2;
        assert!(miss.abs() > 1e-3);
    }
}
