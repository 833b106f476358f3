//! Light of sky and sun in models: CIE 171:2006, open surfaces, shadows of the sun.

mod common;

use glam::DVec3;
use lumenwalk::scene::{SceneSource, load};
use lumenwalk::solve::{self, Control, DirectTarget, Solution, SolveSettings};
use std::fmt::Write as _;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

const BLACK: &str = "newmtl black\nKd 0 0 0\nnewmtl grey\nKd 0.5 0.5 0.5\n\
                     newmtl glass\nKd 0 0 0\nNi 1.52\nillum 6\nTf 0.88146 0.88146 0.88146\n\
                     newmtl dim\nKd 0 0 0\nKe 1 1 1\nnewmtl bright\nKd 0 0 0\nKe 1000 1000 1000\n";

/// A model with z up and its light.
fn solved(obj: &str, sidecar: &str, patches: usize) -> Solution {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).expect("written");
    write("model.obj", &format!("mtllib model.mtl\n{obj}"));
    write("model.mtl", BLACK);
    write("model.toml", &format!("up = \"z\"\n{sidecar}"));
    let scene = load(&SceneSource::File(folder.path().join("model.obj"))).expect("a scene");
    // Points are gathered anew, whatever the elements are.
    let direct = DirectTarget { work: 100_000, ..DirectTarget::default() };
    let patches = lumenwalk::mesh::PatchTarget::Count(patches);
    let settings = SolveSettings { patches, direct, ..SolveSettings::default() };
    let never = AtomicBool::new(false);
    solve::solve(Arc::new(scene), &settings, &never, &mut |_| Control::Continue).expect("solved")
}

/// Illuminance at points with normals, lux.
fn lux(solution: &Solution, points: &[(DVec3, DVec3)]) -> Vec<f64> {
    let light = solution.light(&solution.scene.lighting());
    let found = solution.irradiance_at(points, &light);
    found.into_iter().map(lumenwalk::scene::illuminance).collect()
}

/// A box open at a rectangle of one face, as quads around the hole: `x`, `y`, `z` spans of the room.
struct Obj {
    text: String,
    vertices: usize,
}

impl Obj {
    fn new() -> Self {
        Self { text: String::new(), vertices: 0 }
    }

    fn quad(&mut self, material: &str, corners: [[f64; 3]; 4]) {
        for [x, y, z] in corners {
            writeln!(self.text, "v {x} {y} {z}").expect("a string");
        }
        let n = self.vertices;
        writeln!(self.text, "usemtl {material}\nf {} {} {} {}", n + 1, n + 2, n + 3, n + 4)
            .expect("a string");
        self.vertices += 4;
    }

    /// A rectangle in a plane of constant `axis` with a hole: outer and inner spans of the two other axes.
    fn pierced(
        &mut self,
        at: impl Fn(f64, f64) -> [f64; 3],
        [u0, u1, v0, v1]: [f64; 4],
        [a0, a1, b0, b1]: [f64; 4],
    ) {
        let mut piece = |p: [f64; 4]| {
            if p[1] - p[0] > 1e-9 && p[3] - p[2] > 1e-9 {
                self.quad("black", [at(p[0], p[2]), at(p[1], p[2]), at(p[1], p[3]), at(p[0], p[3])]);
            }
        };
        piece([u0, u1, v0, b0]);
        piece([u0, u1, b1, v1]);
        piece([u0, a0, b0, b1]);
        piece([a1, u1, b0, b1]);
    }
}

/// The black room of CIE 171:2006, 4 x 4 x 3 m, with a square of an `edge` open in its ceiling, or a window of 2 x 1 m
/// in its south wall.
fn room(roof: Option<f64>) -> String {
    let mut obj = Obj::new();
    obj.quad("black", [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [0.0, 4.0, 0.0]]);
    obj.quad("black", [[0.0, 4.0, 0.0], [4.0, 4.0, 0.0], [4.0, 4.0, 3.0], [0.0, 4.0, 3.0]]);
    obj.quad("black", [[0.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 4.0, 3.0], [0.0, 0.0, 3.0]]);
    obj.quad("black", [[4.0, 0.0, 0.0], [4.0, 4.0, 0.0], [4.0, 4.0, 3.0], [4.0, 0.0, 3.0]]);
    let whole = [0.0, 4.0, 0.0, 4.0];
    match roof {
        Some(edge) => {
            let (low, high) = (2.0 - 0.5 * edge, 2.0 + 0.5 * edge);
            obj.pierced(|x, y| [x, y, 3.0], whole, [low, high, low, high]);
            obj.quad("black", [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [4.0, 0.0, 3.0], [0.0, 0.0, 3.0]]);
        }
        None => {
            obj.quad("black", [[0.0, 0.0, 3.0], [4.0, 0.0, 3.0], [4.0, 4.0, 3.0], [0.0, 4.0, 3.0]]);
            obj.pierced(|x, z| [x, 0.0, z], [0.0, 4.0, 0.0, 3.0], [1.0, 3.0, 1.0, 2.0]);
        }
    }
    obj.text
}

/// The same room with a pane of clear glass, of a transmissivity of 0.96, in its opening.
fn glazed(roof: Option<f64>) -> String {
    let mut obj = Obj { text: room(roof), vertices: 0 };
    obj.vertices = obj.text.lines().filter(|line| line.starts_with("v ")).count();
    match roof {
        Some(edge) => {
            let (low, high) = (2.0 - 0.5 * edge, 2.0 + 0.5 * edge);
            obj.quad("glass", [[low, low, 3.0], [high, low, 3.0], [high, high, 3.0], [low, high, 3.0]]);
        }
        None => obj.quad("glass", [[1.0, 0.0, 1.0], [3.0, 0.0, 1.0], [3.0, 0.0, 2.0], [1.0, 0.0, 2.0]]),
    }
    obj.text
}

/// Points A to F down a wall at `y` that faces `normal`, then G to N across the floor.
fn points(y: f64, normal: DVec3, floor: impl Fn(f64) -> f64) -> Vec<(DVec3, DVec3)> {
    let wall = (0..6).map(|k| (DVec3::new(2.0, y, 2.75 - 0.5 * f64::from(k)), normal));
    let along = (0..8).map(|k| (DVec3::new(2.0, floor(0.25 + 0.5 * f64::from(k)), 0.0), DVec3::Z));
    wall.chain(along).collect()
}

#[track_caller]
fn assert_near(case: &str, found: &[f64], exact: &[f64], worst: f64) {
    for (k, (found, exact)) in found.iter().zip(exact).enumerate() {
        let off = found / exact - 1.0;
        assert!(off.abs() < worst, "{case}, point {k}: {found:.3} for {exact} ({:+.1} %)", 100.0 * off);
    }
}

#[test]
fn a_hole_in_the_roof_lights_a_black_room_as_cie_171_5_9_says() {
    // Per cent of the horizontal illuminance of the sky, sun at 60 degrees without its own light; the wall faces the sun.
    let type_1 =
        [0.457, 1.644, 2.336, 2.261, 1.876, 1.465, 2.335, 3.110, 3.839, 4.294, 4.294, 3.839, 3.110, 2.335];
    let type_12 =
        [1.743, 3.757, 4.547, 4.609, 4.240, 3.633, 5.723, 6.005, 5.113, 3.968, 2.897, 2.035, 1.402, 0.965];
    let type_16 =
        [0.564, 1.783, 2.318, 2.198, 1.821, 1.427, 2.289, 3.074, 3.823, 4.294, 4.294, 3.823, 3.074, 2.289];
    for (sky, exact) in [(1, type_1), (12, type_12), (16, type_16)] {
        // The sun in the south: the wall opposite is that at y = 0, and it faces north.
        let sidecar = format!("[daylight]\nsun = [60, 0]\nsky = \"{sky}\"\nlux = [0, 10000]\nground = 0\n");
        let solution = solved(&room(Some(1.0)), &sidecar, 300);
        let points = points(0.0, DVec3::Y, |y| y);
        let found: Vec<f64> = lux(&solution, &points).into_iter().map(|lux| lux / 100.0).collect();
        println!("{sky}: {found:.3?}");
        assert_near(&format!("type {sky}"), &found, &exact, if sky == 12 { 0.01 } else { 0.003 });
    }
}

#[test]
fn a_window_lights_a_black_room_as_cie_171_5_11_says() {
    // Sun at 60 degrees in the south without its own light; the wall is the one opposite to the window, floor points run
    // from it to the window. The ground has a luminance of 0.30 E / pi.
    let type_1 =
        [0.951, 1.063, 1.250, 1.508, 1.700, 1.856, 0.873, 1.308, 2.021, 3.198, 5.072, 7.637, 9.324, 5.089];
    let type_12 =
        [0.951, 1.063, 2.384, 4.931, 5.805, 5.012, 1.997, 2.795, 4.059, 6.126, 9.536, 14.557, 16.368, 5.026];
    for (sky, exact) in [(1, type_1), (12, type_12)] {
        let sidecar =
            format!("[daylight]\nsun = [60, 180]\nsky = \"{sky}\"\nlux = [0, 10000]\nground = 0.3\n");
        let solution = solved(&room(None), &sidecar, 300);
        let points = points(4.0, DVec3::NEG_Y, |y| 4.0 - y);
        let found: Vec<f64> = lux(&solution, &points).into_iter().map(|lux| lux / 100.0).collect();
        println!("{sky}: {found:.3?}");
        assert_near(&format!("type {sky}"), &found, &exact, 0.01);
    }
}

#[test]
fn glass_in_the_roof_lights_a_black_room_as_cie_171_5_10_says() {
    let type_1 =
        [0.152, 1.169, 1.914, 1.930, 1.626, 1.279, 2.047, 2.735, 3.381, 3.784, 3.784, 3.381, 2.735, 2.047];
    let type_12 =
        [0.579, 2.659, 3.723, 3.936, 3.676, 3.172, 5.017, 5.279, 4.503, 3.497, 2.553, 1.792, 1.233, 0.846];
    let whole_1 = [
        26.900, 25.216, 22.206, 18.694, 15.337, 12.424, 27.878, 32.682, 36.205, 38.046, 38.046, 36.205,
        32.682, 27.878,
    ];
    for (edge, sky, exact, worst) in
        [(1.0, 1, type_1, 0.007), (1.0, 12, type_12, 0.01), (4.0, 1, whole_1, 0.004)]
    {
        let sidecar = format!("[daylight]\nsun = [60, 0]\nsky = \"{sky}\"\nlux = [0, 10000]\nground = 0\n");
        let solution = solved(&glazed(Some(edge)), &sidecar, 300);
        let found: Vec<f64> =
            lux(&solution, &points(0.0, DVec3::Y, |y| y)).into_iter().map(|lux| lux / 100.0).collect();
        println!("{edge} m, {sky}: {found:.3?}");
        assert_near(&format!("{edge} m, type {sky}"), &found, &exact, worst);
    }
}

#[test]
fn a_glazed_window_lights_a_black_room_as_cie_171_5_12_says() {
    let type_1 =
        [0.837, 0.936, 1.102, 1.329, 1.497, 1.633, 0.767, 1.149, 1.771, 2.791, 4.388, 6.447, 7.193, 2.164];
    let type_12 =
        [0.837, 0.936, 2.101, 4.345, 5.114, 4.411, 1.756, 2.455, 3.557, 5.348, 8.249, 12.289, 12.714, 2.166];
    for (sky, exact) in [(1, type_1), (12, type_12)] {
        let sidecar =
            format!("[daylight]\nsun = [60, 180]\nsky = \"{sky}\"\nlux = [0, 10000]\nground = 0.3\n");
        let solution = solved(&glazed(None), &sidecar, 300);
        let points = points(4.0, DVec3::NEG_Y, |y| 4.0 - y);
        let found: Vec<f64> = lux(&solution, &points).into_iter().map(|lux| lux / 100.0).collect();
        println!("{sky}: {found:.3?}");
        assert_near(&format!("type {sky}"), &found, &exact, 0.01);
    }
}

#[test]
fn the_sun_through_a_pane_is_dimmed_by_its_angle() {
    // A black table, which sends nothing back, under a sheet of glass: sun at 30 degrees from the zenith and at 60.
    for (elevation, passed) in [(60.0_f64, 0.87705), (30.0, 0.80152)] {
        let mut obj = Obj::new();
        obj.quad("black", [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        obj.quad("glass", [[-9.0, -9.0, 0.5], [9.0, -9.0, 0.5], [9.0, 9.0, 0.5], [-9.0, 9.0, 0.5]]);
        let sidecar = format!(
            "[daylight]\nsun = [{elevation}, 180]\nsky = \"uniform\"\nlux = [80000, 0]\nground = 0\n"
        );
        let solution = solved(&obj.text, &sidecar, 200);
        let found = lux(&solution, &[(DVec3::ZERO, DVec3::Z)])[0];
        let exact = 80_000.0 * elevation.to_radians().sin() * passed;
        assert!((found / exact - 1.0).abs() < 2e-3, "{elevation}: {found:.0} for {exact:.0}");
    }
}

/// A post of 2 m on a square of 20 m.
fn sundial() -> String {
    let mut obj = Obj::new();
    obj.quad("grey", [[-10.0, -10.0, 0.0], [10.0, -10.0, 0.0], [10.0, 10.0, 0.0], [-10.0, 10.0, 0.0]]);
    let (a, h) = (0.2, 2.0);
    obj.quad("grey", [[-a, -a, h], [a, -a, h], [a, a, h], [-a, a, h]]);
    for k in 0..4 {
        let corner = |k: usize, z: f64| {
            let [x, y] = [[-a, -a], [a, -a], [a, a], [-a, a]][k % 4];
            [x, y, z]
        };
        obj.quad("grey", [corner(k, 0.0), corner(k + 1, 0.0), corner(k + 1, h), corner(k, h)]);
    }
    obj.text
}

#[test]
fn the_sun_throws_a_shadow_of_its_own_width_and_lights_the_rest_by_its_cosine() {
    // At 45 degrees in the south: the shadow of the post reaches 2 m to the north.
    let sidecar = "[daylight]\nsun = [45, 180]\nsky = \"uniform\"\nlux = [80000, 0]\nground = 0\n";
    let solution = solved(&sundial(), sidecar, 400);
    let at = |y: f64| (DVec3::new(0.0, y, 0.0), DVec3::Z);
    let open = 80_000.0 * 45.0_f64.to_radians().sin();
    // The middle of its edge; half a degree is 25 mm wide there, seen along the ground.
    let edge = 0.2 + 2.0;
    let found = lux(&solution, &[at(-5.0), at(1.5), at(edge), at(edge - 0.02), at(edge + 0.02), at(8.0)]);
    println!("{found:.0?}");
    let passed_on = 0.03 * open;
    for (k, exact) in [(0, open), (5, open)] {
        assert!((found[k] - exact).abs() < passed_on, "{k}: {found:?}");
    }
    assert!((found[2] - 0.5 * open).abs() < passed_on + 0.02 * open, "{found:?}");
    assert!(found[1] < passed_on && found[3] < passed_on && found[4] > open - 1.0, "{found:?}");
}

#[test]
fn sky_and_sun_switch_like_lamps_and_the_north_of_the_model_turns_them() {
    let with = |north: f64| {
        let sidecar = format!(
            "[daylight]\nsun = [30, 90]\nsky = \"clear\"\nlux = [50000, 10000]\nground = 0\nnorth = {north}\n"
        );
        solved(&sundial(), &sidecar, 400)
    };
    // The sun in the east, its shadow in the west; with the north turned to +x the sun stands in -y.
    let points = [(DVec3::new(-1.5, 0.0, 0.0), DVec3::Z), (DVec3::new(0.0, 1.5, 0.0), DVec3::Z)];
    let [plain, turned] = [0.0, 90.0].map(|north| lux(&with(north), &points));
    assert!(plain[0] < 0.6 * plain[1] && turned[1] < 0.6 * turned[0], "{plain:?} {turned:?}");
    let solution = with(0.0);
    let names: Vec<&str> = solution.scene.luminaires.iter().map(|lamp| lamp.name.as_str()).collect();
    assert_eq!(names, ["Sky", "Sun"]);
    let mut lighting = solution.scene.lighting();
    lighting.lamps[1].on = false;
    let light = solution.light(&lighting);
    let overcast = solution.irradiance_at(&points[1..], &light)[0];
    let expected = 10_000.0 / lumenwalk::scene::LUMINOUS_EFFICACY;
    assert!((overcast[1] / expected - 1.0).abs() < 0.05, "{overcast:?} for {expected}");
    // What arrives from outside is what the surfaces take up and what leaves again.
    let power = light.power(&solution.mesh, &solution.reflectance, &lighting);
    assert!(power.emitted > power.absorbed && power.absorbed > 0.0, "{power:?}");
}

#[test]
fn bad_daylight_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("model.obj");
    std::fs::write(&path, sundial()).expect("written");
    for (keys, told) in [
        ("sky = \"clear\"", "needs latitude, longitude and zone"),
        ("latitude = 52", "all three"),
        ("latitude = 152\nlongitude = 13\nzone = 1", "152"),
        ("sun = [30, 90]\nsky = \"green\"", "'green'"),
        ("sun = [30, 90]\nsky = \"17\"", "17"),
        ("latitude = 52\nlongitude = 13\nzone = 1\ndate = \"2026-02-30\"", "30"),
        ("latitude = 52\nlongitude = 13\nzone = 1\ntime = \"25:00\"", "25"),
        ("sun = [30, 90]\nground = 2", "ground"),
        ("weather = \"missing.epw\"", "'missing.epw'"),
    ] {
        std::fs::write(folder.path().join("model.toml"), format!("[daylight]\n{keys}\n")).expect("written");
        let error = load(&SceneSource::File(path.clone())).expect_err(keys).to_string();
        assert!(error.contains(told) && error.contains("model.toml"), "{keys}: {error}");
    }
}

/// Daylight factors in per cent at points with normals, and whether they are under another sky than that of the scene.
fn factors(solution: &Solution, points: &[(DVec3, DVec3)]) -> (Vec<f64>, bool) {
    let overcast = solve::Overcast::of(solution, &AtomicBool::new(false)).expect("whole").expect("a sky");
    let light = overcast.solution.light(&overcast.lighting);
    let found = overcast.solution.irradiance_at(points, &light);
    (found.into_iter().map(solve::daylight_factor).collect(), overcast.is_other_sky)
}

/// The room of CIE 171 in another material, with a lamp below its ceiling.
fn lamplit(material: &str, lamp: &str) -> String {
    let mut obj = Obj { text: room(None).replace("black", material), vertices: 0 };
    obj.vertices = obj.text.lines().filter(|line| line.starts_with("v ")).count();
    obj.quad(lamp, [[1.8, 2.2, 2.99], [2.2, 2.2, 2.99], [2.2, 1.8, 2.99], [1.8, 1.8, 2.99]]);
    obj.text
}

#[test]
fn daylight_factors_are_those_of_windows_in_closed_form_whatever_the_sky() {
    // Level with the lower edge of a window of 2 x 1 m, 1 and 2 m before its middle: 3 (I1 + 2 I2) / (7 pi) for each half.
    let points = [1.0, 2.0].map(|y| (DVec3::new(2.0, y, 1.0), DVec3::Z));
    let exact = [200.0 * 0.045_251_375, 200.0 * 0.009_430_276];
    let mut first = None;
    for (sky, is_other) in [
        ("sky = \"overcast\"\nlux = [0, 4000]\nsun = [20, 90]", false),
        ("sky = \"overcast\"\nsky_lamp = { on = false, dimmer = 0.3 }\nsun = [60, 180]", false),
        ("sky = \"12\"\nlux = [75000, 12000]\nsun = [30, 180]", true),
        ("sky = \"16\"\nlux = [5000, 12000]\nsun = [30, 180]", true),
        ("irradiance = [700, 150]\nlatitude = 52\nlongitude = 13\nzone = 1\ntime = \"09:00\"", true),
        ("latitude = 52\nlongitude = 13\nzone = 1\ntime = \"01:00\"", true),
    ] {
        let solution = solved(&room(None), &format!("[daylight]\nground = 0.3\n{sky}\n"), 300);
        let (found, other) = factors(&solution, &points);
        println!("{sky}: {found:.4?}");
        // Parts of the sky are integrated by few directions each.
        assert_near(sky, &found, &exact, 0.008);
        assert_near(sky, &found, first.get_or_insert(found.clone()), 2e-3);
        assert_eq!(other, is_other, "{sky}");
    }
}

#[test]
fn daylight_factors_count_reflections_and_neither_lamps_nor_the_brightness_of_the_sky() {
    let points = [(DVec3::new(2.0, 3.5, 0.8), DVec3::Z), (DVec3::new(0.5, 1.0, 0.8), DVec3::Z)];
    let of = |obj: &str, sky: &str| {
        let (found, _) = factors(&solved(obj, &format!("[daylight]\nground = 0.3\n{sky}\n"), 600), &points);
        println!("{sky}: {found:.4?}");
        found
    };
    let overcast = "sky = \"overcast\"\nlux = [0, 5000]\nsun = [30, 180]";
    let grey = of(&lamplit("grey", "dim"), overcast);
    let brighter = of(&lamplit("grey", "dim"), &overcast.replace("5000", "20000"));
    assert_near("a sky four times as bright", &brighter, &grey, 1e-5);
    let lamp = of(&lamplit("grey", "bright"), overcast);
    // Elements go where it shines.
    assert_near("a lamp a thousand times as bright", &lamp, &grey, 1e-3);
    // By mesh, elements and rows of a clear morning.
    let clear = of(&lamplit("grey", "dim"), "sky = \"clear\"\nlux = [75000, 12000]\nsun = [30, 150]");
    assert_near("a clear sky", &clear, &grey, 0.01);
    // What surfaces reflect is a good part of it at the back.
    let black = of(&lamplit("black", "dim"), overcast);
    assert!(grey[0] > 1.5 * black[0] && black[0] > 0.1, "{grey:?} {black:?}");
}

#[test]
fn without_a_sky_there_are_no_daylight_factors() {
    let solution = solved(&lamplit("grey", "dim"), "", 200);
    assert!(solve::Overcast::of(&solution, &AtomicBool::new(false)).expect("whole").is_none());
}
