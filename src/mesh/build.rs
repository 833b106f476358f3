use super::backing::{Backing, Sheets};
use super::contacts::Edges;
use super::grading::{Grading, Lamps};
use super::patches;
use super::pieces::{self, Cut, Grid};
use super::reach::{Buried, Reach, Search};
use super::refinement::Refinement;
use super::regions::{self, Outline};
use super::types::{MeshStatistics, NO_PATCH, Patch, PatchMesh, Side};
use crate::geometry::polygon;
use crate::scene::{Extent, Scene};
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::sync::Arc;

/// How finely surfaces are split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PatchTarget {
    /// What the scene's sidecar asks for; else a size that gives about 3,000 patches or more.
    #[default]
    Auto,
    /// Longest edge of a patch, metres; above zero.
    Size(f64),
    /// About this many patches in all; at least one a side.
    Count(usize),
    /// Every input polygon is one patch.
    AsGiven,
}

/// Everything that the mesh depends on besides the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshSettings {
    /// How finely surfaces are split.
    pub target: PatchTarget,
    /// Which backs take part.
    pub backs: Backs,
    /// Whether reflectances follow textures (see [`crate::effects::Effect::Textures`]).
    pub textures: bool,
    /// Where patches are to be smaller than elsewhere.
    pub refinement: Option<Arc<Refinement>>,
}

/// Which backs of surfaces take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Backs {
    /// Those that light can reach.
    #[default]
    Reached,
    /// None but those that emit: every surface is lit on its front, and only there.
    None,
    /// All.
    All,
}

impl Default for MeshSettings {
    fn default() -> Self {
        Self { target: PatchTarget::Auto, backs: Backs::Reached, textures: true, refinement: None }
    }
}

/// Why a scene cannot be cut into patches.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// No surface has any area.
    #[error("the scene holds no surface with an area, so there is nothing to light")]
    Empty,
    /// The patch size is not a positive number.
    #[error("the patch size must be above zero, not {0}: give it in the units of the scene")]
    Size(f64),
    /// More patches than the indices and the memory of a desktop machine can hold.
    #[error(
        "a patch size of {size} m gives about {patches} patches, more than {limit}: choose a larger size"
    )]
    TooMany {
        /// The edge asked for, metres.
        size: f64,
        /// The estimate.
        patches: usize,
        /// The most that is meshed.
        limit: usize,
    },
}

/// Of a number of patches so much may go where a refinement asks for smaller ones.
const MOST_ASKED: f64 = 0.7;
/// A refinement is not loosened further than to edges so many times as long.
const MOST_SLACK: f64 = 64.0;
/// The most patches that [`build`] makes.
const PATCH_LIMIT: usize = 2_000_000;

/// Splits the surfaces of a scene into patches.
pub fn build(scene: &Scene, settings: &MeshSettings) -> Result<PatchMesh, MeshError> {
    // 1. Join coplanar neighbours, and find the sides that light can reach.
    let extent = scene.extent();
    let size = extent.scale;
    let as_given = settings.target == PatchTarget::AsGiven;
    let (mut outlines, dropped) = regions::join(scene, size, as_given);
    let is_counted = match settings.target {
        PatchTarget::Count(_) => true,
        PatchTarget::Auto => scene.patch_size.is_none(),
        PatchTarget::Size(_) | PatchTarget::AsGiven => false,
    };
    outlines.iter_mut().for_each(|outline| outline.coarsest = coarsest(outline, &extent, is_counted));
    if outlines.is_empty() {
        return Err(MeshError::Empty);
    }
    let sheets = Sheets::new(&outlines, size);
    let mut search = Search::new(scene, &outlines, &sheets, size);
    let mut reached: Vec<[Reach; 2]> = match settings.backs {
        Backs::Reached => search.sides(),
        Backs::None => outlines
            .iter()
            .map(|o| {
                [Reach::Lit, if o.luminaire.is_some() && o.emits_back { Reach::Lit } else { Reach::Black }]
            })
            .collect(),
        Backs::All => vec![[Reach::Lit; 2]; outlines.len()],
    };
    for (reached, backing) in reached.iter_mut().zip(&sheets.backing) {
        if *backing == Backing::Whole {
            reached[Side::Back as usize] = Reach::Backed;
        }
    }
    let sides: Vec<[bool; 2]> = reached.iter().map(|r| r.map(|side| side == Reach::Lit)).collect();

    // 2. Choose the patch size and cut.
    let mut finer = Finer {
        lamps: Lamps::new(scene, &outlines, &sides, size),
        refinement: settings.refinement.as_deref(),
        slack: 1.0,
    };
    let patch_size = patch_size(scene, settings.target, &outlines, &sides, &mut finer)?;
    let mut mesh = PatchMesh { size, ..PatchMesh::default() };
    let edges = Edges::new(if as_given { &[] } else { &outlines }, size);
    for (index, outline) in outlines.iter().enumerate() {
        let groups = if as_given {
            pieces::append_as_given(&mut mesh, outline);
            let region = &mesh.regions[index];
            patches::group_by_surface(&mesh, region.pieces.clone())
        } else {
            let grid = Grid::new(outline, patch_size);
            let grading = finer.on(index, outline, sides[index], patch_size);
            let mut contacts = edges.on(index, outline, grading.shortest(&grid));
            let cuts: Vec<Cut> = pieces::cut(outline, &grid, &mut contacts, &grading);
            pieces::append(&mut mesh, outline, &grid, &cuts);
            let contacts: Vec<[DVec2; 2]> = contacts.iter().map(|contact| contact.ends).collect();
            let pieces = mesh.regions[index].pieces.clone();
            let groups = patches::group_by_cell(&mesh, pieces, &grid, &cuts, &contacts);
            mesh.contacts.push(contacts);
            groups
        };
        // 3. One patch a group and lit side; none where another surface lies on the back.
        mark_backed(&mut mesh, &sheets, index);
        for side in [Side::Front, Side::Back] {
            if sides[index][side as usize] {
                for group in &groups {
                    let is_open = |p: &&u32| side == Side::Front || !mesh.pieces[**p as usize].backed;
                    let open: Vec<u32> = group.iter().filter(is_open).copied().collect();
                    patches::append(&mut mesh, scene, outline, side, &open, settings.textures);
                }
            }
        }
    }
    if mesh.patches.is_empty() {
        return Err(MeshError::Empty);
    }
    let front_is_dark = |&index: &u32| reached[index as usize][Side::Front as usize] == Reach::Dark;
    for (index, region) in mesh.regions.iter_mut().enumerate() {
        region.dark = reached[index].map(|side| side == Reach::Dark);
        if region.backing == Backing::Whole {
            region.dark[Side::Back as usize] = sheets.backers[index].iter().all(front_is_dark);
        }
    }
    if settings.backs == Backs::Reached {
        let found = search.buried(&reached, &mesh.patches, |patch| patches::inner_points(&mesh, patch));
        for (index, buried) in found.into_iter().enumerate() {
            match buried {
                Some(Buried::Whole) => mesh.patches[index].buried = true,
                Some(Buried::LitAt(point)) => patches::move_centre(&mut mesh, index, point),
                None => {}
            }
        }
    }
    mesh.blockers = blockers(&outlines, size);
    mesh.statistics = statistics(&mesh, scene, &sides, dropped, patch_size);
    Ok(mesh)
}

/// Notes which pieces of the last region, made of the outline at `index`, have another surface on their back:
/// on all of it, for a ray that passed beside that surface would find nothing.
fn mark_backed(mesh: &mut PatchMesh, sheets: &Sheets<'_>, index: usize) {
    /// Points are this share of the way from the corners to the middle of a piece.
    const INSET: f64 = 0.02;
    let Some(region) = mesh.regions.last_mut() else { return };
    region.backing = sheets.backing[index];
    for p in region.pieces.clone() {
        let corners: Vec<DVec2> = mesh.corners_of(&mesh.pieces[p as usize]).iter().map(|c| c.plane).collect();
        let middle = polygon::centroid_2d(&corners);
        let mut points = std::iter::once(middle).chain(corners.iter().map(|c| c.lerp(middle, INSET)));
        mesh.pieces[p as usize].backed = points.all(|at| sheets.covers_back(index, at));
    }
}

/// Below which edge patches of an outline are not cut, metres: a share of it where it is far away from the rest,
/// and where it is larger than what tolerances follow, as terrain is around a house.
fn coarsest(outline: &Outline, extent: &Extent, is_counted: bool) -> f64 {
    let longest = (outline.max - outline.min).max_element();
    if !extent.holds(&outline.bounds) {
        longest / 8.0
    } else if is_counted && longest > extent.scale {
        longest / 24.0
    } else {
        0.0
    }
}

/// Convex parts of surfaces large enough to hide much of the scene, by falling area.
fn blockers(outlines: &[Outline], size: f64) -> Vec<Vec<DVec3>> {
    const MOST: usize = 512;
    let mut large: Vec<(f64, Vec<DVec3>)> = outlines
        .iter()
        .flat_map(|o| o.parts.iter().map(move |part| (o, part)))
        .map(|(o, part)| (polygon::area_2d(&part.corners), o, part))
        .filter(|(area, ..)| *area > 5e-4 * size * size)
        .map(|(area, o, part)| (area, part.corners.iter().map(|&c| o.world(c)).collect()))
        .collect();
    large.sort_by(|a, b| b.0.total_cmp(&a.0));
    large.truncate(MOST);
    large.into_iter().map(|(_, corners)| corners).collect()
}

/// How much of the rectangle around it an outline fills.
fn filled(outline: &Outline) -> f64 {
    let extent = outline.max - outline.min;
    (outline.area / (extent.x * extent.y).max(f64::MIN_POSITIVE)).min(1.0)
}

/// How many sides take part.
fn taking_part(sides: [bool; 2]) -> f64 {
    f64::from(u8::from(sides[0]) + u8::from(sides[1]))
}

/// What asks for patches that are smaller than elsewhere.
struct Finer<'a> {
    lamps: Lamps,
    refinement: Option<&'a Refinement>,
    /// How many times as long as the refinement asks for edges may be.
    slack: f64,
}

impl Finer<'_> {
    /// What is asked of one outline in a mesh of patches of edge `size`.
    fn on(&self, index: usize, outline: &Outline, sides: [bool; 2], size: f64) -> Grading<'_> {
        let wishes = self.refinement.map(|r| r.wishes(index, outline, self.slack * size)).unwrap_or_default();
        self.lamps.grading(outline, sides, size, wishes)
    }

    /// How many patches more than [`estimate`] says the lit sides have by that.
    fn estimate(&self, outlines: &[Outline], sides: &[[bool; 2]], size: f64) -> f64 {
        let more = |(index, outline): (usize, &Outline)| {
            let grading = self.on(index, outline, sides[index], size);
            if grading.is_empty() {
                return 0.0;
            }
            let grid = Grid::new(outline, size);
            let cells = 0..grid.cells[0] * grid.cells[1];
            let halves = |cell| grading.leaves(outline, grid.corner(cell), grid.cell).len() - 1;
            let leaves: usize = cells.map(halves).sum();
            leaves as f64 * filled(outline) * taking_part(sides[index])
        };
        outlines.par_iter().enumerate().map(more).collect::<Vec<f64>>().iter().sum()
    }
}

/// About how many patches of edge `size` the lit sides give where nothing asks for smaller ones.
fn estimate(outlines: &[Outline], sides: &[[bool; 2]], size: f64) -> f64 {
    outlines
        .iter()
        .zip(sides)
        .map(|(outline, sides)| {
            let extent = outline.max - outline.min;
            let size = size.max(outline.coarsest);
            let cells = (extent.x / size).ceil().max(1.0) * (extent.y / size).ceil().max(1.0);
            (cells * filled(outline)).max(1.0) * taking_part(*sides)
        })
        .sum()
}

fn patch_size(
    scene: &Scene,
    target: PatchTarget,
    outlines: &[Outline],
    sides: &[[bool; 2]],
    finer: &mut Finer<'_>,
) -> Result<f64, MeshError> {
    let plain = |count: f64| {
        let (mut low, mut high) = (1e-6_f64, 10.0);
        let longest = outlines.iter().map(|o| (o.max - o.min).max_element()).fold(0.0, f64::max);
        for _ in 0..60 {
            let middle = (low * high).sqrt();
            if estimate(outlines, sides, middle * longest) > count {
                low = middle;
            } else {
                high = middle;
            }
        }
        high * longest
    };
    let mut for_count = |count: f64| loop {
        // What is asked for in places comes out of the same number; the rest makes do with larger patches.
        let mut rest = count;
        for _ in 0..6 {
            let more = finer.estimate(outlines, sides, plain(rest));
            rest = (0.5 * (rest + count - more)).max(0.25 * count);
        }
        let size = plain(rest);
        let more = finer.estimate(outlines, sides, size);
        if finer.refinement.is_none() || more <= MOST_ASKED * count || finer.slack > MOST_SLACK {
            return size;
        }
        // Where surfaces are many and small, the rest cannot make do.
        finer.slack *= (more / (MOST_ASKED * count)).sqrt().clamp(1.1, 4.0);
    };
    let size = match target {
        PatchTarget::Size(size) if !(size > 0.0 && size.is_finite()) => return Err(MeshError::Size(size)),
        PatchTarget::Size(size) => size,
        PatchTarget::Count(count) => for_count(count.max(1) as f64),
        PatchTarget::AsGiven => f64::INFINITY,
        PatchTarget::Auto => scene.patch_size.unwrap_or_else(|| for_count(3000.0)),
    };
    let mut patches = estimate(outlines, sides, size.max(f64::MIN_POSITIVE));
    if patches <= PATCH_LIMIT as f64 && target != PatchTarget::AsGiven {
        patches += finer.estimate(outlines, sides, size);
    }
    if patches > PATCH_LIMIT as f64 {
        return Err(MeshError::TooMany { size, patches: patches as usize, limit: PATCH_LIMIT });
    }
    Ok(size)
}

fn statistics(
    mesh: &PatchMesh,
    scene: &Scene,
    sides: &[[bool; 2]],
    dropped: usize,
    patch_size: f64,
) -> MeshStatistics {
    let mut aspects: Vec<f64> = mesh.patches.iter().map(|p| patches::aspect(mesh, p)).collect();
    aspects.sort_by(f64::total_cmp);
    let areas = mesh.patches.iter().map(|p: &Patch| p.area);
    MeshStatistics {
        patches: mesh.patches.len(),
        emitters: mesh.patches.iter().filter(|p| p.luminaire.is_some()).count(),
        regions: mesh.regions.len(),
        surfaces: scene.surfaces.len(),
        dark_sides: sides.iter().flatten().filter(|&&s| !s).count(),
        dropped,
        area: areas.clone().sum(),
        smallest_area: areas.clone().fold(f64::INFINITY, f64::min),
        largest_area: areas.fold(0.0, f64::max),
        median_aspect: aspects.get(aspects.len() / 2).copied().unwrap_or(1.0),
        worst_aspect: aspects.last().copied().unwrap_or(1.0),
        patch_size,
    }
}

impl PatchMesh {
    /// The patch on `side` of a piece.
    pub fn patch_on(&self, piece: u32, side: Side) -> Option<u32> {
        let patch = self.pieces[piece as usize].patches[side as usize];
        (patch != NO_PATCH).then_some(patch)
    }
}
