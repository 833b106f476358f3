//! Files as other programs write them: whatever their habits, the light of a room is the same.
//!
//! The values are those of a path tracer for a room of 4 x 2.5 x 3 m with a lamp of 0.6 x 0.6 m below its
//! ceiling, in lux at three points of the floor.

mod cli_support;

use cli_support::Workplace;
use image::{ImageFormat, Rgb, RgbImage};
use std::fs;

/// With a floor of reflectance 0.3.
const PLAIN: [f64; 3] = [146.3, 109.9, 85.5];
/// With a floor of 0.503.
const OAK: [f64; 3] = [155.8, 117.3, 93.3];
/// With a floor that is 0.98 where x is small, and black beyond its middle.
const HALF: [f64; 3] = [156.1, 121.6, 87.5];
/// The other way round.
const OTHER_HALF: [f64; 3] = [156.0, 113.5, 99.6];

const OBJ: &str = "mtllib room.mtl
v 0 0 0\nv 0 0 3\nv 4 0 3\nv 4 0 0\nv 0 2.5 0\nv 4 2.5 0\nv 4 2.5 3\nv 0 2.5 3
v 1.7 2.45 1.2\nv 2.3 2.45 1.2\nv 2.3 2.45 1.8\nv 1.7 2.45 1.8
vt 0 0\nvt 0 1\nvt 1 1\nvt 1 0
o floor\nusemtl floor\nf 1/1 2/2 3/3 4/4
o ceiling\nusemtl ceiling\nf 5 6 7 8
o walls\nusemtl wall\nf 1 5 8 2\nf 4 3 7 6\nf 1 4 6 5\nf 2 8 7 3
o panel\nusemtl lamp\nf 9 10 11 12
";
const MTL: &str = "newmtl floor\nKd 0.3 0.3 0.3\nnewmtl wall\nKd 0.6 0.6 0.6\nnewmtl ceiling\nKd 0.8 0.8 0.8
newmtl lamp\nKd 0 0 0\nKe 10 10 10\n";

/// A folder with the room, and with `oak.png` and `half.png`.
fn room() -> Workplace {
    let place = Workplace::with_room(0.5);
    place.put("room.obj", OBJ);
    place.put("room.mtl", MTL);
    fs::remove_file(place.path("room.toml")).unwrap();
    place.put("points.csv", "2,0,1.5,0,1,0\n1,0,0.75,0,1,0\n3.5,0,2.5,0,1,0\n");
    RgbImage::from_pixel(4, 4, Rgb([188; 3])).save(place.path("oak.png")).unwrap();
    let half = RgbImage::from_fn(64, 2, |x, _| Rgb([if x < 32 { 255 } else { 0 }; 3]));
    half.save(place.path("half.png")).unwrap();
    place
}

/// The library with something else for the floor.
fn floor(statements: &str) -> String {
    MTL.replacen("Kd 0.3 0.3 0.3", statements, 1)
}

/// The room with texture coordinates of half the size.
fn halved() -> String {
    OBJ.replace("vt 0 1\nvt 1 1\nvt 1 0", "vt 0 0.5\nvt 0.5 0.5\nvt 0.5 0")
}

fn lux(place: &Workplace, obj: &str) -> Vec<f64> {
    lux_with(place, obj, &[])
}

fn lux_with(place: &Workplace, obj: &str, options: &[&str]) -> Vec<f64> {
    let plain = ["solve", obj, "--patches", "400", "--points", "points.csv", "--irradiance", "lux.csv"];
    place.succeed(&[&plain[..], options].concat());
    let text = place.text("lux.csv");
    let column = text.lines().next().unwrap().split(',').position(|name| name == "lux").unwrap();
    text.lines().skip(1).map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect()
}

/// Holds the room against its values, and what is told about it against words.
fn hold(place: &Workplace, obj: &str, expected: [f64; 3], words: &str) {
    let found = lux(place, obj);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found / expected - 1.0).abs() < 0.02, "{obj}, {words}: {found} lx, not {expected}");
    }
    let told = place.succeed(&["check", obj]);
    assert!(told.contains(words), "{words}: {told}");
    let warns = told.lines().any(|line| line.starts_with("warning"));
    assert!(!warns, "{told}");
}

#[test]
fn habits_of_libraries_leave_the_light_as_it_is() {
    let place = room();
    for (mtl, expected, words) in [
        (MTL.to_owned(), PLAIN, ""),
        (MTL.replace("Kd", "kd").replace("Ke", "KE").replace("newmtl", "NewMtl"), PLAIN, ""),
        (
            MTL.replace("newmtl wall", "newmtl \"wall\"").replace("newmtl lamp", "newmtl LAMP"),
            PLAIN,
            "'lamp' as 'LAMP'",
        ),
        (MTL.replace("newmtl wall", "newmtl wall # plaster"), PLAIN, ""),
        (
            MTL.replace("newmtl wall\n", "newmtl wall\nmap_Kd \nbump\nKd\nmap_Ke \nillum\n"),
            PLAIN,
            "without a value were left out",
        ),
        (floor("Kd xyz 0.28514 0.3 0.32665"), PLAIN, ""),
        (floor("Kd 1 1 1\nMAP_KD oak.png"), OAK, ""),
        (floor("Kd 0 0 0\nmap_Kd oak.png"), OAK, "a black Kd"),
        (floor("Kd 1 1 1\nmap_Kd Oak.PNG"), OAK, ""),
        (floor("map_Kd -bm 0.2 half.png"), HALF, "'-bm 0.2' of material 'floor'"),
        (floor("map_Kd -o 0.5 0 0 half.png"), OTHER_HALF, ""),
        (floor("map_Kd -s -1 1 1 \"half.png\""), OTHER_HALF, ""),
        (floor("map_Kd -o -0.25 -s 0.5 -clamp on half.png"), [181.2, 142.6, 118.1], ""),
        (floor("map_Kd -mm 0.3 0 half.png"), PLAIN, ""),
    ] {
        place.put("room.mtl", &mtl);
        hold(&place, "room.obj", expected, words);
    }
    // Twice as large an image on half of the coordinates is where it was.
    place.put("room.obj", &halved());
    place.put("room.mtl", &floor("map_Kd -s 2 2 1 half.png"));
    hold(&place, "room.obj", HALF, "");
}

#[test]
fn formats_of_images_are_those_that_modellers_use() {
    let place = room();
    let grey = image::DynamicImage::ImageRgb8(RgbImage::from_pixel(8, 8, Rgb([188; 3])));
    for (name, format) in [
        ("a.tga", ImageFormat::Tga),
        ("a.bmp", ImageFormat::Bmp),
        ("a.tif", ImageFormat::Tiff),
        ("a.webp", ImageFormat::WebP),
        ("a.gif", ImageFormat::Gif),
        ("a.jpg", ImageFormat::Jpeg),
    ] {
        grey.save_with_format(place.path(name), format).unwrap();
        place.put("room.mtl", &floor(&format!("map_Kd {name}")));
        let told = place.succeed(&["check", "room.obj"]);
        let warns = told.lines().any(|line| line.starts_with("warning"));
        assert!(told.contains("; 1 image\n") && !warns, "{name}: {told}");
    }
    hold(&place, "room.obj", OAK, "");
}

#[test]
fn habits_of_models_leave_the_light_as_it_is() {
    let place = room();
    let wrapped = OBJ.replace("f 5 6 7 8", "F 5 6 \\\n 7 8").replace("mtllib", "# C:\\models\\\nMTLLIB");
    for (obj, words) in [
        (wrapped, ""),
        (OBJ.replace("usemtl wall", "usemtl wall   # plaster"), ""),
        (OBJ.replace("usemtl wall", "UseMtl \"wall\""), ""),
        (OBJ.replace("usemtl wall", "usemtl Wall"), "'Wall' as 'wall'"),
        (OBJ.replace("mtllib room.mtl", "mtllib ROOM.mtl # ours"), ""),
        (OBJ.replace("mtllib room.mtl", "mtllib gone.mtl"), "'room.mtl' was read for its name"),
        (OBJ.replace("mtllib room.mtl\n", ""), "room.obj names none"),
        (
            OBJ.replace("v 0 0 0\n", "v 0 0 0 0.5 0.5 0.5\n"),
            "colours of corners are not read where faces have a material, which says what reflects (1 in the file)",
        ),
    ] {
        place.put("room.obj", &obj);
        hold(&place, "room.obj", PLAIN, words);
    }
    // A library with a blank in its name, among others; a folder of its own with images named from there.
    fs::create_dir(place.path("lib")).unwrap();
    fs::rename(place.path("oak.png"), place.path("lib/oak.png")).unwrap();
    place.put("lib/my room.mtl", &floor("map_Kd oak.png"));
    place.put("room.mtl", "newmtl other\nKd 0 0 0\n");
    place.put("room.obj", &OBJ.replace("mtllib room.mtl", "mtllib room.mtl \"lib\\my room.mtl\""));
    hold(&place, "room.obj", OAK, "");
    // The copy names the image from where it is, and says the same with the image laid already.
    place.put("lib/my room.mtl", &floor("map_Kd -s 2 2 1 -o 0.5 ../half.png\nbump -s 4 2 1 oak.png"));
    place.put("room.obj", &halved().replace("mtllib room.mtl", "mtllib room.mtl \"lib\\my room.mtl\""));
    place.succeed(&["check", "room.obj", "--repair", "copy.obj"]);
    let library = place.text("copy.mtl");
    assert!(library.contains("map_Kd half.png\n"), "{library}");
    assert!(library.contains("bump -o -1 0 0 -s 2 1 1 lib/oak.png\n"), "{library}");
    place.put("lib/my room.mtl", &MTL.replace("Kd 0.3 0.3 0.3", "Kd 0.9 0.9 0.9"));
    hold(&place, "copy.obj", OTHER_HALF, "");
}

#[test]
fn encodings_of_texts_leave_the_light_as_it_is() {
    let place = room();
    let obj = OBJ.replace("room.mtl", "möbel.mtl").replace("usemtl floor", "usemtl Fußboden");
    let mtl = floor("map_Kd Fußboden.png").replace("newmtl floor", "newmtl Fußboden");
    fs::rename(place.path("oak.png"), place.path("Fußboden.png")).unwrap();
    let sidecar = "[[luminaire]]\nobject = \"panel\"\nname = \"Ü\"\n";
    let latin = |text: &str| text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect::<Vec<u8>>();
    let utf8 = |text: &str| text.as_bytes().to_vec();
    let utf16 = |text: &str| {
        let units = std::iter::once(0xfeff).chain(text.encode_utf16());
        units.flat_map(u16::to_le_bytes).collect::<Vec<u8>>()
    };
    type Encode<'a> = &'a dyn Fn(&str) -> Vec<u8>;
    let encodings: [(Encode<'_>, Encode<'_>); 4] =
        [(&latin, &latin), (&latin, &utf8), (&utf8, &utf16), (&utf16, &latin)];
    for (of_obj, of_others) in encodings {
        fs::write(place.path("room.obj"), of_obj(&obj)).unwrap();
        fs::write(place.path("möbel.mtl"), of_others(&mtl)).unwrap();
        fs::write(
            place.path("room.toml"),
            if of_others(&mtl) == latin(&mtl) { utf16(sidecar) } else { of_others(sidecar) },
        )
        .unwrap();
        hold(&place, "room.obj", OAK, "Ü");
    }
}

#[test]
fn equal_names_are_lamps_of_their_own() {
    let place = room();
    let mut obj = OBJ.replace("o panel\nusemtl lamp\nf 9 10 11 12\n", "");
    for k in 0..12 {
        let (x, z) = (0.45 + f64::from(k / 3), 0.45 + f64::from(k % 3));
        obj += "o downlight\nusemtl lamp\n";
        for (dx, dz) in [(0.0, 0.0), (0.1, 0.0), (0.1, 0.1), (0.0, 0.1)] {
            obj += &format!("v {} 2.45 {}\n", x + dx, z + dz);
        }
        obj += "f -4 -3 -2 -1\n";
    }
    place.put("room.obj", &obj);
    place.put("room.toml", "[[luminaire]]\nobject = \"downlight\"\nlumens = 800\n");
    let told = place.succeed(&["check", "room.obj"]);
    assert!(told.contains("luminaires  12") && told.contains("Downlight 12  800 lm"), "{told}");
    let all = lux(&place, "room.obj");
    assert!((all[0] / 522.8 - 1.0).abs() < 0.02, "{all:?}");
    let dimmed = lux_with(&place, "room.obj", &["--dim", "DOWNLIGHT=0.5"]);
    assert!((dimmed[0] / all[0] - 0.5).abs() < 1e-3, "{dimmed:?}");
    let without = lux_with(&place, "room.obj", &["--off", "downlight_3"]);
    assert!(without.iter().zip(&all).all(|(without, all)| *without < *all && *without > 0.7 * all));
}

#[test]
fn images_that_are_gone_leave_no_white_behind_and_equal_notes_are_one() {
    let place = room();
    for (floor_says, reflectance) in [
        ("Kd 1 1 1\nmap_Kd gone.png", "0.500"),
        ("map_Kd gone.png", "0.500"),
        ("Kd 0 0 0\nmap_Kd gone.png", "0.500"),
        ("Kd 0.7 0.7 0.7\nmap_Kd gone.png", "0.700"),
    ] {
        place.put("room.mtl", &floor(floor_says));
        let told = place.succeed(&["check", "room.obj"]);
        let line = told.lines().find(|line| line.contains("floor ") && line.contains("reflectance")).unwrap();
        assert!(line.contains(&format!("reflectance {reflectance}")), "{floor_says}: {line}");
        assert!(told.contains("'gone.png' of material 'floor' (there is no such file)"), "{told}");
    }
    let many: String = (0..180).map(|k| format!("newmtl m{k}\nNs 1\n")).collect();
    place.put("room.mtl", &format!("{MTL}{many}"));
    let told = place.succeed(&["check", "room.obj"]);
    assert_eq!(told.matches("without a Kd").count(), 1, "{told}");
    assert!(told.contains("'m0', 'm1', 'm2', 'm3' and 176 more"), "{told}");
}

#[test]
fn emission_is_told_where_it_is_doubtful_and_images_of_it_count() {
    let place = room();
    place.put("room.mtl", &MTL.replace("Kd 0.", "Ke 1 1 1\nKd 0."));
    let told = place.succeed(&["check", "room.obj"]);
    assert!(told.contains("warning: 100 % of the area emits light, by the Ke of 'floor', "), "{told}");
    for (ke, lumens) in [
        ("Ke 20 20 20\nmap_Ke half.png", "2024 lm"),
        ("map_Ke half.png", "101 lm"),
        ("Ke 10 10 10\nmap_Ke gone.png", "2024 lm"),
    ] {
        place.put("room.mtl", &MTL.replace("Ke 10 10 10", ke));
        let told = place.succeed(&["check", "room.obj"]);
        assert!(told.contains(lumens) && told.contains("images of emission"), "{ke}: {told}");
    }
    place.put("room.mtl", &MTL.replace("Ke 10 10 10", "Ke 0 0 0\nmap_Ke half.png"));
    assert!(place.succeed(&["check", "room.obj"]).contains("without effect, as Ke is 0"));
}

#[test]
fn faces_without_texture_coordinates_show_the_mean_of_their_image() {
    let place = room();
    for (from, to, words) in [
        ("1/1 2/2 3/3 4/4", "1 2 3 4", "have no texture coordinates (1, first in line "),
        ("1/1 2/2 3/3 4/4", "1/1 2/2 3/3 4/9", "texture coordinates that are not there"),
    ] {
        place.put("room.obj", &OBJ.replace(from, to));
        place.put("room.mtl", &floor("map_Kd half.png"));
        let told = place.succeed(&["check", "room.obj"]);
        assert!(told.contains(words), "{told}");
        let found = lux(&place, "room.obj");
        // A floor of 0.49 all over.
        assert!((found[1] / 116.8 - 1.0).abs() < 0.02, "{found:?}");
    }
}
