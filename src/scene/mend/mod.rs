//! A mended copy of a model: corners welded, faces without area and those that are there twice left
//! out, faces cut where others pass through them, T-vertices made corners of both, neighbours turned to
//! face one way.
//!
//! What emits keeps its side. Materials, lamps, views and the objects' names stay as they are.

mod library;
mod shape;
mod split;
mod texts;

use super::doctor;
use super::error::SceneError;
use super::types::Scene;
pub use library::CopiedImage;
use shape::Shape;
use std::path::{Path, PathBuf};

/// Times that faces are cut at most: cutting one may bring to light that its part is cut again.
const MOST_ROUNDS: usize = 4;
/// With more places where faces cut through each other no face is cut.
const MOST_CUTS: usize = 100_000;

/// The texts of a mended copy, and what was mended.
#[derive(Clone, Debug)]
pub struct Mended {
    /// Wavefront OBJ, in the unit of the model; it names `NAME.mtl` as its library.
    pub obj: String,
    /// The libraries of the model in one, images named as they are found from the folder of the copy; or one of its
    /// materials, where it is no OBJ.
    pub mtl: String,
    /// Images that are to stand beside the copy.
    pub images: Vec<CopiedImage>,
    /// The sidecar as it was, where there was one; photometric files are named as they are found from that folder. Of a
    /// model that is no OBJ also what only a sidecar can say in a copy: its unit, lights and cameras.
    pub sidecar: Option<String>,
    /// What was done, a short sentence each; empty where nothing had to be mended.
    pub done: Vec<String>,
    /// What was left as it was, and why.
    pub left: Vec<String>,
    /// Files that the model was read from: a copy must not replace any of them.
    pub sources: Vec<PathBuf>,
}

/// Mends a scene that was read from files or is embedded. `copy` is the OBJ file that the texts are
/// meant for; nothing is written.
///
/// # Errors
/// Where a file of the model can no longer be read.
pub fn mend(scene: &Scene, copy: &Path) -> Result<Mended, SceneError> {
    let originals = texts::originals(scene, copy)?;
    // Lamps that the sidecar places stay there.
    let scene = &scene.with_placed(Vec::new());
    let diagonal = scene.extent().scale;
    let mut shape = Shape::of(scene);
    let (mut done, mut left): (_, Vec<String>) = (Vec::new(), Vec::new());
    let mut tell = |count: usize, one: &str, many: &str| {
        if count > 0 {
            done.push(format!("{count} {}", if count == 1 { one } else { many }));
        }
    };

    // 1. Corners and faces that are there twice become one, and neighbours share their corners.
    let faces = shape.scene.surfaces.len();
    let welded = shape.weld(diagonal) + shape.close_cracks(diagonal);
    tell(welded, "corner was welded to another", "corners were welded to others");
    shape.tidy();
    let dropped = faces.saturating_sub(shape.scene.surfaces.len());
    tell(
        dropped,
        "face without area or there twice was dropped",
        "faces without area or there twice were dropped",
    );
    let mut added = 0;
    for tolerance in [doctor::WELD * diagonal, doctor::crack(diagonal)] {
        added += shape.add_missing_corners(tolerance);
        shape.tidy();
    }

    // 2. Faces end where others pass through them, and their neighbours share the corners there.
    let mut cut = 0;
    for _ in 0..MOST_ROUNDS {
        let crossings = doctor::crossings(&shape.scene);
        if crossings.is_empty() || crossings.len() > MOST_CUTS {
            break;
        }
        cut += split::split(&mut shape, &crossings, diagonal);
        shape.weld(diagonal);
        shape.tidy();
        added += shape.add_missing_corners(doctor::WELD * diagonal);
        shape.tidy();
    }
    tell(
        cut,
        "face was cut where another passes through it",
        "faces were cut where others pass through them",
    );
    tell(added, "corner was added to a neighbour's edge", "corners were added to neighbours' edges");

    // 3. Neighbours face one way; what emits stays.
    let (turned, opposed_lamps) = shape.turn_minorities();
    tell(
        turned,
        "face was turned to face as its neighbours do",
        "faces were turned to face as their neighbours do",
    );
    if opposed_lamps > 0 {
        left.push(format!(
            "{opposed_lamps} emitting {} against their neighbours, for light leaves from their front",
            if opposed_lamps == 1 { "face is turned" } else { "faces are turned" }
        ));
    }
    let rest = doctor::check(&shape.scene).into_iter();
    left.extend(rest.filter(|f| f.kind.is_mended()).map(|f| f.message));
    Ok(Mended {
        obj: texts::obj(&shape.scene, &originals, copy),
        mtl: originals.mtl,
        images: originals.images,
        sidecar: originals.sidecar,
        done,
        left,
        sources: originals.sources,
    })
}
