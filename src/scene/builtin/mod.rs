//! Scenes that the program carries.

/// The texts of an embedded scene.
#[derive(Clone, Debug)]
pub struct BuiltinSource {
    /// OBJ text.
    pub obj: String,
    /// MTL text.
    pub mtl: String,
    /// Sidecar text (TOML).
    pub sidecar: String,
}

/// Names of the embedded scenes.
pub const NAMES: &[&str] = &[];

/// The texts of the embedded scene `name`; `None` where there is no such scene.
pub fn source(_name: &str) -> Option<BuiltinSource> {
    None
}
