//! Scenes that need no file: generated as OBJ, MTL and sidecar text, then read like any other.

mod cornell;
mod gallery;
mod hemicube;
mod house;
mod shapes;
mod writer;

/// Names of the embedded scenes; the first is the one to start with.
pub const NAMES: &[&str] = &["hemicube", "cornell", "house", "house-by-day", "gallery"];

/// The three texts of an embedded scene, as they would stand in files.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BuiltinSource {
    /// Wavefront OBJ: positions, smooth normals and polygons by object.
    pub obj: String,
    /// The material library: reflectances (Kd) and radiances (Ke, W/m²/sr).
    pub mtl: String,
    /// The sidecar in TOML: unit, views, luminaires, patch size.
    pub sidecar: String,
}

/// The texts of an embedded scene; `None` where [`NAMES`] does not list it.
pub fn source(name: &str) -> Option<BuiltinSource> {
    let model = match name {
        "hemicube" => hemicube::model(),
        "cornell" => cornell::model(),
        "house" => house::evening(),
        "house-by-day" => house::by_day(),
        "gallery" => gallery::model(),
        _ => return None,
    };
    Some(model.finish(name))
}
