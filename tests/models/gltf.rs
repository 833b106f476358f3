//! glTF and GLB.

use super::gltf_file::{FLOOR_UVS, Gltf, base64, material, textured, with_light};
use super::{CORNERS, HALF, LUMINANCE, OTHER_HALF, PARTS, PLAIN, empty, half_png, hold, lux, read};
use image::ImageFormat;
use lumenwalk::scene::{self, Scene, SceneSource, UpAxis};
use serde_json::{Value, json};
use std::f64::consts::{FRAC_PI_2, PI};
use std::io::Cursor;

#[test]
fn one_room_has_one_light_in_every_kind_of_gltf() {
    let place = empty();
    place.put("data.gltf", &Gltf::room().with_data());
    hold(&place, "data.gltf", PLAIN, "");
    let gltf = Gltf::room();
    std::fs::write(place.path("the room.bin"), &gltf.bytes).unwrap();
    place.put("beside.gltf", &gltf.text("the%20room.bin"));
    hold(&place, "beside.gltf", PLAIN, "");
    // By its content, whatever its ending.
    std::fs::write(place.path("whole.model"), Gltf::room().glb()).unwrap();
    hold(&place, "whole.model", PLAIN, "");
    let scene = read(&place, "whole.model");
    let names: Vec<&str> = scene.objects.iter().map(String::as_str).collect();
    assert_eq!(names, ["floor", "ceiling", "walls", "panel"]);
    assert_eq!((scene.up, scene.luminaires.len(), scene.materials.len()), (UpAxis::Y, 1, 4));
}

#[test]
fn nodes_place_turn_and_mirror_what_hangs_on_them() {
    let place = empty();
    let mut gltf = Gltf::new();
    // Upright and in metres only through its nodes: z was up, y points away, in centimetres, mirrored in x.
    let upside = |[x, y, z]: [f64; 3]| [-100.0 * x, -100.0 * z, 100.0 * y];
    let mut below = Vec::new();
    for (name, reflectance, quads) in PARTS {
        let material = gltf.push("materials", material(name, reflectance));
        // A mirrored part is written the other way round.
        let turned: Vec<[usize; 4]> = quads.iter().map(|[a, b, c, d]| [*a, *d, *c, *b]).collect();
        let mesh = gltf.part(&turned, material, &upside);
        below.push(gltf.push("nodes", json!({ "name": name, "mesh": mesh })));
    }
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let turn = gltf.push("nodes", json!({ "rotation": [-half, 0.0, 0.0, half], "children": below }));
    gltf.node(json!({ "scale": [-0.01, 0.01, 0.01], "children": [turn] }));
    std::fs::write(place.path("placed.glb"), gltf.glb()).unwrap();
    hold(&place, "placed.glb", PLAIN, "");
    // A matrix, column by column: 7 m to the right.
    let mut gltf = Gltf::room();
    for node in gltf.list("nodes") {
        node["matrix"] = json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 0, 0, 1]);
    }
    std::fs::write(place.path("moved.glb"), gltf.glb()).unwrap();
    let bounds = read(&place, "moved.glb").bounds();
    assert!(bounds.min.abs_diff_eq(glam::DVec3::new(7.0, 0.0, 0.0), 1e-6), "{bounds:?}");
}

#[test]
fn strips_fans_and_rounded_positions_are_the_same_triangles() {
    let place = empty();
    let mut gltf = Gltf::room();
    // The floor as a strip, the ceiling as a fan without indices.
    let strip = gltf.indices(&[1, 2, 0, 3]);
    gltf.json["meshes"][0]["primitives"][0]["indices"] = json!(strip);
    gltf.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
    gltf.json["meshes"][1]["primitives"][0]["mode"] = json!(6);
    gltf.json["meshes"][1]["primitives"][0].as_object_mut().unwrap().remove("indices");
    // The lamp in steps of a centimetre, with a hole of two bytes behind each corner.
    let bytes: Vec<u8> = [8, 9, 10, 11]
        .iter()
        .flat_map(|&corner| {
            let [x, y, z] = CORNERS[corner].map(|metres| (100.0 * metres).round() as u16);
            [x, y, z, 0xffff]
        })
        .flat_map(u16::to_le_bytes)
        .collect();
    let view = gltf.view(&bytes);
    gltf.json["bufferViews"][view]["byteStride"] = json!(8);
    let accessor = gltf.push(
        "accessors",
        json!({ "bufferView": view, "componentType": 5123, "count": 4, "type": "VEC3",
                "min": [170, 245, 120], "max": [230, 245, 180] }),
    );
    gltf.json["meshes"][3]["primitives"][0]["attributes"]["POSITION"] = json!(accessor);
    gltf.json["nodes"][3]["scale"] = json!([0.01, 0.01, 0.01]);
    gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    gltf.json["extensionsUsed"] = json!(["KHR_mesh_quantization"]);
    // Bounds that are left out are no reason to refuse.
    gltf.json["accessors"][0].as_object_mut().unwrap().remove("min");
    std::fs::write(place.path("packed.glb"), gltf.glb()).unwrap();
    hold(&place, "packed.glb", PLAIN, "");
    assert_eq!(read(&place, "packed.glb").surfaces.len(), 14);
}

#[test]
fn images_lie_as_their_transforms_say() {
    let place = empty();
    std::fs::write(place.path("half.png"), half_png()).unwrap();
    let beside = |_: &mut Gltf| json!({ "uri": "half.png" });
    let within = |gltf: &mut Gltf| {
        let view = gltf.view(&half_png());
        json!({ "bufferView": view, "mimeType": "image/png" })
    };
    let as_data = |_: &mut Gltf| json!({ "uri": format!("data:image/png;base64,{}", base64(&half_png())) });
    // What is turned by a quarter lies along the other axis of the floor: it is turned back here, by the definition
    // u' = u cos + v sin, v' = v cos - u sin.
    let mut turned = textured(beside, json!({ "rotation": FRAC_PI_2 }));
    let uvs: Vec<[f64; 2]> = FLOOR_UVS.iter().map(|[u, v]| [-v, *u]).collect();
    let uvs = turned.floats(&uvs);
    turned.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(uvs);
    for (name, gltf, expected) in [
        ("beside", textured(beside, Value::Null), HALF),
        ("within", textured(within, Value::Null), HALF),
        ("data", textured(as_data, Value::Null), HALF),
        ("moved", textured(beside, json!({ "offset": [0.5, 0.3] })), OTHER_HALF),
        ("scaled", textured(beside, json!({ "scale": [-1.0, 1.0], "offset": [1.0, 0.0] })), OTHER_HALF),
        ("turned", turned, HALF),
    ] {
        let file = format!("{name}.glb");
        std::fs::write(place.path(&file), gltf.glb()).unwrap();
        hold(&place, &file, expected, "");
    }
    // The example of the extension: the lower left quarter of the image.
    let example = json!({ "offset": [0, 1], "rotation": FRAC_PI_2, "scale": [0.5, 0.5] });
    std::fs::write(place.path("example.glb"), textured(beside, example).glb()).unwrap();
    let scene = read(&place, "example.glb");
    assert!(scene.uvs.iter().all(|uv| (-1e-6..=0.5 + 1e-6).contains(&uv.x)), "{:?}", scene.uvs);
    assert!(scene.uvs.iter().all(|uv| (-1e-6..=0.5 + 1e-6).contains(&uv.y)), "v is upwards: {:?}", scene.uvs);
    assert_eq!(scene.read_from, [place.path("half.png")]);
    std::fs::remove_file(place.path("half.png")).unwrap();
    let told = place.succeed(&["check", "beside.glb"]);
    assert!(told.contains("warning: images that cannot be used") && told.contains("no such file"), "{told}");
}

#[test]
fn panes_holes_and_colours_of_corners_are_read() {
    let place = empty();
    let mut gltf = Gltf::room();
    gltf.json["materials"][1]["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.6 }, "KHR_materials_ior": { "ior": 1.45 } });
    gltf.json["materials"][1]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.5, 1.0, 1.0, 1.0]);
    gltf.json["materials"][2]["alphaMode"] = json!("BLEND");
    gltf.json["materials"][2]["pbrMetallicRoughness"]["baseColorFactor"] = json!([0.6, 0.6, 0.6, 0.25]);
    // The floor without a material, from white to a linear 0.3.
    let colours = gltf.floats(&[
        [1.0, 1.0, 1.0, 1.0],
        [1.0, 1.0, 1.0, 1.0],
        [0.3, 0.3, 0.3, 1.0],
        [0.3, 0.3, 0.3, 1.0],
    ]);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    gltf.json["meshes"][0]["primitives"][0].as_object_mut().unwrap().remove("material");
    std::fs::write(place.path("panes.glb"), gltf.glb()).unwrap();
    let scene = read(&place, "panes.glb");
    let pane = |index: usize| scene.materials[index].glazing.as_ref().unwrap().transmittance(1.0);
    let [r, g, b] = pane(1);
    assert!((r - 0.3).abs() < 1e-6 && (g - 0.6).abs() < 1e-6 && (b - 0.6).abs() < 1e-6, "{r} {g} {b}");
    assert!((pane(2)[1] - 0.75).abs() < 1e-6);
    let painted = &scene.materials[scene.surfaces[0].material as usize];
    assert_eq!(painted.name, "Colours of corners");
    let sheet = &scene.textures[painted.texture.unwrap() as usize];
    for surface in scene.surfaces.iter().filter(|surface| surface.object == 0) {
        for corner in &surface.corners {
            let x = scene.positions[corner.position as usize].x;
            let found = sheet.sample(scene.uvs[corner.uv.unwrap() as usize])[0];
            let expected = if x < 1.0 { 0.98 } else { 0.3 };
            assert!((found - expected).abs() < 1e-5, "{found} at {x}");
        }
    }
    std::fs::create_dir(place.path("copy")).unwrap();
    // Both would have one sidecar.
    let refused = place.run(&["check", "panes.glb", "--repair", "panes.obj"]);
    assert!(String::from_utf8(refused.stderr).unwrap().contains("choose another name for the copy"));
    // An image with alpha is a hole where the material is cut, and none where it is opaque.
    let leaf = |_: &mut Gltf| {
        let mut bytes = Cursor::new(Vec::new());
        let leaf =
            image::RgbaImage::from_fn(8, 8, |x, _| image::Rgba([90, 140, 60, if x < 4 { 200 } else { 100 }]));
        leaf.write_to(&mut bytes, ImageFormat::Png).unwrap();
        json!({ "uri": format!("data:image/png;base64,{}", base64(&bytes.into_inner())) })
    };
    for (mode, opacity) in
        [("MASK", Some([1.0, 0.0])), ("BLEND", Some([200.0 / 255.0, 100.0 / 255.0])), ("OPAQUE", None)]
    {
        let mut gltf = textured(leaf, Value::Null);
        gltf.json["materials"][0]["alphaMode"] = json!(mode);
        std::fs::write(place.path("leaf.glb"), gltf.glb()).unwrap();
        let texture = &read(&place, "leaf.glb").textures[0];
        match opacity {
            Some([left, right]) => {
                let close =
                    |index: usize, value: f64| (f64::from(texture.opacity[index]) - value).abs() < 1e-6;
                assert!(close(0, left) && close(7, right), "{mode}: {:?}", &texture.opacity[..8]);
            }
            None => assert!(!texture.has_holes(), "{mode}"),
        }
        // So it is in a copy.
        place.succeed(&["check", "leaf.glb", "--repair", "copy/leaf.obj"]);
        let copied = &read(&place, "copy/leaf.obj").textures[0];
        assert_eq!(copied.opacity.len(), texture.opacity.len(), "{mode}");
        assert!(copied.opacity.iter().zip(&texture.opacity).all(|(a, b)| (a - b).abs() < 3e-3), "{mode}");
    }
}

#[test]
fn lights_without_a_surface_are_lamps_that_are_kept_and_edited() {
    let place = empty();
    let dark = |gltf: &mut Gltf| {
        // Direct light alone: nothing reflects.
        gltf.list("materials")
            .iter_mut()
            .for_each(|m| m["pbrMetallicRoughness"]["baseColorFactor"] = json!([0, 0, 0, 1]));
    };
    let mut point = with_light(json!({ "type": "point", "intensity": 200.0 }));
    dark(&mut point);
    std::fs::write(place.path("point.glb"), point.glb()).unwrap();
    place.put("points.csv", "2,0,1.5,0,1,0\n0.5,0,1.5,0,1,0\n");
    let found = lux(&place, "point.glb");
    // 200 cd over 2 m, and 2.5 m away under a cosine of 0.8.
    assert!(
        (found[0] / 50.0 - 1.0).abs() < 2e-3 && (found[1] / (200.0 * 0.8 / 6.25) - 1.0).abs() < 2e-3,
        "{found:?}"
    );
    let cone = json!({ "innerConeAngle": 0.4, "outerConeAngle": 0.6 });
    let mut spot =
        with_light(json!({ "type": "spot", "intensity": 200.0, "color": [1.0, 0.5, 0.25], "spot": cone }));
    dark(&mut spot);
    std::fs::write(place.path("spot.glb"), spot.glb()).unwrap();
    place.put("points.csv", "2,0,1.5,0,1,0\n1.0,0,1.5,0,1,0\n0.5,0,1.5,0,1,0\n");
    let found = lux(&place, "spot.glb");
    let strength = 200.0 * (0.2126 + 0.5 * 0.7152 + 0.25 * 0.0722);
    let angle = 0.5_f64.atan();
    let share = ((angle.cos() - 0.6_f64.cos()) / (0.4_f64.cos() - 0.6_f64.cos())).powi(2);
    let beside = strength * share * angle.cos() / 5.0;
    assert!((found[0] / (0.25 * strength) - 1.0).abs() < 3e-3, "{found:?} {strength}");
    assert!((found[1] / beside - 1.0).abs() < 0.02 && found[2] == 0.0, "{found:?} {beside}");

    let scene = read(&place, "spot.glb");
    assert_eq!(
        (scene.placed[0].name.as_str(), scene.views[0].name.as_str()),
        ("Lamp over table", "From the door")
    );
    assert!((scene.views[0].fov_y_deg - 1.0_f64.to_degrees()).abs() < 1e-5);
    // What is kept in a sidecar is read instead, the same; and a list without lamps keeps them away.
    let mut lighting = scene.lighting();
    lighting.lamps[0].dimmer = 0.5;
    let text = scene::sidecar_text(&scene, &lighting, &[], None).unwrap();
    place.put("spot.toml", &text);
    let kept = read(&place, "spot.glb");
    let (old, new) = (&scene.placed[0], &kept.placed[0]);
    assert_eq!((kept.placed.len(), new.dimmer, new.kind), (1, 0.5, old.kind));
    assert!((new.lumens / old.lumens - 1.0).abs() < 1e-9 && new.position.abs_diff_eq(old.position, 1e-9));
    let at = |lamp: &scene::PlacedLamp, degrees: f64| {
        let angle = degrees.to_radians();
        let photometry = &lamp.photometric.as_ref().unwrap().photometry;
        photometry.intensity(glam::DVec3::new(angle.sin(), 0.0, -angle.cos()))
    };
    for degrees in [0.0, 25.0, 30.0, 34.0, 40.0] {
        assert!((at(new, degrees) - at(old, degrees)).abs() < 1e-6 * at(old, 0.0), "{degrees}: {text}");
    }
    let none = scene.with_placed(Vec::new());
    let text = scene::sidecar_text(&none, &none.lighting(), &[], None).unwrap();
    assert!(text.contains("lamp = []"), "{text}");
    place.put("spot.toml", &text);
    assert!(read(&place, "spot.glb").placed.is_empty());
}

#[test]
fn a_repaired_copy_of_a_gltf_is_an_obj_with_the_same_light() {
    let place = empty();
    std::fs::create_dir(place.path("copy")).unwrap();
    let within = |gltf: &mut Gltf| {
        let view = gltf.view(&half_png());
        json!({ "bufferView": view, "mimeType": "image/png" })
    };
    std::fs::write(place.path("room.glb"), textured(within, Value::Null).glb()).unwrap();
    place.succeed(&["check", "room.glb", "--repair", "copy/room.obj"]);
    hold(&place, "copy/room.obj", HALF, "");
    let copied: Vec<String> = std::fs::read_dir(place.path("copy"))
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    assert_eq!(copied.len(), 4, "{copied:?}");
    let mut lit = with_light(json!({ "type": "point", "intensity": 200.0 }));
    lit.json["materials"][1]["extensions"] = json!({ "KHR_materials_transmission": { "transmissionFactor": 0.4 }, "KHR_materials_ior": { "ior": 1.6 } });
    std::fs::write(place.path("lit.glb"), lit.glb()).unwrap();
    place.succeed(&["check", "lit.glb", "--repair", "copy/lit.obj"]);
    let (scene, copy) = (read(&place, "lit.glb"), read(&place, "copy/lit.obj"));
    assert_eq!((copy.placed.len(), copy.views.len()), (1, 1));
    let pane = |scene: &Scene| {
        let pane = scene.materials.iter().find_map(|material| material.glazing.clone()).unwrap();
        (pane.transmittance(1.0)[1], pane.panes()[0].index())
    };
    assert!((pane(&scene).0 - pane(&copy).0).abs() < 1e-6 && pane(&scene).1 == pane(&copy).1);
    let (a, b) = (lux(&place, "lit.glb"), lux(&place, "copy/lit.obj"));
    assert!(a.iter().zip(&b).all(|(a, b)| (a / b - 1.0).abs() < 1e-3), "{a:?} {b:?}");
}

#[test]
fn double_sided_sheets_glow_to_both_sides_and_bodies_outwards() {
    let place = empty();
    let mut gltf = Gltf::room();
    gltf.json["materials"][3]["doubleSided"] = json!(true);
    std::fs::write(place.path("sheet.glb"), gltf.glb()).unwrap();
    let scene = read(&place, "sheet.glb");
    assert!(scene.surfaces.iter().all(|surface| surface.emits_back == surface.luminaire.is_some()));
    let lumens = scene::lumens(&scene)[0][0];
    assert!((lumens / (2.0 * 0.36 * LUMINANCE * PI) - 1.0).abs() < 1e-5, "{lumens}");
    // So they do in a copy, whose format does not know of sides.
    std::fs::create_dir(place.path("copy")).unwrap();
    place.succeed(&["check", "sheet.glb", "--repair", "copy/sheet.obj"]);
    let copied = scene::lumens(&read(&place, "copy/sheet.obj"))[0][0];
    assert!((copied / lumens - 1.0).abs() < 1e-5, "{copied} lm of {lumens}");
    // The walls, floor and ceiling are a closed body.
    let mut gltf = Gltf::new();
    let glow = gltf.push("materials", material("glow", 0.0));
    gltf.json["materials"][glow]["doubleSided"] = json!(true);
    let quads: Vec<[usize; 4]> = PARTS[..3].iter().flat_map(|(_, _, quads)| quads.iter().copied()).collect();
    let mesh = gltf.part(&quads, glow, &|place| place);
    gltf.node(json!({ "name": "body", "mesh": mesh }));
    std::fs::write(place.path("body.glb"), gltf.glb()).unwrap();
    assert!(read(&place, "body.glb").surfaces.iter().all(|surface| !surface.emits_back));
}

#[test]
fn copies_of_odd_names_can_be_read_and_replace_no_foreign_image() {
    let place = empty();
    std::fs::create_dir(place.path("copy")).unwrap();
    let within = |gltf: &mut Gltf| {
        let view = gltf.view(&half_png());
        json!({ "bufferView": view, "mimeType": "image/png" })
    };
    let mut gltf = textured(within, Value::Null);
    gltf.json["materials"][2]["name"] = json!("wall\\");
    gltf.json["materials"][1]["name"] = json!("ceiling\nKd 1 0 0");
    gltf.json["nodes"][0]["name"] = json!("floor\\");
    std::fs::write(place.path("room.glb"), gltf.glb()).unwrap();
    // A picture that somebody has taken.
    std::fs::write(place.path("copy/room-1.png"), "mine").unwrap();
    let repair = ["check", "room.glb", "--repair", "copy/room.obj"];
    let refused = place.run(&repair);
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(told.contains("room-1.png is there and is no image of an earlier copy"), "{told}");
    assert_eq!(place.text("copy/room-1.png"), "mine");
    std::fs::remove_file(place.path("copy/room-1.png")).unwrap();
    for _ in 0..2 {
        place.succeed(&repair);
        hold(&place, "copy/room.obj", HALF, "wall");
    }
    // An image of the model that no light is computed with is one of its files as well.
    std::fs::write(place.path("bumps-1.png"), half_png()).unwrap();
    let mut gltf = textured(within, Value::Null);
    gltf.push("images", json!({ "uri": "bumps-1.png" }));
    std::fs::write(place.path("room.glb"), gltf.glb()).unwrap();
    let refused = place.run(&["check", "room.glb", "--repair", "bumps.obj"]);
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(told.contains("bumps-1.png is a file of the model itself"), "{told}");
}

#[test]
fn damaged_gltf_is_refused_in_one_sentence() {
    let place = empty();
    let edited = |edit: fn(&mut Value)| {
        let mut gltf = Gltf::room();
        edit(&mut gltf.json);
        gltf.with_data()
    };
    let cut = |gltf: &str| gltf[..gltf.len() / 2].to_owned();
    for (text, words) in [
        (String::new(), "file is empty"),
        ("{}".to_owned(), "no glTF that can be read"),
        (cut(&Gltf::room().with_data()), "line 1: this is no glTF that can be read"),
        (r#"{"asset":{"version":"1.0"},"meshes":{}}"#.to_owned(), "glTF 1.0"),
        (edited(|g| g["extensionsRequired"] = json!(["KHR_draco_mesh_compression"])), "without compression"),
        (edited(|g| g["extensionsRequired"] = json!(["VENDOR_thing"])), "without 'VENDOR_thing'"),
        (edited(|g| g["meshes"][0]["primitives"][0]["indices"] = json!(99)), "it is damaged"),
        (
            edited(|g| g["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99)),
            "its mesh 0 asks for accessor 99",
        ),
        (edited(|g| g["accessors"][0]["count"] = json!(4_000_000_000_u32)), "the mesh of 'floor' announces"),
        (edited(|g| g["accessors"][1]["count"] = json!(7)), "announces 7 elements, more than its data holds"),
        (edited(|g| g["bufferViews"][0]["byteLength"] = json!(9_000_000)), "reaches beyond the end"),
        (edited(|g| g["nodes"][0]["children"] = json!([0])), "hangs on several, or on itself"),
        (edited(|g| g["nodes"][0]["scale"] = json!([1e38, 1, 1])), "a corner at no usable place"),
        (edited(|g| g["nodes"] = json!([{ "name": "nothing" }])), "it is damaged"),
    ] {
        place.put("room.gltf", &text);
        let error = scene::load(&SceneSource::File(place.path("room.gltf"))).unwrap_err().to_string();
        assert!(error.starts_with("room.gltf") && error.contains(words), "{words}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
    let gltf = Gltf::room();
    place.put("room.gltf", &gltf.text("gone.bin"));
    let error = scene::load(&SceneSource::File(place.path("room.gltf"))).unwrap_err().to_string();
    assert!(error.contains("'gone.bin' cannot be read (there is no such file)"), "{error}");
    std::fs::write(place.path("gone.bin"), [0; 10]).unwrap();
    let error = scene::load(&SceneSource::File(place.path("room.gltf"))).unwrap_err().to_string();
    assert!(error.contains("cut off: it has 10 of"), "{error}");
    let glb = Gltf::room().glb();
    std::fs::write(place.path("cut.glb"), &glb[..glb.len() - 40]).unwrap();
    let error = scene::load(&SceneSource::File(place.path("cut.glb"))).unwrap_err().to_string();
    assert!(error.starts_with("cut.glb: ") && error.contains("cut off"), "{error}");
}
