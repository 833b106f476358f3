//! What an MTL says of light that passes a material: `d`, `Tr`, `Tf`, `Ni` and `illum` (Wavefront, "The MTL material
//! format", 1995), as the programs that write it mean them.

use super::sidecar::SharesKey;
use super::types::Material;
use crate::glazing::{Glazing, WINDOW_GLASS, greatest_transmittance};

/// The statements of one material, where they are given.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Passing {
    /// `d`: 1 is opaque.
    pub(super) d: Option<f64>,
    /// `Tr`: 1 - d in the specification that most follow.
    pub(super) tr: Option<f64>,
    /// `Tf`: what passes in each band; white says nothing, as most programs write it on everything.
    pub(super) filter: Option<[f64; 3]>,
    /// `Ni`: the refractive index.
    pub(super) index: Option<f64>,
    /// `illum`: the illumination model.
    pub(super) model: Option<f64>,
}

/// By what a material was taken as glass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Understood {
    /// By its d, and its Tf where that has a colour.
    Opacity,
    /// By Tr alone.
    Transparency,
    /// By Tf, with an illumination model of glass.
    Filter,
}

impl Understood {
    /// The finding, without its materials.
    pub(super) fn told(self) -> &'static str {
        match self {
            Self::Opacity => "see-through materials (d below 1) are glass here",
            Self::Transparency => {
                "materials that are see-through by a Tr alone (taken as 1 - d) are glass here"
            }
            Self::Filter => "materials with a Tf and an illumination model of glass are glass here",
        }
    }
}

/// Less than this of what passes or is held back is a rounded 0 or 1.
const ROUNDED: f64 = 1e-3;

impl Passing {
    /// Opacity, 0 to 1, and whether Tr alone tells it: d wins where both are written, since some programs write Tr = d.
    fn opacity(&self) -> Option<(f64, bool)> {
        let held = |value: f64| value.clamp(0.0, 1.0);
        match (self.d, self.tr) {
            (Some(d), _) => Some((held(d), false)),
            // Programs that write Tr 1 on everything mean d.
            (None, Some(tr)) if tr < 1.0 - ROUNDED => Some((1.0 - held(tr), true)),
            _ => None,
        }
    }

    /// Whether all of some materials say that nothing of them is to be seen.
    pub(super) fn all_vanish<'a>(mut all: impl Iterator<Item = &'a Self>) -> bool {
        let vanishes = |passing: &Self| passing.opacity().is_some_and(|(opacity, _)| opacity <= ROUNDED);
        all.next().is_some_and(vanishes) && all.all(vanishes)
    }

    /// The pane that a surface of the material is, where light passes it.
    pub(super) fn glazing(&self) -> Option<(Glazing, Understood)> {
        let index = self.index.filter(|index| (1.1..=4.0).contains(index)).unwrap_or(WINDOW_GLASS);
        let is_glass = self.model.is_some_and(|model| [4.0, 6.0, 7.0, 9.0].contains(&model));
        let says_something = |filter: &[f64; 3]| {
            filter.iter().all(|share| (0.0..=1.0).contains(share))
                && filter.iter().any(|share| *share > ROUNDED)
                && filter.iter().any(|share| *share < 1.0 - ROUNDED)
        };
        let filter = self.filter.filter(says_something);
        let opacity = self.opacity();
        let is_open = opacity.is_some_and(|(opacity, _)| opacity < 1.0 - ROUNDED);
        let (share, understood) = match (filter, opacity) {
            // Of glass the filter tells what passes along the normal, and d how it is to be drawn.
            (Some(filter), _) if is_glass => {
                (filter, if is_open { Understood::Opacity } else { Understood::Filter })
            }
            (filter, Some((opacity, by_tr))) if is_open => {
                let tint = filter.unwrap_or([1.0; 3]);
                let understood = if by_tr { Understood::Transparency } else { Understood::Opacity };
                (tint.map(|tint| tint * (1.0 - opacity)), understood)
            }
            _ => return None,
        };
        let most = greatest_transmittance(index);
        let pane = Glazing::of_unit(1, index, share.map(|share| share.min(most))).ok()?;
        Some((pane, understood))
    }
}

/// What a sidecar asks of a material's glass.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Asked {
    pub(super) transmittance: Option<SharesKey>,
    pub(super) panes: Option<u32>,
    pub(super) glass: Option<bool>,
}

/// More panes than this no window has.
const MOST_PANES: u32 = 6;

impl Asked {
    /// Whether it asks for glass.
    pub(super) fn is_glass(self) -> bool {
        self.transmittance.is_some() || self.panes.is_some() || self.glass == Some(true)
    }

    /// Makes a material the glass that is asked for.
    ///
    /// # Errors
    /// What cannot be, as the end of a sentence that begins with the name of the material.
    pub(super) fn apply(self, material: &mut Material) -> Result<(), String> {
        let Self { transmittance, panes, glass } = self;
        if glass == Some(false) {
            if transmittance.is_some() || panes.is_some() {
                return Err(
                    "is not glass (glass = false), so it takes no transmittance and no panes".to_owned()
                );
            }
            material.glazing = None;
            return Ok(());
        }
        let known = material.glazing.as_ref();
        if transmittance.is_none() && panes.is_none() && (glass.is_none() || known.is_some()) {
            return Ok(());
        }
        let panes = panes.unwrap_or(1);
        if !(1..=MOST_PANES).contains(&panes) {
            return Err(format!("has {panes} panes, but glass has 1 to {MOST_PANES}"));
        }
        let index = known.map_or(WINDOW_GLASS, |glazing| glazing.panes()[0].index());
        // Clear float glass, 6 mm, where nobody says.
        const CLEAR: f64 = 0.88;
        let usual = || known.map_or([CLEAR.powi(panes as i32); 3], |glazing| glazing.transmittance(1.0));
        let wanted = transmittance.map_or_else(usual, SharesKey::bands);
        let unit = Glazing::of_unit(panes, index, wanted)
            .map_err(|error| format!("cannot be such glass: {error}"))?;
        material.glazing = Some(unit);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OPAQUE: Passing = Passing { d: None, tr: None, filter: None, index: None, model: None };

    fn passes(passing: Passing) -> Option<[f64; 3]> {
        passing.glazing().map(|(glazing, _)| glazing.transmittance(1.0).map(|t| (t * 1e6).round() / 1e6))
    }

    #[test]
    fn d_wins_over_tr_and_tr_alone_is_one_less_d() {
        assert_eq!(passes(Passing { d: Some(0.3), ..OPAQUE }), Some([0.7; 3]));
        assert_eq!(passes(Passing { d: Some(0.3), tr: Some(0.3), ..OPAQUE }), Some([0.7; 3]));
        assert_eq!(passes(Passing { d: Some(1.0), tr: Some(1.0), ..OPAQUE }), None);
        let alone = Passing { tr: Some(0.6), ..OPAQUE };
        assert_eq!(passes(alone), Some([0.6; 3]));
        assert_eq!(alone.glazing().unwrap().1, Understood::Transparency);
        // On everything that one program writes.
        assert_eq!(passes(Passing { tr: Some(1.0), ..OPAQUE }), None);
        assert_eq!(passes(Passing { tr: Some(0.0), ..OPAQUE }), None);
    }

    #[test]
    fn glass_passes_by_its_filter_and_a_white_one_says_nothing() {
        let glass = Passing { model: Some(6.0), index: Some(1.52), ..OPAQUE };
        let filter = Some([0.78; 3]);
        assert_eq!(passes(Passing { d: Some(0.1), filter, ..glass }), Some([0.78; 3]));
        assert_eq!(passes(Passing { filter, ..glass }), Some([0.78; 3]));
        // Some programs write this on every wall.
        assert_eq!(
            passes(Passing { filter: Some([1.0; 3]), model: Some(4.0), d: Some(1.0), ..OPAQUE }),
            None
        );
        assert_eq!(passes(Passing { filter: Some([0.0; 3]), model: Some(4.0), ..OPAQUE }), None);
        // Without a model of glass d is what counts, and the filter its tint.
        let tinted = Passing { d: Some(0.5), filter: Some([0.4, 0.8, 0.6]), ..OPAQUE };
        assert_eq!(passes(tinted), Some([0.2, 0.4, 0.3]));
        // No glass of this index passes more than its surfaces let.
        assert_eq!(passes(Passing { d: Some(0.0), ..OPAQUE }), Some([0.918318; 3]));
        assert_eq!(passes(Passing { d: Some(0.2), index: Some(f64::NAN), ..OPAQUE }), Some([0.8; 3]));
    }

    #[test]
    fn a_broken_export_is_one_in_which_all_vanishes() {
        let gone = Passing { d: Some(0.0), ..OPAQUE };
        assert!(Passing::all_vanish([gone, gone].iter()));
        assert!(!Passing::all_vanish([gone, OPAQUE].iter()));
        assert!(!Passing::all_vanish([].iter()));
    }
}
