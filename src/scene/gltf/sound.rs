//! What the library takes for granted in a file and does not check: a file may leave it out, or say anything.

use ::gltf::json::Root;
use ::gltf::json::camera::Type;
use ::gltf::json::extensions::scene::khr_lights_punctual::{Spot, Type as LightType};
use ::gltf::json::image::MimeType;
use ::gltf::json::mesh::Semantic;
use ::gltf::json::validation::Checked;
use serde_json::json;
use std::f32::consts::FRAC_PI_4;

/// Completes a document as far as that changes nothing; what is wrong with it, as a sentence, where it cannot be used.
pub(super) fn complete(root: &mut Root) -> Result<(), String> {
    let accessors = root.accessors.len();
    for (number, mesh) in root.meshes.iter().enumerate() {
        for (semantic, accessor) in mesh.primitives.iter().flat_map(|primitive| &primitive.attributes) {
            let Some(own) = root.accessors.get_mut(accessor.value()) else {
                let asked = accessor.value();
                return Err(format!("its mesh {number} asks for accessor {asked}, and it has {accessors}"));
            };
            // Bounds are found anew, and some programs leave them out.
            if *semantic == Checked::Valid(Semantic::Positions) {
                (own.min, own.max) = (Some(json!([0, 0, 0])), Some(json!([0, 0, 0])));
            }
        }
    }
    for image in &mut root.images {
        // The content tells the format.
        image.mime_type.get_or_insert_with(|| MimeType("image/png".to_owned()));
        if image.buffer_view.is_none() {
            image.uri.get_or_insert_default();
        }
    }
    for (number, camera) in root.cameras.iter().enumerate() {
        let has_lens = match camera.type_ {
            Checked::Valid(Type::Perspective) => camera.perspective.is_some(),
            Checked::Valid(Type::Orthographic) => camera.orthographic.is_some(),
            Checked::Invalid => true,
        };
        if !has_lens {
            return Err(format!("its camera {number} has no lens of the type that it says"));
        }
    }
    let lights = root.extensions.iter_mut().filter_map(|extensions| extensions.khr_lights_punctual.as_mut());
    for light in lights.flat_map(|lights| &mut lights.lights) {
        if light.type_ == Checked::Valid(LightType::Spot) {
            light.spot.get_or_insert(Spot { inner_cone_angle: 0.0, outer_cone_angle: FRAC_PI_4 });
        }
    }
    Ok(())
}
