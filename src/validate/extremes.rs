//! Units, places and turns: what must not matter to a scene's light.

use super::scenes::{room_with_blocks, transformed};
use super::{Assembled, Case, CaseError, Group, Way};
use crate::mesh::PatchTarget;
use glam::{DMat3, DVec3, dvec3};
use std::sync::Arc;

const SAME: &str = "radiosity has no length and no origin";
const HELD: &str = "what extremes are held to";
/// No length of the room is a multiple of it, so that rounding does not decide on a patch more.
const PATCH: f64 = 0.53;

pub(super) fn cases() -> Vec<Case> {
    let turn = DMat3::from_axis_angle(dvec3(1.0, 2.0, -0.5).normalize(), 0.7);
    let far = dvec3(0.6, -0.7, 0.4).normalize() * 7.07;
    [
        ("in units of 1e-6", DMat3::IDENTITY * 1e-6, DVec3::ZERO),
        ("in units of 1e-3", DMat3::IDENTITY * 1e-3, DVec3::ZERO),
        ("in units of 1e3", DMat3::IDENTITY * 1e3, DVec3::ZERO),
        ("in units of 1e6", DMat3::IDENTITY * 1e6, DVec3::ZERO),
        ("moved by 1e3 of its size", DMat3::IDENTITY, far * 1e3),
        ("moved by 1e6 of its size", DMat3::IDENTITY, far * 1e6),
        ("turned", turn, DVec3::ZERO),
        ("turned, in units of 1e-5, moved by 1e5 of its size", turn * 1e-5, far),
    ]
    .into_iter()
    .map(|(name, matrix, shift)| {
        Case::new(
            Group::Extremes,
            format!("room with two blocks, {name}: the worst patch over the same"),
            SAME,
            1.0,
            move |way| worst_ratio(&light(matrix, shift, way)?, &light(DMat3::IDENTITY, DVec3::ZERO, way)?),
        )
        .lines(1e-5)
        .hemicube(1e-5)
        .because(HELD)
    })
    .collect()
}

/// Irradiance of every patch of the room, moved.
fn light(matrix: DMat3, shift: DVec3, way: Way) -> Result<Vec<f64>, CaseError> {
    let scene = transformed(&room_with_blocks(0.5).read(None)?, matrix, shift);
    let size = PATCH * matrix.determinant().cbrt();
    let made = Assembled::new(Arc::new(scene), &way.settings(PatchTarget::Size(size)))?;
    Ok(made.irradiance(&made.system(None), 1e-9)?.iter().map(|h| f64::from(h[0])).collect())
}

/// Of a / b, patch by patch, the ratio that is furthest from one; what is dark in both is left out.
/// Differences are measured against the mean where a patch is darker than that.
pub(super) fn worst_ratio(a: &[f64], b: &[f64]) -> Result<f64, CaseError> {
    if a.len() != b.len() {
        return Ok(f64::NAN);
    }
    let mean = b.iter().sum::<f64>() / b.len().max(1) as f64;
    Ok(a.iter().zip(b).fold(1.0, |worst: f64, (x, y)| {
        let ratio = 1.0 + (x - y) / y.max(mean);
        if (ratio - 1.0).abs() > (worst - 1.0).abs() || ratio.is_nan() { ratio } else { worst }
    }))
}
