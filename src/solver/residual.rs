use super::PatchLight;
use crate::transport::Transport;

/// The irradiance that patches have after one more gathering of a light, W/m² per band: F B or, where the light is known
/// in two parts, D + F rho H.
///
/// `reflectance` and `light` have one entry per patch; patches without one count as black and dark.
pub fn gathered(transport: &dyn Transport, reflectance: &[[f32; 3]], light: &PatchLight) -> Vec<[f64; 3]> {
    let direct = light.detail.as_ref().map(|detail| &detail.given);
    let sent: Vec<[f64; 3]> = (0..transport.len())
        .map(|j| match direct {
            Some(_) => {
                let rho = reflectance.get(j).copied().unwrap_or_default();
                let arriving = light.irradiance.get(j).copied().unwrap_or_default();
                std::array::from_fn(|band| f64::from(rho[band]) * f64::from(arriving[band]))
            }
            None => light.radiosity.get(j).copied().unwrap_or_default().map(f64::from),
        })
        .collect();
    let mut arriving = transport.gather_bands(&sent);
    for (sum, direct) in arriving.iter_mut().zip(direct.into_iter().flatten()) {
        sum.iter_mut().zip(direct).for_each(|(sum, &direct)| *sum += f64::from(direct));
    }
    arriving
}

/// The residual of a light, W/m² per band: what one more sweep would add to each patch's radiosity, rho times what
/// [`gathered`] adds to its irradiance. Its power, area times residual, is what has not been passed on yet.
pub fn residual(transport: &dyn Transport, reflectance: &[[f32; 3]], light: &PatchLight) -> Vec<[f32; 3]> {
    gathered(transport, reflectance, light)
        .into_iter()
        .enumerate()
        .map(|(i, arriving)| {
            let rho = reflectance.get(i).copied().unwrap_or_default();
            let irradiance = light.irradiance.get(i).copied().unwrap_or_default();
            std::array::from_fn(|band| {
                let gap = arriving[band] - f64::from(irradiance[band]);
                (f64::from(rho[band]) * gap) as f32
            })
        })
        .collect()
}
