//! The room as glTF, written here.

use super::{CORNERS, LUMINANCE, PARTS};
use serde_json::{Value, json};

/// Texture coordinates of the floor, v downwards.
pub(super) const FLOOR_UVS: [[f64; 2]; 4] = [[0.0, 1.0], [0.0, 0.0], [1.0, 0.0], [1.0, 1.0]];

/// A glTF file on its way: its JSON and its one buffer.
pub(super) struct Gltf {
    pub(super) json: Value,
    pub(super) bytes: Vec<u8>,
}

impl Gltf {
    pub(super) fn new() -> Self {
        let json = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [] }], "nodes": [], "meshes": [],
            "materials": [], "accessors": [], "bufferViews": [], "buffers": [],
        });
        Self { json, bytes: Vec::new() }
    }

    pub(super) fn list(&mut self, name: &str) -> &mut Vec<Value> {
        if self.json[name].is_null() {
            self.json[name] = json!([]);
        }
        self.json[name].as_array_mut().unwrap()
    }

    pub(super) fn push(&mut self, name: &str, value: Value) -> usize {
        self.list(name).push(value);
        self.list(name).len() - 1
    }

    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let view = json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() });
        self.bytes.extend(bytes);
        self.push("bufferViews", view)
    }

    /// Numbers as f32.
    pub(super) fn floats<const N: usize>(&mut self, values: &[[f64; N]]) -> usize {
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|v| (*v as f32).to_le_bytes()).collect();
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let bounds = |pick: fn(f64, f64) -> f64| -> Vec<f64> {
            (0..N).map(|k| values.iter().map(|v| f64::from(v[k] as f32)).reduce(pick).unwrap()).collect()
        };
        let (low, high) = (bounds(f64::min), bounds(f64::max));
        let view = self.view(&bytes);
        let accessor = json!({
            "bufferView": view, "componentType": 5126, "count": values.len(), "type": kind, "min": low, "max": high
        });
        self.push("accessors", accessor)
    }

    pub(super) fn indices(&mut self, values: &[u16]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let accessor =
            json!({ "bufferView": view, "componentType": 5123, "count": values.len(), "type": "SCALAR" });
        self.push("accessors", accessor)
    }

    pub(super) fn node(&mut self, node: Value) -> usize {
        let number = self.push("nodes", node);
        self.json["scenes"][0]["nodes"].as_array_mut().unwrap().push(json!(number));
        number
    }

    /// The mesh of a part, its corners as `at` has them.
    pub(super) fn part(
        &mut self,
        quads: &[[usize; 4]],
        material: usize,
        at: &dyn Fn([f64; 3]) -> [f64; 3],
    ) -> usize {
        let places: Vec<[f64; 3]> = quads.iter().flatten().map(|&corner| at(CORNERS[corner])).collect();
        let order: Vec<u16> =
            (0..quads.len() as u16).flat_map(|q| [0, 1, 2, 0, 2, 3].map(|k| 4 * q + k)).collect();
        let (positions, indices) = (self.floats(&places), self.indices(&order));
        let uvs: Vec<[f64; 2]> = quads.iter().flat_map(|_| FLOOR_UVS).collect();
        let uvs = self.floats(&uvs);
        let attributes = json!({ "POSITION": positions, "TEXCOORD_0": uvs });
        let primitive = json!({ "attributes": attributes, "indices": indices, "material": material });
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// The room.
    pub(super) fn room() -> Self {
        let mut gltf = Self::new();
        for (name, reflectance, quads) in PARTS {
            let material = gltf.push("materials", material(name, reflectance));
            let mesh = gltf.part(quads, material, &|place| place);
            gltf.node(json!({ "name": name, "mesh": mesh }));
        }
        gltf
    }

    pub(super) fn text(mut self, address: &str) -> String {
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len(), "uri": address }]);
        self.json.to_string()
    }

    pub(super) fn with_data(self) -> String {
        let address = format!("data:application/octet-stream;base64,{}", base64(&self.bytes));
        self.text(&address)
    }

    pub(super) fn glb(mut self) -> Vec<u8> {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.json["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut glb = b"glTF\x02\0\0\0".to_vec();
        glb.extend((28 + text.len() as u32 + self.bytes.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            glb.extend((chunk.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(chunk);
        }
        glb
    }
}

pub(super) fn material(name: &str, reflectance: f64) -> Value {
    let r = reflectance;
    let plain = json!({ "baseColorFactor": [r, r, r, 1.0], "metallicFactor": 0.0 });
    let mut material = json!({ "name": name, "pbrMetallicRoughness": plain });
    if reflectance == 0.0 {
        material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
        material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = json!(LUMINANCE);
    }
    material
}

pub(super) fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::new();
    for group in bytes.chunks(3) {
        let three = [group[0], *group.get(1).unwrap_or(&0), *group.get(2).unwrap_or(&0)];
        let bits = u32::from_be_bytes([0, three[0], three[1], three[2]]);
        for k in 0..4 {
            let letter = LETTERS[(bits >> (18 - 6 * k) & 63) as usize] as char;
            text.push(if k <= group.len() { letter } else { '=' });
        }
    }
    text
}

/// The room with an image on its floor, laid by a transform.
pub(super) fn textured(image: impl Fn(&mut Gltf) -> Value, transform: Value) -> Gltf {
    let mut gltf = Gltf::room();
    let image = image(&mut gltf);
    gltf.push("images", image);
    gltf.push("textures", json!({ "source": 0 }));
    let mut laid = json!({ "index": 0 });
    if !transform.is_null() {
        laid["extensions"]["KHR_texture_transform"] = transform;
    }
    gltf.json["materials"][0]["pbrMetallicRoughness"] = json!({ "baseColorTexture": laid });
    gltf
}

/// The room with a light in its middle and none on its panel, and a camera.
pub(super) fn with_light(light: Value) -> Gltf {
    let mut gltf = Gltf::room();
    gltf.json["materials"][3] = material("dark", 0.1);
    gltf.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    gltf.json["extensions"]["KHR_lights_punctual"]["lights"] = json!([light]);
    // Down, along the light's own -z.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    gltf.node(json!({
        "name": "lamp_over_table", "translation": [2.0, 2.0, 1.5], "rotation": [-half, 0.0, 0.0, half],
        "extensions": { "KHR_lights_punctual": { "light": 0 } },
    }));
    gltf.push("cameras", json!({ "type": "perspective", "perspective": { "yfov": 1.0, "znear": 0.1 } }));
    gltf.node(json!({ "name": "From the door", "translation": [0.5, 1.6, 2.5], "camera": 0 }));
    gltf
}
