//! What a photometric file of a luminaire holds.

use super::failure::Failure;
use super::text;
use crate::photometry::{self, MainPlane, Photometry, Spread};
use std::path::Path;

/// Whether a name is that of a photometric file rather than of a scene.
pub(super) fn is_photometric(name: &str) -> bool {
    let ending = Path::new(name).extension().unwrap_or_default();
    ["ies", "ldt", "eul"].iter().any(|known| ending.eq_ignore_ascii_case(known))
}

/// Reads the file and tells what it holds and what is doubtful about it.
///
/// # Errors
/// It cannot be read, or is no photometric file.
pub(super) fn check(name: &str) -> Result<String, Failure> {
    let bytes = std::fs::read(name).map_err(|error| Failure::input(format!("{name}: {error}")))?;
    let file = photometry::read(name, &bytes).map_err(|error| Failure::input(error.to_string()))?;
    Ok(describe(name, &file))
}

/// Zones of the table of fluxes, degrees.
const ZONE: f64 = 30.0;

fn describe(name: &str, file: &Photometry) -> String {
    let summary = file.summary();
    let mut told = format!("{name} ({})\n", file.format.name());
    let mut line = |what: &str, value: String| told += &format!("  {what:12}{value}\n");
    for (k, text) in file.description.lines().into_iter().enumerate() {
        line(if k == 0 { "luminaire" } else { "" }, text);
    }
    let flux = &summary.flux;
    let stated = match (flux.stated, flux.ratio) {
        (Some(stated), Some(ratio)) if flux.of_lamps => {
            format!("; {stated:.0} lm of its lamps, light output ratio {:.1} %", 100.0 * ratio)
        }
        (Some(stated), Some(ratio)) => format!("; {stated:.0} lm stated ({:+.1} %)", 100.0 * (ratio - 1.0)),
        _ => String::new(),
    };
    line("flux", format!("{:.0} lm by its intensities{stated}", flux.integrated));
    line("", format!("{:.0} lm downwards, {:.0} lm upwards", summary.downward, summary.upward));
    if let Some(efficacy) = summary.efficacy {
        line("power", format!("{:.1} W, {efficacy:.0} lm/W", file.watts));
    }
    let peak = summary.maximum;
    line("maximum", format!("{:.1} cd at C {:.1}, gamma {:.1} degrees", peak.candela, peak.c, peak.gamma));
    line("beam", angles(summary.beam));
    line("field", angles(summary.field));
    let opening = &file.opening;
    line(
        "opening",
        format!(
            "{:.3} m along C0-C180, {:.3} m along C90-C270, {:.3} m high",
            opening.along_c0, opening.along_c90, opening.height
        ),
    );
    for zone in file.distribution.zonal_fluxes(ZONE).iter().filter(|zone| zone.lumens > 0.0) {
        let share = 100.0 * zone.lumens / flux.integrated;
        line(
            "zone",
            format!("{:3.0} to {:3.0} degrees {:8.1} lm {share:5.1} %", zone.from, zone.to, zone.lumens),
        );
    }
    for warning in &summary.warnings {
        told += &format!("warning: {warning}\n");
    }
    told + &text::count(summary.warnings.len(), "warning") + "\n"
}

/// The angles between the two sides in both main planes.
fn angles(spreads: [Option<Spread>; 2]) -> String {
    let planes = MainPlane::ALL.iter().zip(spreads).map(|(plane, spread)| {
        let name = match plane {
            MainPlane::C0C180 => "C0-C180",
            MainPlane::C90C270 => "C90-C270",
        };
        let angle = spread.map_or_else(|| "none".to_owned(), |s| format!("{:.1} degrees", s.angle()));
        format!("{angle} in {name}")
    });
    planes.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::photometry::{Distribution, Opening};

    #[test]
    fn a_lambertian_disc_is_described_in_its_own_figures() {
        let gammas: Vec<f64> = (0..=90).map(f64::from).collect();
        let candelas: Vec<f64> = gammas.iter().map(|g| 100.0 * g.to_radians().cos()).collect();
        let distribution = Distribution::new(&[0.0], &gammas, &candelas).expect("a distribution");
        let told = describe("disc.ies", &Photometry::made("Disc", distribution, Opening::POINT));
        // 100 pi lm, half of the maximum at 60 degrees to either side.
        for part in ["314 lm by its intensities", "100.0 cd", "120.0 degrees in C0-C180", "0 warnings"] {
            assert!(told.contains(part), "{part}: {told}");
        }
    }

    #[test]
    fn photometric_files_are_known_by_their_endings() {
        assert!(is_photometric("a/Lamp.IES") && is_photometric("b.ldt"));
        assert!(!is_photometric("a.obj") && !is_photometric("builtin:house") && !is_photometric("ies"));
    }
}
