use super::backing::{Backing, Sheets};
use super::clusters::{self, Clusters, Facet};
use super::contacts::Contacts;
use super::grading::{Grading, Lamps};
use super::patches;
use super::pieces::{self, Cut, Grid};
use super::reach::{Buried, LightSearch, Reach, Search};
use super::refinement::Refinement;
use super::regions::Outline;
use super::shells::dark_as_wholes;
use super::sizing::{self, Finer};
use super::survey::Survey;
use super::translucence::Translucence;
use super::types::{MeshStatistics, NO_PATCH, Patch, PatchMesh, Side};
use crate::geometry::polygon;
use crate::scene::{Scene, grouped};
use crate::watch::{Cancelled, Watch};
use glam::{DVec2, DVec3};
use std::sync::Arc;

/// How finely surfaces are split.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum PatchTarget {
    /// What the scene's sidecar asks for; else as [`Self::Count`] with 3,000 patches.
    #[default]
    Auto,
    /// Longest edge of a patch, metres; above zero.
    Size(f64),
    /// About this many patches on the surfaces that are larger than a patch. Smaller ones need one patch per
    /// side, and these come on top: the walls of a room are cut as finely whatever stands in it.
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
    /// Whether light passes glass (see [`crate::effects::Effect::Glass`]); it is opaque otherwise.
    pub glass: bool,
    /// Whether light passes cloth, paper and the like (see [`crate::effects::Effect::Translucency`]).
    pub translucency: bool,
    /// Whether light passes surfaces where their images are transparent (see [`crate::effects::Effect::Holes`]).
    pub holes: bool,
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
        Self {
            target: PatchTarget::Auto,
            backs: Backs::Reached,
            textures: true,
            glass: true,
            translucency: true,
            holes: true,
            refinement: None,
        }
    }
}

impl MeshSettings {
    /// Whether light passes the holes of a material.
    pub(super) fn has_holes(&self, scene: &Scene, material: u32) -> bool {
        self.holes && self.textures && scene.has_holes(material)
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
    #[error("{}", too_many(*size, *patches, *whole, *limit))]
    TooMany {
        /// The edge asked for, metres.
        size: f64,
        /// The estimate.
        patches: usize,
        /// Of these, sides of faces smaller than a patch, which need one each.
        whole: usize,
        /// The most that is meshed.
        limit: usize,
    },
    /// The watch ended it.
    #[error("the mesh was cancelled")]
    Cancelled,
}

/// What helps depends on where the patches come from.
fn too_many(size: f64, patches: usize, whole: usize, limit: usize) -> String {
    let [patches, whole_told, limit_told] = [patches, whole, limit].map(|n| grouped(n as i64));
    if whole > limit / 2 {
        format!(
            "{whole_told} sides of small faces need one patch each, and at most {limit_told} patches can be solved: \
             simplify or remove what has so many faces (leaves, mouldings, screws)"
        )
    } else {
        format!(
            "a patch size of {size} m gives about {patches} patches, more than {limit_told}: choose a larger size \
             or fewer patches"
        )
    }
}

impl From<Cancelled> for MeshError {
    fn from(Cancelled: Cancelled) -> Self {
        Self::Cancelled
    }
}

/// Shares of the time by which a scene is surveyed, and by which what is left is cut, about; the rest goes into
/// what lies under something.
const SURVEYED: f64 = 0.9;
const CUT: f64 = 0.6;
/// The most patches that [`build`] makes.
pub(super) const PATCH_LIMIT: usize = 2_000_000;

/// Splits the surfaces of a scene into patches.
///
/// # Errors
/// There is nothing to light, or the settings ask for more than a machine can hold.
pub fn build(scene: &Scene, settings: &MeshSettings) -> Result<PatchMesh, MeshError> {
    Watch::nobody(|watch| build_watched(scene, settings, watch))
}

/// As [`build`], for somebody who watches and may end it.
///
/// # Errors
/// Also [`MeshError::Cancelled`].
pub fn build_watched(
    scene: &Scene,
    settings: &MeshSettings,
    watch: &mut Watch<'_>,
) -> Result<PatchMesh, MeshError> {
    let survey = Survey::new(scene, settings, LightSearch::Full, &mut watch.part(0.0, SURVEYED))?;
    build_on(&survey, scene, settings, &mut watch.part(SURVEYED, 1.0))
}

/// As [`build_watched`], on a survey of the same scene that [serves](Survey::serves) the settings.
///
/// # Errors
/// As [`build_watched`].
pub fn build_on(
    survey: &Survey,
    scene: &Scene,
    settings: &MeshSettings,
    watch: &mut Watch<'_>,
) -> Result<PatchMesh, MeshError> {
    let Survey { outlines, dropped, reached, sheets, sources, .. } = survey;
    let (size, sides) = (survey.size, survey.sides());
    let as_given = settings.target == PatchTarget::AsGiven;

    // 1. Choose the patch size and cut.
    let lamps = Lamps::new(scene, (outlines, &survey.panes), &sides, size);
    let mut finer = Finer::new(lamps, settings.refinement.as_deref());
    let sizing = sizing::patch_size(scene, settings.target, outlines, &sides, &mut finer)?;
    let patch_size = sizing.edge;
    let mut facets: Vec<Facet> = Vec::new();
    let asked = sizing::count_asked(scene, settings.target);
    let photometric = scene.photometric_sources();
    let outdoors = scene.outdoors.clone().map(Arc::new);
    let middle = scene.extent().main.centre();
    let panes = Arc::clone(&survey.panes);
    let mut mesh = PatchMesh { size, photometric, outdoors, middle, panes, ..PatchMesh::default() };
    let contacts = Contacts::new(if as_given { &[] } else { outlines }, size, watch.cancelled())?;
    let mut cutting = watch.part(0.0, CUT);
    for (index, outline) in outlines.iter().enumerate() {
        cutting.done(index as f64 / outlines.len() as f64)?;
        let groups = if as_given {
            pieces::append_as_given(&mut mesh, outline);
            let region = &mesh.regions[index];
            patches::group_by_surface(&mesh, region.pieces.clone())
        } else {
            let grid = Grid::new(outline, patch_size);
            let shares = sizing.clusters.is_some() && sizing::is_small(outline, patch_size);
            let (grading, mut lines) = if shares {
                (Grading::none(), Vec::new())
            } else {
                let grading = finer.on(index, outline, sides[index], patch_size);
                let lines = contacts.on(index, outline, grading.shortest(&grid));
                (grading, lines)
            };
            let cuts: Vec<Cut> = pieces::cut(outline, &grid, &mut lines, &grading);
            pieces::append(&mut mesh, outline, &grid, &cuts);
            let lines: Vec<[DVec2; 2]> = lines.iter().map(|contact| contact.ends).collect();
            let pieces = mesh.regions[index].pieces.clone();
            mesh.contacts.push(lines);
            if shares {
                mesh.append_convex(index, outline);
                mark_backed(&mut mesh, sheets, index);
                facets.extend(small_facets(&mesh, pieces, sides[index]));
                continue;
            }
            patches::group_by_cell(&mesh, pieces, &grid, &cuts, &mesh.contacts[index])
        };
        mesh.append_convex(index, outline);
        // 2. One patch per group and lit side; none where another surface lies on the back.
        mark_backed(&mut mesh, sheets, index);
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
    // 3. What small faces share.
    let wanted = sizing.clusters.unwrap_or(f64::INFINITY);
    Clusters::append(&mut mesh, scene, &facets, (wanted, patch_size), settings.textures);
    if mesh.patches.is_empty() {
        return Err(MeshError::Empty);
    }
    let dark: Vec<[bool; 2]> = reached.iter().map(|sides| sides.map(|reach| reach == Reach::Dark)).collect();
    let wholes = dark_as_wholes(outlines, size, reached);
    for (index, region) in mesh.regions.iter_mut().enumerate() {
        [region.dark, region.dark_as_whole] = [&dark, &wholes].map(|dark| match region.backing {
            Backing::Whole => {
                let front_is_dark = |&other: &u32| dark[other as usize][Side::Front as usize];
                [dark[index][Side::Front as usize], sheets.backers[index].iter().all(front_is_dark)]
            }
            _ => dark[index],
        });
    }
    if settings.backs == Backs::Reached {
        let points = |patch: &Patch| patches::inner_points(&mesh, patch);
        let search = Search::new(scene, outlines, sheets, sources);
        let found = search.buried(reached, &mesh.patches, points, &mut watch.part(CUT, 1.0))?;
        for (index, buried) in found.into_iter().enumerate() {
            match buried {
                Some(Buried::Whole) => mesh.patches[index].buried = true,
                Some(Buried::LitAt(point)) => patches::move_centre(&mut mesh, index, point),
                None => {}
            }
        }
    }
    if settings.translucency {
        mesh.translucence = Arc::new(Translucence::find(&mesh, scene, sheets));
    }
    if outlines.iter().any(|outline| outline.has_holes) {
        mesh.panes = Arc::new(mesh.panes.with_perforated(&mesh, sheets));
    }
    mesh.blockers = blockers(outlines, size);
    mesh.statistics = statistics(&mesh, scene, &sides, *dropped, (patch_size, asked));
    Ok(mesh)
}

/// Notes which pieces of the last region, made of the outline at `index`, have another surface on their back:
/// on all of it, for a ray that passed beside that surface would find nothing.
fn mark_backed(mesh: &mut PatchMesh, sheets: &Sheets, index: usize) {
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

/// Convex parts of surfaces large enough to hide much of the scene, by falling area.
fn blockers(outlines: &[Outline], size: f64) -> Vec<Vec<DVec3>> {
    const MOST: usize = 512;
    let mut large: Vec<(f64, Vec<DVec3>)> = outlines
        .iter()
        .filter(|o| !o.has_holes)
        .flat_map(|o| o.parts.iter().map(move |part| (o, part)))
        .map(|(o, part)| (polygon::area_2d(&part.corners), o, part))
        .filter(|(area, ..)| *area > 5e-4 * size * size)
        .map(|(area, o, part)| (area, part.corners.iter().map(|&c| o.world(c)).collect()))
        .collect();
    large.sort_by(|a, b| b.0.total_cmp(&a.0));
    large.truncate(MOST);
    large.into_iter().map(|(_, corners)| corners).collect()
}

/// The pieces of the last region, each as a facet on each active side.
fn small_facets(mesh: &PatchMesh, pieces: std::ops::Range<u32>, active: [bool; 2]) -> Vec<Facet> {
    let mut facets = Vec::new();
    for p in pieces {
        let piece = &mesh.pieces[p as usize];
        let material = mesh.regions[piece.region as usize].material;
        let centre = clusters::middle(mesh, p);
        for side in [Side::Front, Side::Back].into_iter().filter(|side| active[*side as usize]) {
            if side == Side::Front || !piece.backed {
                let normal = mesh.normal_of(piece, side);
                facets.push(Facet { material, side, centre, normal, piece: p });
            }
        }
    }
    facets
}

fn statistics(
    mesh: &PatchMesh,
    scene: &Scene,
    sides: &[[bool; 2]],
    dropped: usize,
    (patch_size, asked): (f64, Option<usize>),
) -> MeshStatistics {
    let single = mesh.patches.iter().filter(|p| !p.is_cluster);
    let mut aspects: Vec<f64> = single.map(|p| patches::aspect(mesh, p)).collect();
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
        asked,
        whole_sides: whole_sides(mesh),
        clusters: mesh.clusters.len(),
        clustered_sides: mesh.clusters.facets(),
    }
}

/// Sides of regions no larger than one patch of the usual size that have a patch of their own. Clusters come last.
fn whole_sides(mesh: &PatchMesh) -> usize {
    let side = |p: &Patch| (p.region, p.side);
    let single = &mesh.patches[..mesh.patches.len() - mesh.clusters.len()];
    let groups = single.chunk_by(|a, b| side(a) == side(b));
    groups.filter(|group| mesh.regions[group[0].region as usize].cells == [1, 1]).count()
}

impl PatchMesh {
    /// Adds the parts of the last region that hide something.
    fn append_convex(&mut self, index: usize, outline: &Outline) {
        if !outline.has_holes {
            self.convex.append(index as u32, outline);
        }
    }

    /// The patch on `side` of a piece.
    pub fn patch_on(&self, piece: u32, side: Side) -> Option<u32> {
        let patch = self.pieces[piece as usize].patches[side as usize];
        (patch != NO_PATCH).then_some(patch)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{SceneSource, load};
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn a_request_to_end_is_obeyed_at_the_next_look_wherever_it_comes() {
        let scene = load(&SceneSource::Builtin("gallery".to_owned())).expect("embedded");
        let settings = MeshSettings { target: PatchTarget::Count(500), ..MeshSettings::default() };
        let looks = AtomicUsize::new(0);
        let count = || {
            looks.fetch_add(1, Ordering::Relaxed);
            false
        };
        let mut told = Vec::new();
        let mut report = |share| told.push(share);
        let whole = build_watched(&scene, &settings, &mut Watch::new(&count, &mut report)).expect("a mesh");
        assert!(told.is_sorted() && told.last() == Some(&1.0), "shares rise to the whole");
        let all = looks.into_inner();
        assert!(all > 3 * whole.regions.len(), "each region is looked at in each step: {all}");
        for end in [0, 1, all / 10, all / 2, 9 * all / 10, all - 1] {
            let looks = AtomicUsize::new(0);
            let cancelled = || looks.fetch_add(1, Ordering::Relaxed) >= end;
            let ended = build_watched(&scene, &settings, &mut Watch::new(&cancelled, &mut |_| {}));
            assert_eq!(ended.err(), Some(MeshError::Cancelled), "after {end} of {all} looks");
            // Every thread looks once more at most.
            let further = looks.into_inner() - end;
            assert!(further <= rayon::current_num_threads() + 2, "{further} looks after the request");
        }
    }

    #[test]
    fn too_many_patches_are_refused_with_advice_that_helps() {
        let told = too_many(0.01, 3_000_000, 1000, 2_000_000);
        assert!(told.contains("about 3,000,000") && told.contains("choose a larger size"), "{told}");
        let told = too_many(1.0, 3_000_000, 2_900_000, 2_000_000);
        assert!(
            told.contains("2,900,000 sides") && told.contains("simplify") && !told.contains("larger size")
        );
    }
}
