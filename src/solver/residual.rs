use super::PatchLight;
use crate::transport::Transport;

/// The residual E + rho F B - B of a light, W/m² per band: what one more sweep would add to each
/// patch's radiosity. Its power, area times residual, is what has not been passed on yet.
///
/// As B = E + rho H it is rho (F B - H). `reflectance` and `light` have one entry a patch; patches
/// without one count as black and dark.
pub fn residual(transport: &dyn Transport, reflectance: &[[f32; 3]], light: &PatchLight) -> Vec<[f32; 3]> {
    let n = transport.len();
    let radiosity: Vec<[f64; 3]> =
        (0..n).map(|j| light.radiosity.get(j).copied().unwrap_or_default().map(f64::from)).collect();
    let arriving = transport.gather_bands(&radiosity);
    (0..n)
        .map(|i| {
            let rho = reflectance.get(i).copied().unwrap_or_default();
            let irradiance = light.irradiance.get(i).copied().unwrap_or_default();
            std::array::from_fn(|band| {
                let gap = arriving[i][band] - f64::from(irradiance[band]);
                (f64::from(rho[band]) * gap) as f32
            })
        })
        .collect()
}
