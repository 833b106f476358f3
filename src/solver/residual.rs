use super::PatchLight;
use crate::transport::FormFactors;
use rayon::prelude::*;

/// The residual E + rho F B - B of a light, W/m² per band: what one more sweep would add to each
/// patch's radiosity. Its power, area times residual, is what has not been passed on yet.
///
/// As B = E + rho H it is rho (F B - H). `reflectance` and `light` have one entry a patch; patches
/// without one count as black and dark.
pub fn residual(form_factors: &FormFactors, reflectance: &[[f32; 3]], light: &PatchLight) -> Vec<[f32; 3]> {
    let radiosity = |j: usize| light.radiosity.get(j).copied().unwrap_or_default().map(f64::from);
    (0..form_factors.len())
        .into_par_iter()
        .with_min_len(64)
        .map(|i| {
            let (columns, exchange) = form_factors.row(i);
            let mut arriving = radiosity(i).map(|b| b * form_factors.diagonal(i));
            for (&j, &s) in columns.iter().zip(exchange) {
                let b = radiosity(j as usize);
                for band in 0..3 {
                    arriving[band] += f64::from(s) * b[band];
                }
            }
            let rho = reflectance.get(i).copied().unwrap_or_default();
            let irradiance = light.irradiance.get(i).copied().unwrap_or_default();
            std::array::from_fn(|band| {
                let gap = arriving[band] / form_factors.area(i) - f64::from(irradiance[band]);
                (f64::from(rho[band]) * gap) as f32
            })
        })
        .collect()
}
