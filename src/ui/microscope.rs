//! What a debugger of meshes looks at: the row and the hemicube of one patch, and what every patch
//! has of sampling and solver errors. Computed on helper threads.

use super::background::Background;
use super::prepared::Prepared;
use super::state::Quantity;
use crate::display::{NO_VALUE, luminance};
use crate::form_factors::{ItemBuffer, RowComputer};
use crate::mesh::Contact;
use crate::scene::{LUMINOUS_EFFICACY, Lighting, illuminance, luminance_weighted};
use crate::session::Snapshot;
use crate::solver::{LightBases, PatchLight, residual};
use crate::transport::{RowQuality, Transport};
use std::sync::{Arc, Weak};

/// Cells along an edge of the hemicube that is shown.
const HEMICUBE: u32 = 128;
/// Entries of a row that are listed.
pub(super) const LISTED: usize = 10;

/// One patch looked into. Immutable; geometry alone.
pub(super) struct Inspection {
    /// The patch.
    pub(super) patch: u32,
    /// Patches seen and the form factors to them, in rising order.
    pub(super) row: Vec<(u32, f64)>,
    /// The row is that of the balanced matrix; otherwise it was sampled for this look.
    pub(super) balanced: bool,
    /// Sum of the row: 1 less what escapes.
    pub(super) row_sum: f64,
    /// How the row was sampled, once the matrix is there.
    pub(super) quality: Option<RowQuality>,
    /// Patches beside it, how they touch, and the form factors to them.
    pub(super) neighbours: Vec<(u32, Contact, f64)>,
    /// What it sees.
    pub(super) hemicube: ItemBuffer,
}

impl Inspection {
    fn look(prepared: &Prepared, source: &RowSource, patch: u32) -> Self {
        let mesh = &prepared.mesh;
        let (row, row_sum, quality) = match source {
            RowSource::Balanced(transport) => {
                let i = patch as usize;
                let area = transport.area(i);
                let row = transport.row(i).into_iter().map(|(j, s)| (j, s / area)).collect();
                (row, transport.row_sum(i), Some(transport.quality(i)))
            }
            RowSource::Sampled(computer) => {
                let row = computer.row(patch, &mut computer.scratch());
                let pairs = row.patches.iter().zip(&row.values).map(|(&j, &f)| (j, f64::from(f)));
                (pairs.collect(), row.sum(), None)
            }
        };
        let mut row: Vec<(u32, f64)> = row;
        // Pairs that balancing has cut off, for one of the two lies under something.
        row.retain(|entry| entry.1 > 0.0);
        let own = &mesh.patches[patch as usize];
        let frame = ItemBuffer::upright_frame(own.normal, prepared.scene.up.vector());
        let mut inspection = Self {
            patch,
            row,
            balanced: matches!(source, RowSource::Balanced(_)),
            row_sum,
            quality,
            neighbours: Vec::new(),
            hemicube: ItemBuffer::draw(mesh, own.centre, &frame, HEMICUBE),
        };
        let around = mesh.neighbours(patch).into_iter();
        inspection.neighbours = around.map(|(j, contact)| (j, contact, inspection.get(j))).collect();
        inspection
    }

    /// The form factor to `patch`; zero where it is not seen.
    pub(super) fn get(&self, patch: u32) -> f64 {
        self.row.binary_search_by_key(&patch, |entry| entry.0).map_or(0.0, |at| self.row[at].1)
    }

    /// The largest entries by the light that arrives from them, or by form factor in the dark: patch,
    /// form factor and share of the irradiance, at most [`LISTED`], falling.
    pub(super) fn largest(&self, light: &PatchLight) -> Vec<(u32, f64, f64)> {
        let arriving = |j: u32, f: f64| {
            light.radiosity.get(j as usize).map_or(0.0, |b| f * luminance_weighted(b.map(f64::from)))
        };
        let total: f64 = self.row.iter().map(|&(j, f)| arriving(j, f)).sum();
        let share = |j: u32, f: f64| if total > 0.0 { arriving(j, f) / total } else { 0.0 };
        let mut all: Vec<(u32, f64, f64)> = self.row.iter().map(|&(j, f)| (j, f, share(j, f))).collect();
        let falling = |a: &(u32, f64, f64), b: &(u32, f64, f64)| {
            b.2.total_cmp(&a.2).then(b.1.total_cmp(&a.1)).then(a.0.cmp(&b.0))
        };
        if all.len() > LISTED {
            all.select_nth_unstable_by(LISTED, falling);
            all.truncate(LISTED);
        }
        all.sort_by(falling);
        all
    }

    /// A quantity of the row for every patch; [`NO_VALUE`] where it is not seen.
    fn heat_map(&self, quantity: Quantity, prepared: &Prepared, light: &PatchLight) -> Vec<f32> {
        let patches = &prepared.mesh.patches;
        let mut values = vec![NO_VALUE; patches.len()];
        for &(j, f) in &self.row {
            let (Some(value), Some(patch)) = (values.get_mut(j as usize), patches.get(j as usize)) else {
                continue;
            };
            *value = match quantity {
                Quantity::RowLight => {
                    let b = light.radiosity.get(j as usize).copied().unwrap_or_default();
                    f * illuminance(b.map(f64::from)) / patch.area
                }
                Quantity::RowFactor => f,
                _ => f / patch.area,
            } as f32;
        }
        values
    }
}

/// Where a row comes from.
enum RowSource {
    Balanced(Arc<dyn Transport>),
    Sampled(Arc<RowComputer>),
}

/// What every patch has of sampling and solver errors, a value a patch; empty where not known yet.
#[derive(Default)]
pub(super) struct Maps {
    /// 1 less the row's sum: what leaves through openings, %; [`NO_VALUE`] for patches that see nothing.
    pub(super) escape: Vec<f32>,
    /// The row's sum as sampled less its sum now, %: what balancing changed.
    pub(super) closure: Vec<f32>,
    /// Largest gap between A_i F_ij and A_j F_ji as sampled over A_i, %.
    pub(super) reciprocity: Vec<f32>,
    /// Luminance that one more sweep would add, cd/m².
    pub(super) residual: Vec<f32>,
    /// Luminous flux that has not been passed on, lm.
    pub(super) unshot: Vec<f32>,
}

impl Maps {
    fn compute(wanted: &MapSource) -> Self {
        let mut maps = Self::default();
        let patches = &wanted.prepared.mesh.patches;
        let translucence = &wanted.prepared.mesh.translucence;
        let mut waiting: Vec<[f32; 3]> = Vec::new();
        if let Some(transport) = &wanted.transport {
            for i in 0..transport.len() {
                let (sum, quality) = (transport.row_sum(i), transport.quality(i));
                // What single precision rounds off is no defect.
                let percent = |share: f64| if share.abs() < 2e-7 { 0.0 } else { (100.0 * share) as f32 };
                // What lies under something takes no part: nothing escapes it.
                maps.escape.push(if transport.sees(i) { percent(1.0 - sum) } else { NO_VALUE });
                maps.closure.push(percent(f64::from(quality.sampled_sum) - sum));
                maps.reciprocity.push(100.0 * quality.worst_reciprocity);
            }
            if !wanted.light.radiosity.is_empty() {
                waiting = residual(transport.as_ref(), (&wanted.reflectance, translucence), &wanted.light);
            }
        } else if let Some(unshot) = &wanted.unshot {
            waiting = unshot.sum(&wanted.lighting, patches.len());
        }
        maps.residual = waiting.iter().map(|r| luminance(*r) as f32).collect();
        maps.unshot = waiting
            .iter()
            .zip(patches)
            .map(|(r, patch)| {
                (LUMINOUS_EFFICACY * luminance_weighted(r.map(f64::from)).abs() * patch.area) as f32
            })
            .collect();
        maps
    }

    /// The map of a quantity; empty where it is none of these or not known yet.
    pub(super) fn of(&self, quantity: Quantity) -> &[f32] {
        match quantity {
            Quantity::Escape => &self.escape,
            Quantity::Closure => &self.closure,
            Quantity::Reciprocity => &self.reciprocity,
            Quantity::Residual => &self.residual,
            Quantity::Unshot => &self.unshot,
            _ => &[],
        }
    }
}

/// All that maps are computed from.
struct MapSource {
    prepared: Arc<Prepared>,
    transport: Option<Arc<dyn Transport>>,
    unshot: Option<Arc<LightBases>>,
    reflectance: Arc<Vec<[f32; 3]>>,
    light: PatchLight,
    lighting: Lighting,
}

/// Which matrix: none is one of its own.
#[derive(Clone, Debug)]
struct MatrixId(Option<Weak<dyn Transport>>);

impl PartialEq for MatrixId {
    fn eq(&self, other: &Self) -> bool {
        // A weak pointer keeps the address from being used again.
        match (&self.0, &other.0) {
            (Some(one), Some(other)) => one.ptr_eq(other),
            (one, other) => one.is_none() && other.is_none(),
        }
    }
}

/// The mesh, its matrix, and the patch or the version of the light.
type Key = (u64, MatrixId, u64);

/// The light as it is shown.
pub(super) struct Shown<'a> {
    /// The scene on screen.
    pub(super) prepared: &'a Arc<Prepared>,
    /// Reflectance of the patches.
    pub(super) reflectance: &'a Arc<Vec<[f32; 3]>>,
    /// Light of the patches.
    pub(super) light: &'a PatchLight,
    /// Grows with every change of it.
    pub(super) light_version: u64,
    /// The lamps.
    pub(super) lighting: &'a Lighting,
}

/// What was looked into last, and the maps.
#[derive(Default)]
pub(super) struct Microscope {
    inspection: Background<Key, Inspection>,
    maps: Background<Key, Maps>,
    /// Grows with every answer.
    pub(super) version: u64,
}

impl Microscope {
    /// Asks for what is wanted now and takes over what has come. Returns whether something has.
    pub(super) fn follow(
        &mut self,
        snapshot: &Snapshot,
        shown: &Shown<'_>,
        patch: Option<u32>,
        maps_wanted: bool,
        ctx: &egui::Context,
    ) -> bool {
        let news = self.inspection.listen() | self.maps.listen();
        self.version += u64::from(news);
        let serial = shown.prepared.mesh_serial;
        if serial != snapshot.mesh_serial {
            return news;
        }
        let matrix = MatrixId(snapshot.transport().map(Arc::downgrade));
        let wake = || {
            let ctx = ctx.clone();
            move || ctx.request_repaint()
        };
        let inside = |patch: &u32| (*patch as usize) < shown.prepared.mesh.patches.len();
        if let Some(patch) = patch.filter(inside) {
            let key = (serial, matrix.clone(), u64::from(patch));
            let balanced = snapshot.transport().cloned().map(RowSource::Balanced);
            let source = balanced.or_else(|| snapshot.computer().cloned().map(RowSource::Sampled));
            if let Some(source) = source.filter(|_| self.inspection.is_open(&key)) {
                let prepared = Arc::clone(shown.prepared);
                self.inspection.ask(&key, move || Inspection::look(&prepared, &source, patch), wake());
            }
        }
        let key = (serial, matrix, shown.light_version);
        if maps_wanted && self.maps.is_open(&key) {
            let source = MapSource {
                prepared: Arc::clone(shown.prepared),
                transport: snapshot.transport().cloned(),
                unshot: snapshot.unshot.clone(),
                reflectance: Arc::clone(shown.reflectance),
                light: shown.light.clone(),
                lighting: shown.lighting.clone(),
            };
            self.maps.ask(&key, move || Maps::compute(&source), wake());
        }
        news
    }

    /// Forgets everything: another mesh is on screen.
    pub(super) fn forget(&mut self) {
        self.inspection.forget();
        self.maps.forget();
        self.version += 1;
    }

    /// The inspection that came last, which may be of the patch looked into before.
    pub(super) fn inspection(&self) -> Option<&Inspection> {
        self.inspection.latest().map(|(_, inspection)| &**inspection)
    }

    /// The maps that came last, which may be of the light before.
    pub(super) fn maps(&self) -> Option<&Maps> {
        self.maps.latest().map(|(_, maps)| &**maps)
    }

    /// The values of a quantity of the microscope, one a patch; `None` where they are not there yet.
    pub(super) fn scalars(
        &self,
        quantity: Quantity,
        prepared: &Prepared,
        light: &PatchLight,
    ) -> Option<Vec<f32>> {
        if quantity.is_row() {
            return Some(self.inspection()?.heat_map(quantity, prepared, light));
        }
        let values = self.maps()?.of(quantity);
        (!values.is_empty()).then(|| values.to_vec())
    }
}
