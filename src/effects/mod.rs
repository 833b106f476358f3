//! What this scene calls for: each effect on or off, with its reason, evidence and cost.
//!
//! Adding an effect is one file with a `find` function and one entry in [`Effect`].

mod colour_bands;
mod glass;
mod holes;
mod smooth_surfaces;
mod textures;
mod translucency;
mod two_sided;
mod visibility;

use crate::mesh::{Backs, PatchMesh};
use crate::scene::Scene;
use std::time::Duration;

/// A part of the simulation that a scene may or may not need.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Effect {
    /// Occlusion between patches; not needed in a convex room without inner surfaces.
    Visibility,
    /// Three wavelength bands; a grey scene solves one.
    ColourBands,
    /// Patches on both sides of a surface.
    TwoSided,
    /// Reflectance and detail from images.
    Textures,
    /// Smooth shading across the facets of a curved surface.
    SmoothSurfaces,
    /// Light that passes panes, by its angle; they are opaque otherwise.
    Glass,
    /// Light that cloth, paper and opal glass pass diffusely; they are opaque otherwise.
    Translucency,
    /// Light that passes leaves, screens and fabrics where their images are transparent; they are opaque otherwise.
    Holes,
}

impl Effect {
    /// All effects, in the order in which a plan lists them.
    pub const ALL: [Self; 8] = [
        Self::Visibility,
        Self::ColourBands,
        Self::TwoSided,
        Self::Textures,
        Self::SmoothSurfaces,
        Self::Glass,
        Self::Translucency,
        Self::Holes,
    ];

    /// The name that `--with` and `--without` take.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::ColourBands => "colour-bands",
            Self::TwoSided => "two-sided",
            Self::Textures => "textures",
            Self::SmoothSurfaces => "smooth-surfaces",
            Self::Glass => "glass",
            Self::Translucency => "translucency",
            Self::Holes => "holes",
        }
    }
}

/// Effects that the user forces on or off.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EffectChoices {
    /// On, whatever the scene calls for.
    pub with: Vec<Effect>,
    /// Off, whatever the scene calls for.
    pub without: Vec<Effect>,
}

/// Whether an effect is simulated, and who said so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EffectState {
    /// The scene calls for it.
    On,
    /// The scene does not call for it.
    NotCalledFor,
    /// The user switched it on.
    OnByChoice,
    /// The user switched it off.
    OffByChoice,
}

/// The decision on one effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// Which effect.
    pub effect: Effect,
    /// On or off.
    pub state: EffectState,
    /// Why, in one sentence.
    pub reason: String,
    /// The counts that the reason rests on.
    pub evidence: String,
    /// What it is expected to cost over leaving it out, in one phrase.
    pub predicted_cost: String,
    /// What it took, once that is known.
    pub measured: Option<Duration>,
}

/// All decisions for one scene.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EffectPlan {
    /// One entry an effect, in the order of [`Effect::ALL`].
    pub decisions: Vec<Decision>,
}

impl EffectPlan {
    /// Whether `effect` is simulated.
    pub fn is_on(&self, effect: Effect) -> bool {
        self.decisions
            .iter()
            .any(|d| d.effect == effect && matches!(d.state, EffectState::On | EffectState::OnByChoice))
    }
}

/// Decides every effect for a meshed scene.
pub fn plan(scene: &Scene, mesh: &PatchMesh, choices: &EffectChoices) -> EffectPlan {
    let decisions = Effect::ALL
        .iter()
        .map(|&effect| {
            let finding = match effect {
                Effect::Visibility => visibility::find(mesh),
                Effect::ColourBands => colour_bands::find(mesh),
                Effect::TwoSided => two_sided::find(mesh),
                Effect::Textures => textures::find(scene, mesh),
                Effect::SmoothSurfaces => smooth_surfaces::find(mesh),
                Effect::Glass => glass::find(scene, mesh),
                Effect::Translucency => translucency::find(scene, mesh),
                Effect::Holes => holes::find(scene, mesh),
            };
            finding.decide(effect, choices)
        })
        .collect();
    EffectPlan { decisions }
}

/// Which backs the mesher gives patches under these choices.
pub fn backs(choices: &EffectChoices) -> Backs {
    if choices.without.contains(&Effect::TwoSided) {
        Backs::None
    } else if choices.with.contains(&Effect::TwoSided) {
        Backs::All
    } else {
        Backs::Reached
    }
}

/// Whether nothing lies behind the front of any surface, so that no point inside has anything hidden from
/// it.
pub fn is_convex(mesh: &PatchMesh) -> bool {
    visibility::is_convex(mesh)
}

/// What an effect's own file finds in a scene.
struct Finding {
    called_for: bool,
    reason: String,
    evidence: String,
    predicted_cost: String,
}

impl Finding {
    fn decide(self, effect: Effect, choices: &EffectChoices) -> Decision {
        let (state, reason) = if choices.without.contains(&effect) {
            let consequence =
                if self.called_for { "although the scene calls for it" } else { "as it would be anyway" };
            (EffectState::OffByChoice, format!("switched off by choice, {consequence}: {}", self.reason))
        } else if choices.with.contains(&effect) {
            let consequence = if self.called_for {
                "as it would be anyway"
            } else {
                "although the scene does not call for it"
            };
            (EffectState::OnByChoice, format!("switched on by choice, {consequence}: {}", self.reason))
        } else if self.called_for {
            (EffectState::On, self.reason)
        } else {
            (EffectState::NotCalledFor, self.reason)
        };
        Decision {
            effect,
            state,
            reason,
            evidence: self.evidence,
            predicted_cost: self.predicted_cost,
            measured: None,
        }
    }
}
