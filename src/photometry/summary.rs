//! The figures of a photometric file for a panel, and whether they agree with what the file states.

use super::distribution::Peak;
use super::measures::{MainPlane, Spread};
use super::{Format, Photometry};

/// Stated and integrated flux may differ by this share before a warning: rounding, coarse angles and other
/// rules of integration explain less.
pub const FLUX_TOLERANCE: f64 = 0.03;
/// The stated share of flux below the horizontal may differ by this much, of the whole flux.
const SHARE_TOLERANCE: f64 = 0.03;
/// A luminaire that emits less than this share of its lamps' flux is a mistake of a factor.
const LEAST_OUTPUT: f64 = 0.1;

/// The flux that a file states and the flux of its intensities, lumens.
#[derive(Clone, Debug, PartialEq)]
pub struct FluxCheck {
    /// Integrated from the intensities.
    pub integrated: f64,
    /// Of the luminaire as the file states it, or else of its lamps; none where the file states neither.
    pub stated: Option<f64>,
    /// Whether [`FluxCheck::stated`] is that of the lamps, some of which the luminaire absorbs.
    pub of_lamps: bool,
    /// Integrated over stated; for the flux of lamps this is the light output ratio.
    pub ratio: Option<f64>,
    /// One sentence without a full stop where the two do not fit.
    pub warning: Option<String>,
}

/// The figures of a luminaire.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    /// Stated and integrated flux.
    pub flux: FluxCheck,
    /// Flux below the horizontal, lumens.
    pub downward: f64,
    /// Flux above the horizontal, lumens.
    pub upward: f64,
    /// The greatest intensity.
    pub maximum: Peak,
    /// Beam angles in C0-C180 and C90-C270, down to half of the plane's maximum.
    pub beam: [Option<Spread>; 2],
    /// Field angles in C0-C180 and C90-C270, down to a tenth of the plane's maximum.
    pub field: [Option<Spread>; 2],
    /// Lumens per watt; none where the file states no power.
    pub efficacy: Option<f64>,
    /// What the user should know: the flux warnings, then the reader's notes.
    pub warnings: Vec<String>,
}

impl Photometry {
    /// Compares the flux that the file states with the one of its intensities.
    pub fn flux_check(&self) -> FluxCheck {
        let integrated = self.flux();
        let of_lamps = self.stated_flux.is_none() && self.lamp_flux.is_some();
        let stated = self.stated_flux.or(self.lamp_flux).filter(|&lumens| lumens > 0.0);
        let ratio = stated.map(|lumens| integrated / lumens);
        let warning = match (stated, ratio) {
            _ if integrated <= 0.0 => Some("all intensities are 0: the luminaire is dark".to_owned()),
            (Some(stated), Some(ratio)) if of_lamps && ratio > 1.0 + FLUX_TOLERANCE => Some(format!(
                "the intensities give {integrated:.0} lm, more than the {stated:.0} lm of the lamps: the \
                multiplier or the lumens per lamp are wrong"
            )),
            (Some(stated), Some(ratio)) if of_lamps && ratio < LEAST_OUTPUT => Some(format!(
                "the intensities give {integrated:.0} lm, only {:.1} % of the {stated:.0} lm of the lamps: \
                the multiplier or the lumens per lamp may be wrong",
                100.0 * ratio
            )),
            (Some(stated), Some(ratio)) if !of_lamps && (ratio - 1.0).abs() > FLUX_TOLERANCE => {
                Some(format!(
                    "the intensities give {integrated:.0} lm, but the file states {stated:.0} lm ({:+.1} %)",
                    100.0 * (ratio - 1.0)
                ))
            }
            _ => None,
        };
        FluxCheck { integrated, stated, of_lamps, ratio, warning }
    }

    /// All figures at once; tens of milliseconds for a file of type B, well under one otherwise.
    pub fn summary(&self) -> Summary {
        let flux = self.flux_check();
        let (downward, upward) = (self.distribution.downward_flux(), self.distribution.upward_flux());
        let share = if flux.integrated > 0.0 { downward / flux.integrated } else { 0.0 };
        let mut warnings: Vec<String> = flux.warning.iter().cloned().collect();
        if let Some(stated) = self.stated_downward_share
            && flux.integrated > 0.0
            && (stated - share).abs() > SHARE_TOLERANCE
        {
            warnings.push(format!(
                "{:.0} % of the light goes down, but the file states {:.0} %",
                100.0 * share,
                100.0 * stated
            ));
        }
        warnings.extend(self.notes.iter().cloned());
        Summary {
            downward,
            upward,
            maximum: self.distribution.maximum(),
            beam: MainPlane::ALL.map(|plane| self.distribution.beam(plane)),
            field: MainPlane::ALL.map(|plane| self.distribution.field(plane)),
            efficacy: (self.watts > 0.0).then(|| flux.integrated / self.watts),
            flux,
            warnings,
        }
    }
}

impl Format {
    /// The name of the format for a panel.
    pub fn name(self) -> String {
        match self {
            Self::Lm63 { year } => format!("IES LM-63-{year}"),
            Self::Eulumdat => "EULUMDAT".to_owned(),
            Self::Made => "made by the program".to_owned(),
        }
    }
}
