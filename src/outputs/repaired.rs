use crate::export::{ExportError, atomic, write_png_with_alpha};
use crate::scene::{Mended, Scene, SceneError, mend, sidecar_path};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Why a repaired copy was not written; the model is untouched in any case.
#[derive(Debug, thiserror::Error)]
pub enum RepairError {
    /// The model can no longer be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A file of the copy would replace one of the model.
    #[error("{} is a file of the model itself; choose another name for the copy", .0.display())]
    Original(PathBuf),
    /// A sidecar that has nothing to do with the model would be taken for the copy's.
    #[error("{} is there and would change the copy, which has no sidecar; remove it or choose another name", .0.display())]
    ForeignSidecar(PathBuf),
    /// An image that has nothing to do with the model would be replaced.
    #[error("{} is there and is no image of an earlier copy; remove it or choose another name for the copy", .0.display())]
    ForeignImage(PathBuf),
    /// The system refused.
    #[error(transparent)]
    Export(#[from] ExportError),
}

/// Writes a mended copy of a model (see [`mend`]): `copy`, and beside it its library and, where the
/// model has one, its sidecar, and images where they stood within the model. Each is written to a temporary file,
/// then renamed, the OBJ last.
///
/// # Errors
/// See [`RepairError`].
pub fn save_repaired(copy: &Path, scene: &Scene) -> Result<Mended, RepairError> {
    let mended = mend(scene, copy)?;
    let (library, sidecar) = (copy.with_extension("mtl"), sidecar_path(copy));
    let files = [
        (&library, Some(&mended.mtl)),
        (&sidecar, mended.sidecar.as_ref()),
        (&copy.to_owned(), Some(&mended.obj)),
    ];
    let folder = copy.parent().unwrap_or(Path::new(""));
    let images: Vec<PathBuf> = mended.images.iter().map(|image| folder.join(&image.name)).collect();
    for path in files.iter().map(|(path, _)| *path).chain(&images) {
        if mended.sources.iter().any(|source| is_same_file(path, source)) {
            return Err(RepairError::Original(path.clone()));
        }
    }
    let earlier = std::fs::read(&library).unwrap_or_default();
    let earlier = String::from_utf8_lossy(&earlier);
    for (path, image) in images.iter().zip(&mended.images) {
        if path.exists() && !earlier.contains(&image.name) {
            return Err(RepairError::ForeignImage(path.clone()));
        }
    }
    if mended.sidecar.is_none() && sidecar.exists() {
        return Err(RepairError::ForeignSidecar(sidecar));
    }
    for (path, image) in images.iter().zip(&mended.images) {
        write_png_with_alpha(path, image.size[0], image.size[1], &image.rgba)?;
    }
    for (path, text) in files {
        if let Some(text) = text {
            atomic::write(path, |file| file.write_all(text.as_bytes()))?;
        }
    }
    Ok(mended)
}

/// Whether two paths lead to one file, by whatever links, or would if it were there.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt as _;
        if let (Ok(a), Ok(b)) = (std::fs::metadata(a), std::fs::metadata(b)) {
            return a.dev() == b.dev() && a.ino() == b.ino();
        }
    }
    match (whole(a), whole(b)) {
        (Some(a), Some(b)) => a == b,
        _ => false,
    }
}

/// A path without links, also of a file that is not there yet.
fn whole(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok().or_else(|| {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        Some(folder.canonicalize().ok()?.join(path.file_name()?))
    })
}
