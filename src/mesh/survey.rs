//! What every mesh of a scene rests on, whatever the size of its patches.

use super::backing::{Backing, Sheets};
use super::build::{Backs, MeshError, MeshSettings, PatchTarget};
use super::panes::Panes;
use super::reach::{LightSearch, Reach};
use super::regions::{self, Outline};
use super::sources::Sources;
use super::types::Side;
use crate::scene::{Extent, Scene};
use crate::watch::Watch;
use std::sync::Arc;

/// Shares of a survey's time by which coplanar neighbours are joined, about; the rest goes into their sides.
const JOINED: f64 = 0.1;

/// What is so many times as long as the length that tolerances follow is terrain around the rest.
const TERRAIN: f64 = 4.0;

/// Below which edge patches of an outline are not cut, metres: a share of it where it is far away from the rest,
/// and where it is terrain around a house.
fn coarsest(outline: &Outline, extent: &Extent) -> f64 {
    let longest = (outline.max - outline.min).max_element();
    if !extent.holds(&outline.bounds) {
        longest / 8.0
    } else if longest > TERRAIN * extent.scale {
        longest / 24.0
    } else {
        0.0
    }
}

/// Coplanar neighbours of a scene joined, and the sides of them that light can reach: most of the work of
/// meshing, which meshes of other patch sizes need not do again.
pub struct Survey {
    pub(super) outlines: Arc<[Outline]>,
    /// Surfaces dropped for want of area.
    pub(super) dropped: usize,
    pub(super) panes: Arc<Panes>,
    pub(super) sheets: Sheets,
    pub(super) sources: Sources,
    /// How front and back of each outline stand to light.
    pub(super) reached: Vec<[Reach; 2]>,
    /// Size of the part of the scene that is looked at, metres.
    pub(super) size: f64,
    as_given: bool,
    backs: Backs,
    glass: bool,
    translucency: bool,
    holes: bool,
}

impl std::fmt::Debug for Survey {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Survey").field("regions", &self.outlines.len()).finish_non_exhaustive()
    }
}

impl Survey {
    /// Surveys a scene for meshes with these settings.
    ///
    /// # Errors
    /// No surface has any area, or the watch ended it.
    pub fn new(
        scene: &Scene,
        settings: &MeshSettings,
        search: LightSearch,
        watch: &mut Watch<'_>,
    ) -> Result<Self, MeshError> {
        let extent = scene.extent();
        let size = extent.scale;
        let as_given = settings.target == PatchTarget::AsGiven;
        let (mut outlines, dropped) = regions::join(scene, size, as_given, &mut watch.part(0.0, JOINED))?;
        let panes = if settings.glass { Panes::take(scene, &mut outlines, size) } else { Panes::default() };
        for outline in &mut outlines {
            outline.has_holes = settings.has_holes(scene, outline.material) && outline.luminaire.is_none();
        }
        if outlines.is_empty() {
            return Err(MeshError::Empty);
        }
        outlines.iter_mut().for_each(|outline| outline.coarsest = coarsest(outline, &extent));
        let outlines: Arc<[Outline]> = outlines.into();
        let sheets = Sheets::new(outlines.clone(), size, &mut watch.part(JOINED, JOINED))?;
        let mut sources = Sources::new(scene, &outlines, size);
        let mut reached: Vec<[Reach; 2]> = match settings.backs {
            Backs::Reached => {
                sources.sides(scene, &outlines, &sheets, search, &mut watch.part(JOINED, 1.0))?
            }
            Backs::None => outlines
                .iter()
                .map(|o| {
                    let shines = o.luminaire.is_some() && o.emits_back;
                    [Reach::Lit, if shines { Reach::Lit } else { Reach::Black }]
                })
                .collect(),
            Backs::All => vec![[Reach::Lit; 2]; outlines.len()],
        };
        for (reached, backing) in reached.iter_mut().zip(&sheets.backing) {
            if *backing == Backing::Whole {
                reached[Side::Back as usize] = Reach::Backed;
            }
        }
        let MeshSettings { backs, glass, translucency, .. } = *settings;
        let holes = settings.holes && settings.textures;
        let panes = Arc::new(panes);
        Ok(Self {
            outlines,
            dropped,
            panes,
            sheets,
            sources,
            reached,
            size,
            as_given,
            backs,
            glass,
            translucency,
            holes,
        })
    }

    /// Whether a mesh of the same scene with these settings rests on this.
    pub fn serves(&self, settings: &MeshSettings) -> bool {
        self.as_given == (settings.target == PatchTarget::AsGiven)
            && self.backs == settings.backs
            && self.glass == settings.glass
            && self.translucency == settings.translucency
            && self.holes == (settings.holes && settings.textures)
    }

    /// For each outline whether its front and its back are active.
    pub(super) fn sides(&self) -> Vec<[bool; 2]> {
        self.reached.iter().map(|r| r.map(|side| side == Reach::Lit)).collect()
    }
}
