//! The nodes of a scene (glTF 2.0, section 3.5) with their meshes, lights and cameras, in the coordinates of the file.

use super::accessor::{indices, numbers};
use super::materials::Painted;
use super::{File, plain_name};
use crate::scene::corner_colours::{self, FaceColours, say_something};
use crate::scene::error::SceneError;
use crate::scene::finding::{Finding, FindingKind, Severity};
use crate::scene::model::{
    BareLight, Face, LARGEST_COORDINATE, LARGEST_UV, Model, ModelView, Pool, told_apart,
};
use crate::scene::mtl::DEFAULT_REFLECTANCE;
use crate::scene::names;
use crate::watch::Watch;
use ::gltf::accessor::Accessor;
use ::gltf::camera::Projection;
use ::gltf::khr_lights_punctual::Kind;
use ::gltf::mesh::{Mode, Primitive};
use ::gltf::scene::Transform;
use ::gltf::{Node, Semantic};
use glam::{DMat3, DMat4, DQuat, DVec2, DVec3};
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::FRAC_PI_2;

/// Triangles made between two looks at whether to go on.
const WATCHED_TRIANGLES: usize = 4096;
/// A light of less than this, candela, is off.
const DARK: f64 = 1e-9;

/// Reads the scene that the file begins with.
pub(super) fn read(
    file: &File<'_>,
    painted: Painted,
    model: &mut Model,
    watch: &mut Watch<'_>,
) -> Result<(), SceneError> {
    let triangles = total(file).max(1);
    let mut reader = Reader {
        file,
        painted,
        model,
        positions: Pool::default(),
        normals: Pool::default(),
        uvs: Pool::default(),
        coloured: BTreeMap::new(),
        unread: BTreeMap::new(),
        plain: 0,
        made: 0,
        triangles,
    };
    let scene = file.document.default_scene().or_else(|| file.document.scenes().next());
    let mut seen = vec![false; file.document.nodes().count()];
    let mut open: Vec<(Node<'_>, DMat4)> = Vec::new();
    match scene {
        Some(scene) => open.extend(scene.nodes().map(|node| (node, DMat4::IDENTITY))),
        // Without a scene all nodes that hang on none are one.
        None => open.extend(roots(file).into_iter().map(|node| (node, DMat4::IDENTITY))),
    }
    open.reverse();
    while let Some((node, above)) = open.pop() {
        // Each node hangs on one at most, so that there are no circles.
        if std::mem::replace(&mut seen[node.index()], true) {
            let message =
                format!("the node '{}' hangs on several, or on itself", names::short(&name_of(&node)));
            return Err(SceneError::file(file.given.file, message));
        }
        let placed = above * matrix(&node);
        reader.add(&node, placed, watch)?;
        let below: Vec<_> = node.children().map(|child| (child, placed)).collect();
        open.extend(below.into_iter().rev());
    }
    reader.finish()
}

/// Nodes that hang on no other.
fn roots<'a>(file: &File<'a>) -> Vec<Node<'a>> {
    let mut hangs = vec![false; file.document.nodes().count()];
    file.document.nodes().flat_map(|node| node.children()).for_each(|child| hangs[child.index()] = true);
    file.document.nodes().filter(|node| !hangs[node.index()]).collect()
}

/// Triangles of all meshes, once each, about.
fn total(file: &File<'_>) -> usize {
    let primitives = file.document.meshes().flat_map(|mesh| mesh.primitives());
    let count = |accessor: Option<Accessor<'_>>| accessor.map_or(0, |accessor| accessor.count() / 3);
    primitives.map(|p| count(p.indices().or_else(|| p.get(&Semantic::Positions)))).sum()
}

fn name_of(node: &Node<'_>) -> String {
    let mesh = node.mesh();
    let named = node.name().or_else(|| mesh.as_ref().and_then(|mesh| mesh.name()));
    match named.map(plain_name).filter(|name| !name.is_empty()) {
        Some(name) => name,
        None => format!("node {}", node.index() + 1),
    }
}

fn matrix(node: &Node<'_>) -> DMat4 {
    match node.transform() {
        Transform::Matrix { matrix } => {
            DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)))
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let turn = DQuat::from_array(rotation.map(f64::from));
            // Files round it; one of no length turns nothing.
            let turn = if turn.length() > 0.5 { turn.normalize() } else { DQuat::IDENTITY };
            DMat4::from_scale_rotation_translation(
                DVec3::from(scale.map(f64::from)),
                turn,
                DVec3::from(translation.map(f64::from)),
            )
        }
    }
}

struct Reader<'a, 'm> {
    file: &'a File<'a>,
    painted: Painted,
    model: &'m mut Model,
    positions: Pool<3>,
    normals: Pool<3>,
    uvs: Pool<2>,
    /// Colours of corners by material.
    coloured: BTreeMap<usize, Vec<FaceColours>>,
    /// What is in the file and not read, counted.
    unread: BTreeMap<&'static str, usize>,
    /// Faces that have neither a material nor a colour.
    plain: usize,
    /// Triangles so far, and about how many there will be.
    made: usize,
    triangles: usize,
}

/// The corners of a primitive, in the coordinates of the scene.
struct Corners {
    positions: Vec<u32>,
    normals: Option<Vec<u32>>,
    uvs: Option<Vec<u32>>,
    colours: Option<Vec<[f32; 3]>>,
}

impl Reader<'_, '_> {
    fn add(&mut self, node: &Node<'_>, placed: DMat4, watch: &mut Watch<'_>) -> Result<(), SceneError> {
        if !placed.is_finite() {
            let message = format!(
                "the node '{}' is placed by something that is no number",
                names::short(&name_of(node))
            );
            return Err(SceneError::file(self.file.given.file, message));
        }
        self.add_light(node, placed);
        self.add_camera(node, placed);
        let Some(mesh) = node.mesh() else { return Ok(()) };
        if node.skin().is_some() {
            self.miss("meshes that bones move stand as they were modelled");
        }
        let object = self.model.polygons.given_objects.len() as u32;
        let before = self.model.polygons.faces.len();
        for primitive in mesh.primitives() {
            if primitive.morph_targets().next().is_some() {
                self.miss("shapes that a mesh can change into are not read");
            }
            match triangles(primitive.mode()) {
                Some(of) => {
                    self.add_primitive(&primitive, of, (object, placed), watch).map_err(
                        |fault| match fault {
                            Fault::Ended(ended) => ended,
                            Fault::Broken(what) => {
                                let name = names::short(&name_of(node));
                                SceneError::file(self.file.given.file, format!("the mesh of '{name}' {what}"))
                            }
                        },
                    )?
                }
                None => self.miss("points and lines have no area and are not read"),
            }
        }
        self.shine_both_ways(object, before);
        if self.model.polygons.faces.len() > before {
            self.model.polygons.given_objects.push(name_of(node));
        }
        Ok(())
    }

    /// Notes which materials of the faces of an object, from this one on, glow to both sides: those that are double-sided,
    /// where they are sheets and no bodies, whose inside nobody sees.
    fn shine_both_ways(&mut self, object: u32, first: usize) {
        let mut edges: BTreeMap<u32, HashMap<[u32; 2], usize>> = BTreeMap::new();
        for face in &self.model.polygons.faces[first..] {
            if !self.painted.double_sided[face.material as usize] {
                continue;
            }
            let ring: Vec<u32> = face.corners.iter().map(|corner| corner.0).collect();
            let own = edges.entry(face.material).or_default();
            for k in 0..ring.len() {
                let [a, b] = [ring[k], ring[(k + 1) % ring.len()]];
                *own.entry([a.min(b), a.max(b)]).or_default() += 1;
            }
        }
        let is_sheet = |edges: &HashMap<[u32; 2], usize>| edges.values().any(|faces| *faces == 1);
        let sheets =
            edges.iter().filter(|(_, edges)| is_sheet(edges)).map(|(material, _)| (object, *material));
        self.model.both_ways.extend(sheets);
    }

    fn miss(&mut self, what: &'static str) {
        *self.unread.entry(what).or_default() += 1;
    }

    fn add_primitive(
        &mut self,
        primitive: &Primitive<'_>,
        of: Triangle,
        (object, placed): (u32, DMat4),
        watch: &mut Watch<'_>,
    ) -> Result<(), Fault> {
        let buffers = self.file.buffers;
        let is_default = primitive.material().index().is_none();
        let material = primitive.material().index().unwrap_or(self.painted.placements.len() - 1);
        let corners = self.corners(primitive, material, placed)?;
        let count = corners.positions.len();
        let order = primitive.indices().map(|accessor| indices(&accessor, buffers)).transpose()?;
        let length = order.as_ref().map_or(count, Vec::len);
        let corner = |k: usize| order.as_ref().map_or(k as u32, |order| order[k]);
        if let Some(wrong) = order.iter().flatten().find(|&&index| index as usize >= count) {
            return Err(Fault::Broken(format!("asks for corner {wrong}, and it has {count}")));
        }
        let triangles = match primitive.mode() {
            Mode::Triangles => length / 3,
            _ => length.saturating_sub(2),
        };
        let is_mirrored = placed.determinant() < 0.0;
        for k in 0..triangles {
            if k % WATCHED_TRIANGLES == 0 {
                let share = self.made as f64 / self.triangles as f64;
                // Meshes that stand at several places are more than were counted.
                watch.done(share / (1.0 + (share - 1.0).max(0.0)))?;
            }
            self.made += 1;
            let mut ring = of(k, &corner);
            if is_mirrored {
                ring.swap(1, 2);
            }
            if let Some(colours) = &corners.colours {
                let own = ring.iter().map(|&c| colours[c as usize]).collect();
                let list = self.coloured.entry(material).or_default();
                list.push((self.model.polygons.faces.len(), own));
            } else if is_default {
                self.plain += 1;
            }
            let pick = |list: &Option<Vec<u32>>, c: u32| list.as_ref().map(|list| list[c as usize]);
            let corners = ring
                .map(|c| (corners.positions[c as usize], pick(&corners.normals, c), pick(&corners.uvs, c)));
            self.model.polygons.faces.push(Face {
                corners: corners.to_vec(),
                object,
                material: material as u32,
                line: None,
            });
        }
        Ok(())
    }

    fn corners(
        &mut self,
        primitive: &Primitive<'_>,
        material: usize,
        placed: DMat4,
    ) -> Result<Corners, Fault> {
        let buffers = self.file.buffers;
        let accessor = primitive.get(&Semantic::Positions).ok_or("has no positions")?;
        let given = numbers::<3>(&accessor, buffers)?;
        let count = given.len();
        let mut positions = Vec::with_capacity(count);
        for place in given {
            let place = placed.transform_point3(DVec3::from(place));
            if !(place.is_finite() && place.abs().max_element() <= LARGEST_COORDINATE) {
                return Err(Fault::Broken("has a corner at no usable place".to_owned()));
            }
            positions.push(self.positions.index(place.to_array()));
        }
        let of_all = |list: &Vec<u32>| list.len() == count;
        // Normals follow the surface, whatever is stretched.
        let upright = cofactors(DMat3::from_mat4(placed));
        let normals = match primitive.get(&Semantic::Normals) {
            Some(accessor) => {
                let turned = numbers::<3>(&accessor, buffers)?.into_iter().map(|n| {
                    let turned = (upright * DVec3::from(n)).normalize_or_zero();
                    self.normals.index(turned.to_array())
                });
                Some(turned.collect()).filter(of_all)
            }
            None => None,
        };
        let uvs = match self.painted.placements[material] {
            Some(placement) => match primitive.get(&Semantic::TexCoords(placement.set)) {
                Some(accessor) => {
                    let laid = numbers::<2>(&accessor, buffers)?.into_iter().map(|uv| {
                        let uv = placement.apply(DVec2::from(uv));
                        let usable = uv.is_finite() && uv.abs().max_element() <= LARGEST_UV;
                        self.uvs.index(if usable { uv.to_array() } else { [0.0; 2] })
                    });
                    Some(laid.collect()).filter(of_all)
                }
                None => {
                    self.miss("meshes with an image and without its coordinates get its mean");
                    None
                }
            },
            None => None,
        };
        let colours = match (primitive.get(&Semantic::Colors(0)), self.painted.placements[material]) {
            (None, _) => None,
            (Some(accessor), None) => {
                let factor = match primitive.material().index() {
                    Some(_) => self.model.materials.list[material].reflectance,
                    // White is the base colour of a material that is left out.
                    None => [1.0; 3],
                };
                let read = numbers::<3>(&accessor, buffers)?;
                let by_factor = |c: [f64; 3]| std::array::from_fn(|band| (c[band] * factor[band]) as f32);
                let says = read.iter().flatten().any(|&value| value < 1.0 - 1e-3);
                (says && read.len() == count).then(|| read.into_iter().map(by_factor).collect())
            }
            (Some(_), Some(_)) => {
                self.miss("colours of corners are not read where there is an image");
                None
            }
        };
        Ok(Corners { positions, normals, uvs, colours })
    }

    fn add_light(&mut self, node: &Node<'_>, placed: DMat4) {
        let Some(light) = node.light() else { return };
        let cone = match light.kind() {
            Kind::Directional => {
                self.miss("lights from one direction are not read: the sun is set by place and hour");
                return;
            }
            Kind::Point => None,
            Kind::Spot { inner_cone_angle, outer_cone_angle } => {
                let outer = f64::from(outer_cone_angle).clamp(0.01, FRAC_PI_2);
                Some([f64::from(inner_cone_angle).clamp(0.0, outer - 0.005), outer])
            }
        };
        let colour = light.color().map(f64::from);
        let candelas = f64::from(light.intensity());
        let is_lit = candelas.is_finite() && candelas > DARK;
        let has_colour = colour.iter().all(|c| c.is_finite() && *c >= 0.0) && colour.iter().any(|c| *c > 0.0);
        if !is_lit || !has_colour {
            self.miss("lights without light are left out");
            return;
        }
        let name = node.name().or(light.name()).map(plain_name).filter(|name| !name.is_empty());
        self.model.lights.push(BareLight {
            name: name.unwrap_or_else(|| format!("light {}", self.model.lights.len() + 1)),
            position: placed.transform_point3(DVec3::ZERO),
            aim: forward(placed),
            colour,
            candelas,
            cone,
        });
    }

    fn add_camera(&mut self, node: &Node<'_>, placed: DMat4) {
        let Some(camera) = node.camera() else { return };
        match camera.projection() {
            Projection::Perspective(lens) => {
                let name = node.name().or(camera.name()).map(plain_name).filter(|name| !name.is_empty());
                let number = self.model.views.len() + 1;
                self.model.views.push(ModelView {
                    name: name.unwrap_or_else(|| format!("camera {number}")),
                    eye: placed.transform_point3(DVec3::ZERO),
                    forward: forward(placed),
                    fov_y_deg: f64::from(lens.yfov()).to_degrees(),
                });
            }
            Projection::Orthographic(_) => self.miss("cameras without perspective are not read"),
        }
    }

    fn finish(self) -> Result<(), SceneError> {
        let Self { file, model, positions, normals, uvs, coloured, unread, mut plain, .. } = self;
        let polygons = &mut model.polygons;
        if polygons.faces.is_empty() {
            let message = "the file holds no triangles, so there is nothing to light";
            return Err(SceneError::file(file.given.file, message));
        }
        polygons.positions = positions.values.into_iter().map(DVec3::from).collect();
        polygons.normals = normals.values.into_iter().map(DVec3::from).collect();
        polygons.uvs = uvs.values.into_iter().map(DVec2::from).collect();
        polygons.objects = told_apart(&polygons.given_objects);
        let of_none = model.materials.list.len() - 1;
        for (material, colours) in coloured {
            if !say_something(&colours) {
                plain += if material == of_none { colours.len() } else { 0 };
                continue;
            }
            let mut template = model.materials.list[material].clone();
            template.name = match material == of_none {
                true => corner_colours::NAME.to_owned(),
                false => format!("{} (colours of corners)", template.name),
            };
            let exitance = model.materials.exitance[material];
            let made = (&mut model.materials, &mut model.textures);
            corner_colours::lay(colours, template, exitance, &mut model.polygons, made);
        }
        let is_used = model.polygons.faces.iter().any(|face| face.material as usize == of_none);
        if !is_used && of_none + 1 == model.materials.list.len() {
            model.materials.list.pop();
            model.materials.exitance.pop();
        }
        let mut tell = |kind, severity, message: String, count: usize| {
            model.findings.push(Finding::new(kind, severity, message).counted(count));
        };
        if plain > 0 {
            let count = names::grouped(plain as i64);
            let message =
                format!("faces without a material were taken as grey {DEFAULT_REFLECTANCE} ({count})");
            tell(FindingKind::Material, Severity::Warning, message, plain);
        }
        for (what, count) in unread {
            tell(FindingKind::File, Severity::Note, format!("{what} ({count})"), count);
        }
        Ok(())
    }
}

/// Why a primitive cannot be read.
enum Fault {
    Ended(SceneError),
    /// The rest of a sentence on the mesh.
    Broken(String),
}

impl From<String> for Fault {
    fn from(what: String) -> Self {
        Self::Broken(what)
    }
}

impl From<&str> for Fault {
    fn from(what: &str) -> Self {
        Self::Broken(what.to_owned())
    }
}

impl From<crate::watch::Cancelled> for Fault {
    fn from(ended: crate::watch::Cancelled) -> Self {
        Self::Ended(ended.into())
    }
}

/// The corners of a triangle by its number, where a function tells those of the primitive in order.
type Triangle = fn(usize, &dyn Fn(usize) -> u32) -> [u32; 3];

/// The corners of triangle `k` by the mode of a primitive; `None` of modes without area.
fn triangles(mode: Mode) -> Option<Triangle> {
    Some(match mode {
        Mode::Triangles => |k, corner| [corner(3 * k), corner(3 * k + 1), corner(3 * k + 2)],
        Mode::TriangleStrip => |k, corner| [corner(k), corner(k + 1 + k % 2), corner(k + 2 - k % 2)],
        Mode::TriangleFan => |k, corner| [corner(k + 1), corner(k + 2), corner(0)],
        Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip => return None,
    })
}

/// Where a light or a camera looks: along its -z.
fn forward(placed: DMat4) -> DVec3 {
    let along = placed.transform_vector3(DVec3::NEG_Z).normalize_or_zero();
    if along == DVec3::ZERO { DVec3::NEG_Z } else { along }
}

/// The matrix by which normals are turned, whatever the length.
fn cofactors(m: DMat3) -> DMat3 {
    let turned =
        DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    if m.determinant() < 0.0 { -1.0 * turned } else { turned }
}
