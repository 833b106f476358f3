//! What this scene calls for: each effect on or off, with its reason, evidence and cost.
//!
//! Adding an effect is one file with a `decide` function and one entry in [`Effect`].

use crate::mesh::PatchMesh;
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
}

impl Effect {
    /// All effects, in the order in which a plan lists them.
    pub const ALL: [Self; 5] =
        [Self::Visibility, Self::ColourBands, Self::TwoSided, Self::Textures, Self::SmoothSurfaces];

    /// The name that `--with` and `--without` take.
    pub fn name(self) -> &'static str {
        match self {
            Self::Visibility => "visibility",
            Self::ColourBands => "colour-bands",
            Self::TwoSided => "two-sided",
            Self::Textures => "textures",
            Self::SmoothSurfaces => "smooth-surfaces",
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
pub fn plan(_scene: &Scene, _mesh: &PatchMesh, _choices: &EffectChoices) -> EffectPlan {
    EffectPlan::default()
}
