use super::PatchLight;
use crate::mesh::Translucence;
use crate::transport::Transport;

/// The irradiance that patches have after one more gathering of a light, W/m² per band: F B or, where the light is known
/// in two parts, D + F R with R what surfaces send out of what arrives.
///
/// `reflectance` and `light` have one entry per patch; patches without one count as black and dark.
pub fn gathered(
    transport: &dyn Transport,
    (reflectance, translucence): (&[[f32; 3]], &Translucence),
    light: &PatchLight,
) -> Vec<[f64; 3]> {
    let direct = light.detail.as_ref().map(|detail| &detail.given);
    let arriving = |j: usize| light.irradiance.get(j).copied().unwrap_or_default().map(f64::from);
    let sent: Vec<[f64; 3]> = (0..transport.len())
        .map(|j| match direct {
            Some(_) => translucence.leaving(j, reflectance_of(reflectance, j), arriving),
            None => light.radiosity.get(j).copied().unwrap_or_default().map(f64::from),
        })
        .collect();
    let mut arriving = transport.gather_bands(&sent);
    for (sum, direct) in arriving.iter_mut().zip(direct.into_iter().flatten()) {
        sum.iter_mut().zip(direct).for_each(|(sum, &direct)| *sum += f64::from(direct));
    }
    arriving
}

/// The residual of a light, W/m² per band: what one more sweep would add to each patch's radiosity, what it sends out of
/// what [`gathered`] adds to its irradiance. Its power, area times residual, is what has not been passed on yet.
pub fn residual(
    transport: &dyn Transport,
    (reflectance, translucence): (&[[f32; 3]], &Translucence),
    light: &PatchLight,
) -> Vec<[f32; 3]> {
    let gap: Vec<[f64; 3]> = gathered(transport, (reflectance, translucence), light)
        .into_iter()
        .enumerate()
        .map(|(i, arriving)| {
            let irradiance = light.irradiance.get(i).copied().unwrap_or_default();
            std::array::from_fn(|band| arriving[band] - f64::from(irradiance[band]))
        })
        .collect();
    let sent = |i: usize| translucence.leaving(i, reflectance_of(reflectance, i), |j| gap[j]);
    (0..gap.len()).map(|i| sent(i).map(|value| value as f32)).collect()
}

fn reflectance_of(reflectance: &[[f32; 3]], patch: usize) -> [f64; 3] {
    reflectance.get(patch).copied().unwrap_or_default().map(f64::from)
}
