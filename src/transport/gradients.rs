//! Conjugate gradients (Hestenes & Stiefel 1952), preconditioned: the inner steps of both ways of scaling.

use crate::watch::Cancelled;

/// Solves A x = b from nought for a symmetric A without negative eigenvalues.
///
/// It ends once the preconditioned residual is `share` of what it was, after so many `most` steps, or where A has no
/// curvature along a direction. `preconditioned` divides by what stands for A's diagonal; `image` is A times a vector.
///
/// # Errors
/// A product was cancelled.
pub(super) fn solved(
    b: Vec<f64>,
    (share, most): (f64, usize),
    preconditioned: impl Fn(&[f64]) -> Vec<f64>,
    mut image: impl FnMut(&[f64]) -> Result<Vec<f64>, Cancelled>,
) -> Result<Vec<f64>, Cancelled> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut x = vec![0.0; b.len()];
    let mut residual = b;
    let mut direction = preconditioned(&residual);
    let mut left = dot(&residual, &direction);
    let enough = share * share * left;
    for _ in 0..most {
        let image = image(&direction)?;
        let curvature = dot(&direction, &image);
        if curvature <= 0.0 {
            break;
        }
        let length = left / curvature;
        x.iter_mut().zip(&direction).for_each(|(x, d)| *x += length * d);
        residual.iter_mut().zip(&image).for_each(|(r, v)| *r -= length * v);
        let next = preconditioned(&residual);
        let remaining = dot(&residual, &next);
        if remaining <= enough {
            break;
        }
        let turn = remaining / left;
        direction.iter_mut().zip(&next).for_each(|(d, z)| *d = z + turn * *d);
        left = remaining;
    }
    Ok(x)
}
