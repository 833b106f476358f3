//! What a solved scene becomes in files. The window and the command line both write through here,
//! so that a table, a picture or a mesh holds the same whichever of them made it.

mod lit_mesh;
mod page;
mod patch_table;
mod repaired;
mod still;
mod target;

pub use lit_mesh::save_lit_mesh;
pub use page::{LitPlane, Page, html as page_html};
pub use patch_table::{LitScene, save_patch_table};
pub use repaired::{RepairError, is_same_file, save_repaired};
pub use still::{StillKind, StillLight, save_still};
pub use target::{TARGETS, Target};

use crate::solver::Detail;

/// The light of elements as the display takes it.
pub fn in_detail(detail: &Detail) -> crate::display::Detail<'_> {
    crate::display::Detail {
        direct: &detail.direct,
        interreflected: &detail.interreflected,
        reflectance: &detail.reflectance,
    }
}
