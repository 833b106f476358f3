use super::extent::{Extent, Footprint};
use super::finding::Finding;
use super::outdoors::Outdoors;
use super::photometric::PhotometricLight;
use super::placed::PlacedLamp;
use super::text::folded;
use crate::geometry::Aabb;
use crate::glazing::Glazing;
use glam::{DVec2, DVec3};
use std::path::{Path, PathBuf};

pub use crate::daylight::LUMINOUS_EFFICACY;

/// Reflectances are clamped to this: no diffuse paint exceeds it, and the light must settle.
pub const MAX_REFLECTANCE: f64 = 0.98;

/// Rec. 709 luminance of linear R, G, B.
pub fn luminance_weighted(rgb: [f64; 3]) -> f64 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}

/// Illuminance in lux of an irradiance in W/m² per band.
pub fn illuminance(irradiance: [f64; 3]) -> f64 {
    LUMINOUS_EFFICACY * luminance_weighted(irradiance)
}

/// A model: polygons with names, materials, lamps and views. Lengths are metres.
#[derive(Clone, Debug)]
pub struct Scene {
    /// File stem or the name of the embedded scene.
    pub name: String,
    /// Where it came from, for reloading.
    pub source: SceneSource,
    /// The unit of the file; positions here are metres already.
    pub unit: LengthUnit,
    /// Which way is up in the file and here (axes are kept).
    pub up: UpAxis,
    /// Where [`Scene::positions`] count from in the file's coordinates, metres: zero but for models far
    /// from their origin, which would lose digits there.
    pub origin: DVec3,
    /// Corner positions, metres.
    pub positions: Vec<DVec3>,
    /// Unit normals that the file gives for smooth surfaces.
    pub normals: Vec<DVec3>,
    /// Texture coordinates, v upwards, with the scale and the offset of the material's image in them.
    pub uvs: Vec<DVec2>,
    /// The polygons, planar to within a part in a thousand of their size (the reader splits others).
    pub surfaces: Vec<Surface>,
    /// Names of objects and groups; [`Surface::object`] points here. Where the file gives a name to several
    /// objects they are numbered here: "downlight 1", "downlight 2".
    pub objects: Vec<String>,
    /// The names that the file gives to `objects`, which may be equal.
    pub given_objects: Vec<String>,
    /// Materials; [`Surface::material`] points here.
    pub materials: Vec<Material>,
    /// Decoded images of `map_Kd`; [`Material::texture`] points here.
    pub textures: Vec<Texture>,
    /// The lamps that a user can switch, in a stable order.
    pub luminaires: Vec<Luminaire>,
    /// The sky over the model and the sun in it, where there is daylight: lamps of their own before the placed ones.
    pub outdoors: Option<Outdoors>,
    /// Lamps that stand in no model file; the last of `luminaires`, in this order, are theirs.
    pub placed: Vec<PlacedLamp>,
    /// Bookmarks; never empty (the reader makes one up where the file has none).
    pub views: Vec<View>,
    /// Index into `views` of the view to start from.
    pub start_view: usize,
    /// Edge of a patch that the sidecar asks for, metres; chosen from the scene's area otherwise.
    pub patch_size: Option<f64>,
    /// Whether the model file has lights without a surface, which are placed lamps where no sidecar holds others.
    pub has_lights: bool,
    /// Files that it was read from besides the model file, material libraries and the sidecar.
    pub read_from: Vec<PathBuf>,
    /// What the reader noticed, repaired or dropped.
    pub findings: Vec<Finding>,
}

impl Scene {
    /// The box around all surfaces, metres.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(
            self.surfaces.iter().flat_map(|s| &s.corners).map(|c| self.positions[c.position as usize]),
        )
    }

    /// Where the part that is looked at is, and the length that tolerances are shares of.
    pub fn extent(&self) -> Extent {
        let footprint =
            |surface: &Surface| Footprint::of(&self.polygon(surface), surface.luminaire.is_some());
        Extent::of(&self.surfaces.iter().map(footprint).collect::<Vec<_>>())
    }

    /// A place in the coordinates and the unit of the file, here in metres.
    pub fn in_scene(&self, place: DVec3) -> DVec3 {
        place * self.unit.metres() - self.origin
    }

    /// A place here, in the coordinates and the unit of the file.
    pub fn in_file(&self, place: DVec3) -> DVec3 {
        (place + self.origin) / self.unit.metres()
    }

    /// Corner positions of a surface in order, metres.
    pub fn polygon(&self, surface: &Surface) -> Vec<DVec3> {
        surface.corners.iter().map(|c| self.positions[c.position as usize]).collect()
    }

    /// How many triangles the surfaces come to.
    pub fn triangle_count(&self) -> usize {
        self.surfaces.iter().map(|surface| surface.corners.len().saturating_sub(2)).sum()
    }

    /// Triangles of all surfaces, metres.
    pub fn triangles(&self) -> Vec<[DVec3; 3]> {
        super::views::triangles(&self.positions, &self.surfaces).0
    }

    /// Triangles of the surfaces that belong to the main part, metres.
    pub fn main_triangles(&self, extent: &Extent) -> Vec<[DVec3; 3]> {
        let (mut triangles, owners) = super::views::triangles(&self.positions, &self.surfaces);
        let mut owners = owners.iter();
        triangles.retain(|_| owners.next().is_none_or(|o| extent.stray.binary_search(o).is_err()));
        triangles
    }

    /// The state in which the lamps come with the file.
    pub fn lighting(&self) -> Lighting {
        Lighting { lamps: self.luminaires.iter().map(|l| l.initial).collect() }
    }

    /// Indices of the luminaires that a name means: by their own names, else by the names of their objects,
    /// else by those of their materials. An exact name comes first, then one without regard to capitals,
    /// underscores and blanks. Several luminaires may have surfaces of one object or material.
    pub fn luminaires_named(&self, name: &str) -> Vec<usize> {
        super::selection::named(self, name)
    }

    /// Whether a material has holes where its image is transparent.
    pub fn has_holes(&self, material: u32) -> bool {
        let texture = self.materials.get(material as usize).and_then(|material| material.texture);
        texture.and_then(|t| self.textures.get(t as usize)).is_some_and(Texture::has_holes)
    }

    /// Index of the view with this name: exact first, then ignoring capitals, underscores and blanks.
    pub fn view_named(&self, name: &str) -> Option<usize> {
        let exact = self.views.iter().position(|v| v.name == name);
        exact.or_else(|| self.views.iter().position(|v| folded(&v.name) == folded(name)))
    }
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum SceneSource {
    /// A model file.
    File(PathBuf),
    /// A model file, in another unit or with another axis up than its sidecar says.
    FileAs(PathBuf, FrameChoice),
    /// An embedded scene, by name.
    Builtin(String),
}

impl SceneSource {
    /// The model file, where it is one.
    pub fn path(&self) -> Option<&Path> {
        match self {
            Self::File(path) | Self::FileAs(path, _) => Some(path),
            Self::Builtin(_) => None,
        }
    }

    /// Whether both are one model, in whatever unit and whichever way up it is read.
    pub fn is_same_model(&self, other: &Self) -> bool {
        match (self.path(), other.path()) {
            (Some(one), Some(another)) => one == another,
            _ => self == other,
        }
    }

    /// The same file under `choice`; embedded scenes know their unit and axis.
    #[must_use]
    pub fn framed(self, choice: FrameChoice) -> Self {
        match self {
            Self::File(path) | Self::FileAs(path, _) if choice != FrameChoice::default() => {
                Self::FileAs(path, choice)
            }
            Self::FileAs(path, _) => Self::File(path),
            other => other,
        }
    }
}

/// A unit and an up axis that somebody has chosen over those of the file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct FrameChoice {
    /// `None`: as the sidecar says, metres without one.
    pub unit: Option<LengthUnit>,
    /// `None`: as the sidecar says, +y without one.
    pub up: Option<UpAxis>,
}

impl std::fmt::Display for SceneSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) | Self::FileAs(path, _) => write!(f, "{}", path.display()),
            Self::Builtin(name) => write!(f, "builtin:{name}"),
        }
    }
}

impl From<&str> for SceneSource {
    /// `builtin:NAME` or a path.
    fn from(text: &str) -> Self {
        match text.strip_prefix("builtin:") {
            Some(name) => Self::Builtin(name.to_owned()),
            None => Self::File(PathBuf::from(text)),
        }
    }
}

/// One input polygon: planar, at least three corners, any simple outline.
///
/// A wall that is written once per side is two of these, over the same corners in opposite order: each rules
/// its own side.
#[derive(Clone, Debug)]
pub struct Surface {
    /// The outline; counter-clockwise as seen from the front.
    pub corners: Vec<Corner>,
    /// Index into [`Scene::objects`].
    pub object: u32,
    /// Index into [`Scene::materials`].
    pub material: u32,
    /// Index into [`Scene::luminaires`] where this surface emits.
    pub luminaire: Option<u32>,
    /// Radiant exitance of the front side per band, relative to the luminaire's
    /// [`LampState::exitance`] (0 to 1, 1 where all its surfaces are alike); zero where it does not emit.
    pub emission_weight: [f64; 3],
    /// Whether the back side emits as the front does.
    pub emits_back: bool,
    /// Line of the file that it stands in, from one; `None` where it comes from none, or from one without lines.
    pub line: Option<u32>,
}

/// One corner of a [`Surface`]: indices into the scene's arrays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Corner {
    /// Index into [`Scene::positions`].
    pub position: u32,
    /// Index into [`Scene::normals`].
    pub normal: Option<u32>,
    /// Index into [`Scene::uvs`].
    pub uv: Option<u32>,
}

/// A diffuse material.
#[derive(Clone, Debug)]
pub struct Material {
    /// Name in the MTL file.
    pub name: String,
    /// Diffuse reflectance per band, 0 to [`MAX_REFLECTANCE`]; with a texture, its factor.
    pub reflectance: [f64; 3],
    /// Index into [`Scene::textures`].
    pub texture: Option<u32>,
    /// Which sides reflect.
    pub sides: Sides,
    /// Where it is clear or tinted glass: light passes its surfaces, and none of their sides reflects by its paint.
    pub glazing: Option<Glazing>,
    /// What passes diffusely from one side to the other, per band: with the reflectance at most [`MAX_REFLECTANCE`].
    pub translucence: [f64; 3],
}

impl Material {
    /// An opaque one that reflects all bands alike, 0 to [`MAX_REFLECTANCE`].
    pub(super) fn plain(name: &str, reflectance: f64) -> Self {
        Self {
            name: name.to_owned(),
            reflectance: [reflectance; 3],
            texture: None,
            sides: Sides::Auto,
            glazing: None,
            translucence: [0.0; 3],
        }
    }

    /// Whether light passes it diffusely.
    pub fn is_translucent(&self) -> bool {
        self.translucence != [0.0; 3]
    }
}

/// Which sides of a surface take part.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// Every side that light can reach.
    #[default]
    Auto,
    /// The front alone; the back is black.
    Front,
    /// Both, whether light is found to reach them or not.
    Both,
}

/// A decoded image in linear light, row by row from the top.
#[derive(Clone, Debug)]
pub struct Texture {
    /// File name, for messages.
    pub name: String,
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// Whether its border goes on beyond it; it is repeated otherwise.
    pub clamped: bool,
    /// Mean of all pixels per band, each by its opacity.
    pub mean: [f64; 3],
    /// Linear R, G, B in 0..1, `width * height` of them.
    pub pixels: Vec<[f32; 3]>,
    /// Opacity of each pixel, 0..1; empty where there are no holes.
    pub opacity: Vec<f32>,
}

impl Texture {
    /// Linear R, G, B at texture coordinates, repeated or clamped beyond 0..1, bilinear between pixel
    /// centres.
    pub fn sample(&self, uv: DVec2) -> [f32; 3] {
        if self.pixels.is_empty() {
            return [1.0; 3];
        }
        let [a, b, c, d] = self.around(uv);
        std::array::from_fn(|k| {
            let value = |(at, weight): (usize, f32)| weight * self.pixels[at][k];
            value(a) + value(b) + value(c) + value(d)
        })
    }

    /// Whether it has holes.
    pub fn has_holes(&self) -> bool {
        !self.opacity.is_empty()
    }

    /// Opacity at texture coordinates, 0 to 1, as [`Self::sample`] has the colour.
    pub fn opacity_at(&self, uv: DVec2) -> f32 {
        if self.opacity.is_empty() {
            return 1.0;
        }
        self.around(uv).into_iter().map(|(at, weight)| weight * self.opacity[at]).sum()
    }

    /// The four pixels around texture coordinates, and how much each counts.
    fn around(&self, uv: DVec2) -> [(usize, f32); 4] {
        let (w, h) = (i64::from(self.width), i64::from(self.height));
        let within = |x: f64| if self.clamped { x.clamp(0.0, 1.0) } else { x.rem_euclid(1.0) };
        let x = within(uv.x) * self.width as f64 - 0.5;
        let y = (1.0 - within(uv.y)) * self.height as f64 - 0.5;
        let (i, j) = (x.floor(), y.floor());
        let (s, t) = ((x - i) as f32, (y - j) as f32);
        let pixel = |k: i64, count: i64| match self.clamped {
            true => k.clamp(0, count - 1),
            false => k.rem_euclid(count),
        };
        let at = |di: i64, dj: i64| {
            let (col, row) = (pixel(i as i64 + di, w), pixel(j as i64 + dj, h));
            (row * w + col) as usize
        };
        [
            (at(0, 0), (1.0 - s) * (1.0 - t)),
            (at(1, 0), s * (1.0 - t)),
            (at(0, 1), (1.0 - s) * t),
            (at(1, 1), s * t),
        ]
    }
}

/// A lamp that a person recognises and switches as one.
#[derive(Clone, Debug)]
pub struct Luminaire {
    /// What the user reads: "Kitchen pendant".
    pub name: String,
    /// Total emitting area, m²: with its exitance the flux. Of photometric lamps without surfaces that of their
    /// openings, or a nominal one.
    pub area: f64,
    /// How it comes with the file.
    pub initial: LampState,
    /// Where its light is that of a photometric file: its surfaces glow in the picture, and light nothing by
    /// themselves.
    pub photometric: Option<PhotometricLight>,
}

/// The state of one lamp. Its exitance is `on * dimmer * exitance`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampState {
    /// Switched on.
    pub on: bool,
    /// 0 to 1, linear in light.
    pub dimmer: f64,
    /// Radiant exitance at full output, W/m² per band: colour and strength in one. Where the
    /// surfaces of one lamp differ, the largest in each band; all keep their ratio to it.
    pub exitance: [f64; 3],
}

impl LampState {
    /// Exitance as switched and dimmed, W/m² per band.
    pub fn output(&self) -> [f64; 3] {
        let factor = if self.on { self.dimmer } else { 0.0 };
        self.exitance.map(|e| e * factor)
    }
}

/// The state of all lamps, in the order of [`Scene::luminaires`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lighting {
    /// One entry a luminaire.
    pub lamps: Vec<LampState>,
}

/// A bookmark: a place to stand and a way to look.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// What the user reads.
    pub name: String,
    /// Eye, metres.
    pub eye: DVec3,
    /// A point looked at, metres; differs from the eye.
    pub target: DVec3,
    /// Vertical field of view, degrees, 5 to 150.
    pub fov_y_deg: f64,
}

/// A length unit of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum LengthUnit {
    /// 0.001 m
    Millimetre,
    /// 0.01 m
    Centimetre,
    /// 1 m
    #[default]
    Metre,
    /// 0.0254 m
    Inch,
    /// 0.3048 m
    Foot,
}

impl LengthUnit {
    /// All of them, by size.
    pub const ALL: [Self; 5] = [Self::Millimetre, Self::Centimetre, Self::Inch, Self::Foot, Self::Metre];

    /// Metres in one unit.
    pub fn metres(self) -> f64 {
        match self {
            Self::Millimetre => 0.001,
            Self::Centimetre => 0.01,
            Self::Metre => 1.0,
            Self::Inch => 0.0254,
            Self::Foot => 0.3048,
        }
    }

    /// Its name in the plural: "feet".
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetre => "millimetres",
            Self::Centimetre => "centimetres",
            Self::Metre => "metres",
            Self::Inch => "inches",
            Self::Foot => "feet",
        }
    }

    /// The abbreviation that the sidecar uses: mm, cm, m, in, ft.
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Millimetre => "mm",
            Self::Centimetre => "cm",
            Self::Metre => "m",
            Self::Inch => "in",
            Self::Foot => "ft",
        }
    }
}

/// Which axis points up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum UpAxis {
    /// +y, as most OBJ files have it.
    #[default]
    Y,
    /// +z, as CAD programs have it.
    Z,
}

impl UpAxis {
    /// The unit vector upwards.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}
