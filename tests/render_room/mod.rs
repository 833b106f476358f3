//! A hand-made room for the tests of display and render: 4 x 3 x 5 metres with a box that stands
//! on the floor, a column with smooth normals, a textured wall and a lamp in the ceiling.

#![allow(dead_code, unreachable_pub, reason = "each test uses a part of it")]

use glam::{DVec2, DVec3};
use lumenwalk::mesh::{MeshSettings, PatchMesh, PatchTarget, build};
use lumenwalk::navigation::Camera;
use lumenwalk::scene::{
    Corner, LampState, LengthUnit, Luminaire, Material, Scene, SceneSource, Sides, Surface, Texture, UpAxis,
    View,
};
use std::f64::consts::TAU;

pub const WHITE: u32 = 0;
pub const RED: u32 = 1;
pub const PICTURE: u32 = 2;
pub const LAMP: u32 = 3;

pub struct Room {
    scene: Scene,
}

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

impl Room {
    pub fn empty() -> Self {
        let material = |name: &str, reflectance, texture| Material {
            translucence: [0.0; 3],
            name: name.to_owned(),
            reflectance,
            texture,
            sides: Sides::Auto,
            glazing: None,
        };
        let pixels = (0..64)
            .map(|i| match (i % 8 + i / 8) % 2 {
                0 => [0.9, 0.7, 0.2],
                _ => [0.1, 0.3, 0.6],
            })
            .collect();
        let checks = Texture {
            opacity: Vec::new(),
            name: "checks".to_owned(),
            width: 8,
            height: 8,
            clamped: false,
            mean: [0.5, 0.5, 0.4],
            pixels,
        };
        Self {
            scene: Scene {
                name: "room".to_owned(),
                source: SceneSource::Builtin("room".to_owned()),
                unit: LengthUnit::Metre,
                up: UpAxis::Y,
                origin: DVec3::ZERO,
                positions: Vec::new(),
                normals: Vec::new(),
                uvs: Vec::new(),
                surfaces: Vec::new(),
                objects: ["room", "box", "column", "lamp"].map(str::to_owned).to_vec(),
                given_objects: ["room", "box", "column", "lamp"].map(str::to_owned).to_vec(),
                materials: vec![
                    material("white", [0.7; 3], None),
                    material("red", [0.6, 0.1, 0.1], None),
                    material("picture", [0.8; 3], Some(0)),
                    material("lamp", [0.5; 3], None),
                ],
                textures: vec![checks],
                luminaires: Vec::new(),
                placed: Vec::new(),
                views: vec![View {
                    name: "start".to_owned(),
                    eye: v(0.4, 1.7, 4.7),
                    target: v(2.4, 1.0, 0.0),
                    fov_y_deg: 65.0,
                }],
                start_view: 0,
                patch_size: None,
                has_lights: false,
                read_from: Vec::new(),
                outdoors: None,
                findings: Vec::new(),
            },
        }
    }

    /// Adds a polygon, counter-clockwise as seen from its front.
    pub fn polygon(&mut self, object: u32, material: u32, corners: &[DVec3]) -> &mut Surface {
        let scene = &mut self.scene;
        let uvs = [DVec2::ZERO, DVec2::X * 2.0, DVec2::new(2.0, 1.5), DVec2::Y * 1.5];
        let corners = corners
            .iter()
            .enumerate()
            .map(|(k, &corner)| {
                scene.positions.push(corner);
                let uv = (material == PICTURE).then(|| {
                    scene.uvs.push(uvs[k % 4]);
                    scene.uvs.len() as u32 - 1
                });
                Corner { position: scene.positions.len() as u32 - 1, normal: None, uv }
            })
            .collect();
        scene.surfaces.push(Surface {
            corners,
            object,
            material,
            luminaire: None,
            emission_weight: [0.0; 3],
            emits_back: false,
            line: None,
        });
        scene.surfaces.last_mut().expect("just pushed")
    }

    /// The six sides of a box, facing inwards or outwards: -x, +x, -y, +y, -z, +z.
    pub fn cuboid(&mut self, object: u32, materials: [u32; 6], low: DVec3, high: DVec3, inwards: bool) {
        let p = |i: u32| {
            let pick = |bit: u32, a: f64, b: f64| if i & bit == 0 { a } else { b };
            v(pick(1, low.x, high.x), pick(2, low.y, high.y), pick(4, low.z, high.z))
        };
        // Corner numbers, counter-clockwise as seen from inside.
        let sides = [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]];
        for (side, material) in sides.into_iter().zip(materials) {
            let mut corners = side.map(p);
            if !inwards {
                corners.reverse();
            }
            self.polygon(object, material, &corners);
        }
    }

    /// An upright cylinder of `facets` rectangles, with smooth normals.
    pub fn column(&mut self, object: u32, centre: DVec3, radius: f64, height: f64, facets: u32) {
        for facet in 0..facets {
            let around = |i: u32| {
                let angle = TAU * f64::from(i % facets) / f64::from(facets);
                v(angle.cos(), 0.0, -angle.sin())
            };
            let (a, b) = (around(facet), around(facet + 1));
            let (low, high) = (centre, centre + v(0.0, height, 0.0));
            let corners = [low + a * radius, low + b * radius, high + b * radius, high + a * radius];
            let first = self.scene.normals.len() as u32;
            self.scene.normals.extend([a, b, b, a]);
            for (k, corner) in self.polygon(object, WHITE, &corners).corners.iter_mut().enumerate() {
                corner.normal = Some(first + k as u32);
            }
        }
    }

    /// The whole room.
    pub fn furnished() -> Self {
        let mut room = Self::empty();
        let materials = [RED, WHITE, WHITE, WHITE, PICTURE, WHITE];
        room.cuboid(0, materials, v(0.0, 0.0, 0.0), v(4.0, 3.0, 5.0), true);
        room.cuboid(1, [WHITE; 6], v(2.2, 0.0, 1.1), v(3.1, 0.9, 2.0), false);
        room.column(2, v(1.1, 0.0, 1.2), 0.25, 3.0, 16);
        let y = 2.98;
        let lamp = [v(1.5, y, 2.0), v(2.5, y, 2.0), v(2.5, y, 3.0), v(1.5, y, 3.0)];
        let surface = room.polygon(3, LAMP, &lamp);
        surface.luminaire = Some(0);
        surface.emission_weight = [1.0; 3];
        let initial = LampState { on: true, dimmer: 1.0, exitance: [60.0, 55.0, 45.0] };
        room.scene.luminaires.push(Luminaire {
            name: "Ceiling".to_owned(),
            area: 1.0,
            initial,
            photometric: None,
        });
        room
    }

    pub fn finish(self, patch_size: f64) -> (Scene, PatchMesh) {
        let settings = MeshSettings { target: PatchTarget::Size(patch_size), ..MeshSettings::default() };
        let mesh = build(&self.scene, &settings).expect("the room has surfaces");
        (self.scene, mesh)
    }
}

/// A made-up, smooth irradiance in W/m² per band, and the radiosity that goes with it.
pub fn light(mesh: &PatchMesh) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let irradiance: Vec<[f32; 3]> = mesh
        .patches
        .iter()
        .map(|patch| {
            let c = patch.centre;
            let fall = 1.0 / (1.0 + (c - v(2.0, 3.0, 2.5)).length_squared());
            let h = 6.0 * fall * (1.1 + 0.5 * patch.normal.y) + 0.4 + 0.2 * (1.3 * c.x).sin();
            [h, 0.9 * h, 0.7 * h + 0.05 * c.z].map(|x| x as f32)
        })
        .collect();
    let radiosity = mesh
        .patches
        .iter()
        .zip(&irradiance)
        .map(|(patch, h)| {
            std::array::from_fn(|b| {
                let emitted = if patch.luminaire.is_some() { 50.0 * patch.emission_weight[b] } else { 0.0 };
                (emitted + patch.reflectance[b] * f64::from(h[b])) as f32
            })
        })
        .collect();
    (irradiance, radiosity)
}

pub fn camera(scene: &Scene) -> Camera {
    Camera::from_view(&scene.views[scene.start_view], scene.up.vector())
}
