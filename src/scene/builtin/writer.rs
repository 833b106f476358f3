//! Collects polygons, materials, lamps and views, and writes them as OBJ, MTL and TOML.

use super::BuiltinSource;
use crate::scene::{LUMINOUS_EFFICACY, Sides, black_body, luminance_weighted};
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::fmt::Write;

/// A diffuse material by name.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    /// Name in the MTL file.
    pub(crate) name: &'static str,
    /// Diffuse reflectance per band, 0 to 1.
    pub(crate) reflectance: [f64; 3],
    /// Which sides reflect; anything but `Auto` is written to the sidecar.
    pub(crate) sides: Sides,
    /// Of glass what it lets pass along its normal, and in how many panes.
    pub(crate) glass: Option<(f64, u32)>,
}

impl Paint {
    /// A material of solid things and linings: nothing ever sees its back.
    pub(crate) const fn solid(name: &'static str, reflectance: [f64; 3]) -> Self {
        Self { name, reflectance, sides: Sides::Front, glass: None }
    }

    /// A material of thin sheets, lit on both sides.
    pub(crate) const fn sheet(name: &'static str, reflectance: [f64; 3]) -> Self {
        Self { name, reflectance, sides: Sides::Both, glass: None }
    }

    /// A glazing unit of so many panes that lets this share of light pass along its normal.
    pub(crate) const fn glass(name: &'static str, transmittance: f64, panes: u32) -> Self {
        Self { name, reflectance: [0.0; 3], sides: Sides::Auto, glass: Some((transmittance, panes)) }
    }
}

/// How a lamp's strength and colour are given.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Output {
    /// Luminous flux in lumens at a correlated colour temperature in kelvin.
    White(f64, f64),
    /// Luminous flux in lumens of a linear RGB colour.
    Coloured(f64, [f64; 3]),
    /// Radiance per band, W/m²/sr.
    Radiance([f64; 3]),
}

/// Stands for a lamp that was added to a [`Model`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct LampId(usize);

struct Lamp {
    name: &'static str,
    output: Output,
    on: bool,
    objects: Vec<usize>,
}

struct Material {
    name: String,
    reflectance: [f64; 3],
    sides: Sides,
    glass: Option<(f64, u32)>,
    /// The lamp and the exitance relative to the lamp's other materials.
    glow: Option<(LampId, f64)>,
    /// Area of its faces, square units.
    area: f64,
}

struct Face {
    material: usize,
    corners: Vec<(u32, Option<u32>)>,
}

struct Object {
    name: String,
    faces: Vec<Face>,
}

struct View {
    name: &'static str,
    eye: DVec3,
    target: DVec3,
    fov: f64,
}

/// A turn about the vertical and a shift.
#[derive(Clone, Copy)]
struct Placement {
    origin: DVec3,
    cos: f64,
    sin: f64,
}

impl Placement {
    fn direction(self, v: DVec3) -> DVec3 {
        DVec3::new(v.x * self.cos + v.z * self.sin, v.y, v.z * self.cos - v.x * self.sin)
    }

    fn then(self, origin: DVec3, turn_deg: f64) -> Self {
        // Exact for quarter turns: furniture then stays flush with its wall.
        let (sin, cos) = match turn_deg.rem_euclid(360.0) {
            0.0 => (0.0, 1.0),
            90.0 => (1.0, 0.0),
            180.0 => (0.0, -1.0),
            270.0 => (-1.0, 0.0),
            t => t.to_radians().sin_cos(),
        };
        Self {
            origin: self.origin + self.direction(origin),
            cos: self.cos * cos - self.sin * sin,
            sin: self.sin * cos + self.cos * sin,
        }
    }
}

/// A scene under construction, y up.
pub(crate) struct Model {
    positions: Vec<DVec3>,
    position_index: HashMap<[i64; 3], u32>,
    normals: Vec<DVec3>,
    normal_index: HashMap<[i64; 3], u32>,
    objects: Vec<Object>,
    materials: Vec<Material>,
    lamps: Vec<Lamp>,
    views: Vec<View>,
    object: usize,
    material: usize,
    placement: Placement,
    unit: (&'static str, f64),
    patch_size: f64,
    daylight: Option<&'static str>,
}

/// Coordinates are kept to this part of a unit, so that equal corners are equal in the text, and
/// facets of curved surfaces stay flat.
const QUANTUM: f64 = 1e-9;

impl Model {
    /// An empty scene: the symbol of its unit, metres in one unit, longest patch edge in metres.
    pub(crate) fn new(unit: (&'static str, f64), patch_size: f64) -> Self {
        Self {
            positions: Vec::new(),
            position_index: HashMap::new(),
            normals: Vec::new(),
            normal_index: HashMap::new(),
            objects: Vec::new(),
            materials: Vec::new(),
            lamps: Vec::new(),
            views: Vec::new(),
            object: 0,
            material: 0,
            placement: Placement { origin: DVec3::ZERO, cos: 1.0, sin: 0.0 },
            unit,
            patch_size,
            daylight: None,
        }
    }

    /// Puts a sky over it, by the keys of the sidecar's daylight; lamps come switched off.
    pub(crate) fn by_day(&mut self, daylight: &'static str) {
        self.daylight = Some(daylight);
    }

    /// Adds a bookmark; the first one is where to start. `fov` is vertical, degrees.
    pub(crate) fn view(&mut self, name: &'static str, eye: [f64; 3], target: [f64; 3], fov: f64) {
        self.views.push(View { name, eye: eye.into(), target: target.into(), fov });
    }

    /// Adds a lamp; [`Model::glow`] then gives it surfaces.
    pub(crate) fn lamp(&mut self, name: &'static str, output: Output, on: bool) -> LampId {
        self.lamps.push(Lamp { name, output, on, objects: Vec::new() });
        LampId(self.lamps.len() - 1)
    }

    /// Faces that follow belong to the object of this name.
    pub(crate) fn object(&mut self, name: &str) -> &mut Self {
        self.object = self.objects.iter().position(|o| o.name == name).unwrap_or_else(|| {
            self.objects.push(Object { name: name.to_owned(), faces: Vec::new() });
            self.objects.len() - 1
        });
        self
    }

    /// Faces that follow have this material.
    pub(crate) fn paint(&mut self, paint: &Paint) -> &mut Self {
        self.material = self.materials.iter().position(|m| m.name == paint.name).unwrap_or_else(|| {
            self.materials.push(Material {
                name: paint.name.to_owned(),
                reflectance: paint.reflectance,
                sides: paint.sides,
                glass: paint.glass,
                glow: None,
                area: 0.0,
            });
            self.materials.len() - 1
        });
        self
    }

    /// Faces that follow emit for this lamp, in an object of their own. `weight` is the exitance
    /// relative to the lamp's other surfaces.
    pub(crate) fn glow(&mut self, lamp: LampId, weight: f64, reflectance: [f64; 3]) -> &mut Self {
        let stem = self.lamps[lamp.0].name.to_lowercase().replace(' ', "_");
        self.object(&format!("{stem}_light"));
        if !self.lamps[lamp.0].objects.contains(&self.object) {
            self.lamps[lamp.0].objects.push(self.object);
        }
        let found = self.materials.iter().position(|m| m.glow == Some((lamp, weight)));
        self.material = found.unwrap_or_else(|| {
            let parts = self.materials.iter().filter(|m| m.glow.is_some_and(|g| g.0 == lamp)).count();
            let name = if parts == 0 { format!("glow_{stem}") } else { format!("glow_{stem}_{}", parts + 1) };
            let glow = Some((lamp, weight));
            let sides = Sides::Front;
            self.materials.push(Material { name, reflectance, sides, glass: None, glow, area: 0.0 });
            self.materials.len() - 1
        });
        self
    }

    /// Runs `build` in coordinates whose origin is `origin` and which are turned about the
    /// vertical by `turn_deg`, counter-clockwise as seen from above.
    pub(crate) fn place(&mut self, origin: [f64; 3], turn_deg: f64, build: impl FnOnce(&mut Self)) {
        let outer = self.placement;
        self.placement = outer.then(origin.into(), turn_deg);
        build(self);
        self.placement = outer;
    }

    /// A flat polygon, counter-clockwise as seen from the front.
    pub(crate) fn polygon(&mut self, corners: &[DVec3]) {
        self.face(corners.iter().map(|&p| (p, None)));
    }

    /// A polygon with a unit normal at each corner: a part of a curved surface.
    pub(crate) fn smooth_polygon(&mut self, corners: &[(DVec3, DVec3)]) {
        self.face(corners.iter().map(|&(p, n)| (p, Some(n))));
    }

    fn face(&mut self, corners: impl Iterator<Item = (DVec3, Option<DVec3>)>) {
        let placement = self.placement;
        let corners: Vec<_> = corners
            .map(|(p, n)| {
                let position = placement.origin + placement.direction(p);
                let position = shared(&mut self.positions, &mut self.position_index, position);
                let normal =
                    n.map(|n| shared(&mut self.normals, &mut self.normal_index, placement.direction(n)));
                (position, normal)
            })
            .collect();
        let at = |k: usize| self.positions[corners[k].0 as usize];
        let doubled: DVec3 = (1..corners.len() - 1).map(|k| (at(k) - at(0)).cross(at(k + 1) - at(0))).sum();
        self.materials[self.material].area += 0.5 * doubled.length();
        self.objects[self.object].faces.push(Face { material: self.material, corners });
    }

    /// Radiance (W/m²/sr per band) of a material that glows: the lamp's flux spread over its
    /// surfaces by their weights, each emitting evenly into the half space (Phi = pi L A).
    fn radiance(&self, lamp: LampId, weight: f64) -> [f64; 3] {
        let (lumens, colour) = match self.lamps[lamp.0].output {
            Output::Radiance(radiance) => return radiance.map(|l| l * weight),
            Output::White(lumens, kelvin) => (lumens, black_body(kelvin)),
            Output::Coloured(lumens, colour) => (lumens, colour),
        };
        let of_lamp = self.materials.iter().filter_map(|m| m.glow.map(|g| (g, m.area)));
        let weighted: f64 = of_lamp.filter(|(g, _)| g.0 == lamp).map(|(g, area)| g.1 * area).sum();
        let area = weighted * self.unit.1 * self.unit.1;
        let scale = lumens * weight / (LUMINOUS_EFFICACY * PI * area * luminance_weighted(colour));
        colour.map(|c| c * scale)
    }

    /// The finished texts; the OBJ names `NAME.mtl` as its library.
    pub(crate) fn finish(self, name: &str) -> BuiltinSource {
        BuiltinSource { obj: self.obj(name), mtl: self.mtl(), sidecar: self.sidecar() }
    }

    fn obj(&self, name: &str) -> String {
        let mut out = format!("# Lumenwalk embedded scene: {name}\nmtllib {name}.mtl\n");
        for &p in &self.positions {
            line(&mut out, format_args!("v {}", triple(p, " ")));
        }
        for &n in &self.normals {
            line(&mut out, format_args!("vn {}", triple(n, " ")));
        }
        for object in self.objects.iter().filter(|o| !o.faces.is_empty()) {
            line(&mut out, format_args!("o {}", object.name));
            let mut material = usize::MAX;
            for face in &object.faces {
                if face.material != material {
                    material = face.material;
                    line(&mut out, format_args!("usemtl {}", self.materials[material].name));
                }
                out.push('f');
                for &(position, normal) in &face.corners {
                    out.push_str(&match normal {
                        Some(normal) => format!(" {}//{}", position + 1, normal + 1),
                        None => format!(" {}", position + 1),
                    });
                }
                out.push('\n');
            }
        }
        out
    }

    fn mtl(&self) -> String {
        let mut out = String::new();
        for material in &self.materials {
            let [r, g, b] = material.reflectance;
            line(&mut out, format_args!("newmtl {}\nKd {r} {g} {b}", material.name));
            if let Some((lamp, weight)) = material.glow {
                let [r, g, b] = self.radiance(lamp, weight);
                line(&mut out, format_args!("Ke {r:.4} {g:.4} {b:.4}"));
            }
            out.push('\n');
        }
        out
    }

    fn sidecar(&self) -> String {
        let mut out = format!("unit = \"{}\"\nup = \"y\"\n", self.unit.0);
        if let Some(first) = self.views.first() {
            line(&mut out, format_args!("start = \"{}\"", first.name));
        }
        line(&mut out, format_args!("patch_size = {}", number(self.patch_size)));
        if let Some(daylight) = self.daylight {
            line(&mut out, format_args!("\n[daylight]\n{daylight}"));
        }
        for view in &self.views {
            line(&mut out, format_args!("\n[[view]]\nname = \"{}\"", view.name));
            line(&mut out, format_args!("eye = [{}]", triple(view.eye, ", ")));
            line(&mut out, format_args!("target = [{}]", triple(view.target, ", ")));
            line(&mut out, format_args!("fov = {}", number(view.fov)));
        }
        for lamp in &self.lamps {
            let objects: Vec<_> =
                lamp.objects.iter().map(|&o| format!("\"{}\"", self.objects[o].name)).collect();
            line(&mut out, format_args!("\n[[luminaire]]\nname = \"{}\"", lamp.name));
            line(&mut out, format_args!("objects = [{}]", objects.join(", ")));
            match lamp.output {
                Output::White(lumens, kelvin) => {
                    line(&mut out, format_args!("lumens = {}\ncct = {}", number(lumens), number(kelvin)));
                }
                Output::Coloured(lumens, [r, g, b]) => {
                    line(&mut out, format_args!("lumens = {}\ncolour = [{r}, {g}, {b}]", number(lumens)));
                }
                Output::Radiance(radiance) => {
                    let [r, g, b] = radiance.map(|l| PI * l);
                    line(&mut out, format_args!("exitance = [{r}, {g}, {b}]"));
                }
            }
            line(&mut out, format_args!("on = {}", lamp.on && self.daylight.is_none()));
        }
        for material in &self.materials {
            if let Some((transmittance, panes)) = material.glass {
                line(&mut out, format_args!("\n[[material]]\nname = \"{}\"", material.name));
                line(&mut out, format_args!("transmittance = {transmittance}\npanes = {panes}"));
            }
            let sides = match material.sides {
                Sides::Auto => continue,
                Sides::Front => "front",
                Sides::Both => "both",
            };
            line(&mut out, format_args!("\n[[material]]\nname = \"{}\"\nsides = \"{sides}\"", material.name));
        }
        out
    }
}

/// The index of a vector in a list, added where it is not there to within [`QUANTUM`].
fn shared(list: &mut Vec<DVec3>, index: &mut HashMap<[i64; 3], u32>, v: DVec3) -> u32 {
    let key = v.to_array().map(|c| (c / QUANTUM).round() as i64);
    *index.entry(key).or_insert_with(|| {
        list.push(DVec3::from_array(key.map(|k| k as f64 * QUANTUM)));
        (list.len() - 1) as u32
    })
}

fn line(out: &mut String, text: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = out.write_fmt(text);
    out.push('\n');
}

/// Nine decimals at most, without trailing zeros.
fn number(value: f64) -> String {
    let text = format!("{value:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

fn triple(v: DVec3, separator: &str) -> String {
    v.to_array().map(number).join(separator)
}
