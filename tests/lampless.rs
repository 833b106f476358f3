//! Scenes without lamps: shown in even light, nothing solved, and lamps hung where they belong.

mod cli_support;

use glam::DVec3;
use lumenwalk::geometry::{Bvh, Ray};
use lumenwalk::mesh::PatchTarget;
use lumenwalk::scene::{self, Lighting, PlacedLamp, Scene, SceneSource, from_text};
use lumenwalk::session::{Session, Snapshot};
use lumenwalk::solve::{SolveSettings, Stage};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A model of axis-parallel walls, as OBJ text.
#[derive(Default)]
struct Model {
    text: String,
    corners: usize,
}

impl Model {
    fn quad(&mut self, corners: [[f64; 3]; 4]) {
        for [x, y, z] in corners {
            self.text += &format!("v {x} {y} {z}\n");
        }
        let c = self.corners + 1;
        self.text += &format!("f {} {} {} {}\n", c, c + 1, c + 2, c + 3);
        self.corners += 4;
    }

    /// A level rectangle that faces up or down.
    fn level(&mut self, [x0, z0, x1, z1]: [f64; 4], y: f64, up: bool) {
        let mut corners = [[x0, y, z0], [x0, y, z1], [x1, y, z1], [x1, y, z0]];
        if !up {
            corners.reverse();
        }
        self.quad(corners);
    }

    /// A wall from one place of the plan to another, seen from both sides.
    fn wall(&mut self, [x0, z0]: [f64; 2], [x1, z1]: [f64; 2], [low, high]: [f64; 2]) {
        self.quad([[x0, low, z0], [x1, low, z1], [x1, high, z1], [x0, high, z0]]);
    }

    /// Floor, ceiling and four walls, seen from inside or outside.
    fn room(&mut self, plan: [f64; 4], [low, high]: [f64; 2]) {
        let [x0, z0, x1, z1] = plan;
        self.level(plan, low, true);
        self.level(plan, high, false);
        for (from, to) in
            [([x0, z0], [x1, z0]), ([x1, z1], [x0, z1]), ([x0, z1], [x0, z0]), ([x1, z0], [x1, z1])]
        {
            self.wall(from, to, [low, high]);
        }
    }

    fn scene(&self) -> Scene {
        from_text("t", &self.text, "", None).unwrap()
    }
}

/// Two rooms of 4 m x 3 m and 3 m x 3 m side by side, a door of 0.9 m x `door` m between them.
fn two_rooms(door: f64) -> Scene {
    let mut m = Model::default();
    m.room([0.0, 0.0, 7.0, 3.0], [0.0, 2.5]);
    m.wall([4.0, 0.0], [4.0, 1.0], [0.0, 2.5]);
    m.wall([4.0, 1.9], [4.0, 3.0], [0.0, 2.5]);
    if door < 2.5 {
        m.wall([4.0, 1.0], [4.0, 1.9], [door, 2.5]);
    }
    m.scene()
}

fn is_seen(scene: &Scene, from: DVec3, lamp: &PlacedLamp) -> bool {
    let bvh = Bvh::build(&scene.triangles());
    let direction = lamp.position - from;
    !bvh.occluded(&Ray { origin: from, direction }, 0.0, 1.0)
}

/// That it hangs a hand's breadth below the ceiling at most, shines downwards, and gives light.
fn hold_for_a_lamp(lamp: &PlacedLamp, ceiling: f64) {
    let gap = ceiling - lamp.position.y;
    assert!((0.005..0.1).contains(&gap), "{gap} below the ceiling: {lamp:?}");
    assert!(lamp.aim.abs_diff_eq(DVec3::NEG_Y, 1e-12) && lamp.lumens > 100.0, "{lamp:?}");
}

#[test]
fn two_rooms_joined_by_a_door_get_a_lamp_each() {
    for door in [2.0, 2.5] {
        let scene = two_rooms(door);
        let lamps = scene::ceiling_lamps(&scene);
        assert_eq!(lamps.len(), 2, "{lamps:?}");
        for (lamp, middle) in lamps.iter().zip([DVec3::new(2.0, 1.2, 1.5), DVec3::new(5.5, 1.2, 1.5)]) {
            hold_for_a_lamp(lamp, 2.5);
            let off = (lamp.position - middle) * DVec3::new(1.0, 0.0, 1.0);
            assert!(off.length() < 0.2, "in the middle of the room: {lamp:?}");
            assert!(is_seen(&scene, middle, lamp), "{lamp:?}");
        }
        assert_eq!([&*lamps[0].name, &*lamps[1].name], ["Ceiling lamp 1", "Ceiling lamp 2"]);
        // 250 lx on 12 m2 at a utilisation of 0.6.
        assert!((lamps[0].lumens / 5000.0 - 1.0).abs() < 0.1, "{}", lamps[0].lumens);
    }
}

#[test]
fn an_l_shaped_room_is_lit_from_inside_and_a_hall_by_rows() {
    let mut m = Model::default();
    m.level([0.0, 0.0, 5.0, 2.0], 0.0, true);
    m.level([0.0, 2.0, 2.0, 5.0], 0.0, true);
    m.level([0.0, 0.0, 5.0, 2.0], 2.6, false);
    m.level([0.0, 2.0, 2.0, 5.0], 2.6, false);
    let outline = [[0.0, 0.0], [5.0, 0.0], [5.0, 2.0], [2.0, 2.0], [2.0, 5.0], [0.0, 5.0]];
    for k in 0..6 {
        m.wall(outline[k], outline[(k + 1) % 6], [0.0, 2.6]);
    }
    let scene = m.scene();
    let lamps = scene::ceiling_lamps(&scene);
    assert_eq!(lamps.len(), 1, "16 m2: {lamps:?}");
    hold_for_a_lamp(&lamps[0], 2.6);
    let at = lamps[0].position;
    assert!(at.x < 2.0 && at.z < 4.5 || at.z < 2.0, "inside: {at}");
    assert!(is_seen(&scene, DVec3::new(1.0, 1.2, 1.0), &lamps[0]), "from where the arms meet: {at}");

    let mut hall = Model::default();
    hall.room([0.0, 0.0, 12.0, 8.0], [0.0, 4.0]);
    let lamps = scene::ceiling_lamps(&hall.scene());
    assert_eq!(lamps.len(), 4, "96 m2, 4 m high: {lamps:?}");
    for axis in [DVec3::X, DVec3::Z] {
        let mut along: Vec<i64> = lamps.iter().map(|l| (l.position.dot(axis) * 2.0).round() as i64).collect();
        along.sort_unstable();
        along.dedup();
        assert!(along.len() == 2, "in rows: {along:?}");
    }
}

#[test]
fn two_storeys_and_furniture_get_one_lamp_a_storey() {
    let mut m = Model::default();
    m.room([0.0, 0.0, 4.0, 3.5], [0.0, 2.5]);
    m.room([0.0, 0.0, 4.0, 3.5], [2.8, 5.3]);
    // A table and a cupboard below, and walls of 20 cm around all of it.
    m.level([1.0, 1.0, 2.6, 1.8], 0.75, true);
    m.room([3.4, 0.1, 3.9, 1.6], [0.0, 2.0]);
    for (from, to) in [([-0.2, -0.2], [4.2, -0.2]), ([4.2, 3.7], [-0.2, 3.7]), ([-0.2, 3.7], [-0.2, -0.2])] {
        m.wall(from, to, [0.0, 5.5]);
    }
    m.level([-0.2, -0.2, 4.2, 3.7], 5.5, true);
    // And two leaves of a wall with a gap of 0.75 m, closed above.
    m.room([4.4, 0.0, 5.15, 3.5], [0.0, 2.5]);
    let lamps = scene::ceiling_lamps(&m.scene());
    assert_eq!(lamps.len(), 2, "{lamps:?}");
    hold_for_a_lamp(&lamps[0], 2.5);
    hold_for_a_lamp(&lamps[1], 5.3);
}

#[test]
fn without_a_ceiling_lamps_hang_over_the_largest_floor() {
    let mut court = Model::default();
    court.level([0.0, 0.0, 5.0, 4.0], 0.0, true);
    for (from, to) in [([0.0, 0.0], [5.0, 0.0]), ([5.0, 4.0], [0.0, 4.0]), ([0.0, 4.0], [0.0, 0.0])] {
        court.wall(from, to, [0.0, 2.8]);
    }
    let mut plate = Model::default();
    plate.level([0.0, 0.0, 4.0, 4.0], 0.0, true);
    for (model, height) in [(court, 2.0..2.9), (plate, 0.3..3.0)] {
        let lamps = scene::ceiling_lamps(&model.scene());
        assert!(!lamps.is_empty() && lamps[0].name.starts_with("Hanging lamp"), "{lamps:?}");
        assert!(lamps.iter().all(|l| height.contains(&l.position.y)), "{lamps:?}");
        assert!(lamps.iter().all(|l| (0.0..5.0).contains(&l.position.x)), "{lamps:?}");
    }
}

#[test]
fn a_room_drawn_from_outside_a_small_one_and_one_on_its_side_get_theirs() {
    let mut outside = Model::default();
    outside.level([0.0, 0.0, 4.0, 3.0], 0.0, false);
    outside.level([0.0, 0.0, 4.0, 3.0], 2.5, true);
    for (from, to) in [([0.0, 0.0], [4.0, 0.0]), ([4.0, 3.0], [0.0, 3.0]), ([0.0, 3.0], [0.0, 0.0])] {
        outside.wall(from, to, [0.0, 2.5]);
    }
    let lamps = scene::ceiling_lamps(&outside.scene());
    assert_eq!(lamps.len(), 1, "{lamps:?}");
    hold_for_a_lamp(&lamps[0], 2.5);

    let mut unit = Model::default();
    unit.room([0.0, 0.0, 1.0, 1.0], [0.0, 1.0]);
    let lamps = scene::ceiling_lamps(&unit.scene());
    assert!(lamps.len() == 1 && lamps[0].size[0] < 0.3, "a box of one metre: {lamps:?}");
    hold_for_a_lamp(&lamps[0], 1.0);

    let mut room = Model::default();
    room.room([0.0, 0.0, 4.0, 3.0], [0.0, 2.5]);
    let upright: String = room
        .text
        .lines()
        .map(|line| match line.split_whitespace().collect::<Vec<_>>()[..] {
            ["v", x, y, z] => format!("v {x} {z} {y}\n"),
            _ => format!("{line}\n"),
        })
        .collect();
    let lying = from_text("t", &upright, "", Some("up = \"z\"\n")).unwrap();
    let lamps = scene::ceiling_lamps(&lying);
    assert_eq!(lamps.len(), 1, "{lamps:?}");
    assert!((lamps[0].position.z - 2.475).abs() < 1e-6 && lamps[0].aim.z == -1.0, "{lamps:?}");
}

fn wait_for(session: &Session, what: &str, done: impl Fn(&Snapshot) -> bool) -> Arc<Snapshot> {
    for _ in 0..6000 {
        let snapshot = session.latest();
        if done(&snapshot) {
            return snapshot;
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    panic!("{what} never came: {:?}", session.latest().stage);
}

fn write(folder: &Path, text: &str) -> SceneSource {
    let path = folder.join("room.obj");
    std::fs::write(&path, text).unwrap();
    SceneSource::File(path)
}

#[test]
fn nothing_is_solved_in_the_dark_until_there_is_a_lamp_or_it_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let mut m = Model::default();
    m.room([0.0, 0.0, 4.0, 3.0], [0.0, 2.5]);
    let session = Session::spawn(|| {}).unwrap();
    let settings = SolveSettings { patches: PatchTarget::Count(200), ..SolveSettings::default() };
    session.set_settings(settings);
    session.open(write(folder.path(), &m.text));
    let dark = wait_for(&session, "the scene", |s| s.stage == Stage::Unlit);
    assert_eq!(dark.rows.0, 0, "no row");
    assert!(dark.transport().is_none() && dark.bases().is_none() && dark.solved().is_none());
    assert!(dark.last_change.is_some_and(|done| done.unlit), "{:?}", dark.last_change);
    // Rows are there for whoever looks into a patch.
    let computer = dark.computer().cloned().unwrap();
    assert!((computer.row(0, &mut computer.scratch()).sum() - 1.0).abs() < 0.01);

    // Other settings and materials do not begin a solve either.
    session.set_materials(dark.scene().unwrap(), Vec::new());
    let serial = dark.serial;
    let still = wait_for(&session, "an answer", |s| s.serial > serial && s.stage == Stage::Unlit);
    assert!(still.transport().is_none());

    // With a lamp it is solved, without it is dark again, with the scene as it was read.
    let read = dark.read.clone().unwrap();
    let lamps = scene::ceiling_lamps(&read);
    session.set_lamps(&read, lamps.clone());
    let lit = wait_for(&session, "light", |s| s.stage == Stage::Converged);
    let solved = lit.solved().expect("solved");
    assert_eq!(solved.scene.placed, lamps);
    assert!(Arc::ptr_eq(lit.read.as_ref().unwrap(), &read));
    let light = solved.light(&solved.scene.lighting());
    let floor = solved.mesh.patches.iter().position(|p| p.normal.y > 0.9 && p.centre.y < 0.1).unwrap();
    let lux = scene::illuminance(light.irradiance[floor].map(f64::from));
    assert!((50.0..1000.0).contains(&lux), "{lux} lx on the floor");
    session.set_lamps(&read, Vec::new());
    let dark = wait_for(&session, "the dark", |s| s.stage == Stage::Unlit);
    assert!(Arc::ptr_eq(dark.scene().unwrap(), &read) && dark.transport().is_none());

    // Asked for, form factors come without light.
    session.resume();
    let asked = wait_for(&session, "form factors", |s| s.stage == Stage::Converged);
    assert!(asked.transport().is_some() && asked.rows.0 == asked.mesh().unwrap().patches.len());
}

#[test]
fn placed_lamps_are_kept_by_the_sidecar() {
    let folder = tempfile::tempdir().unwrap();
    let mut m = Model::default();
    m.room([0.0, 0.0, 4.0, 3.0], [0.0, 2.5]);
    let source = write(folder.path(), &m.text);
    let scene = scene::load(&source).unwrap();
    let lit = scene.with_placed(scene::ceiling_lamps(&scene));
    let Lighting { lamps } = lit.lighting();
    assert_eq!(lamps.len(), 1);
    scene::write_sidecar(&folder.path().join("room.toml"), &lit, &lit.lighting(), &[]).unwrap();
    let again = scene::load(&source).unwrap();
    assert_eq!(again.luminaires[0].name, "Ceiling lamp");
    let (a, b) = (&again.placed[0], &lit.placed[0]);
    assert!(a.position.abs_diff_eq(b.position, 1e-6) && a.aim == b.aim && a.lumens == b.lumens);
    // A mended copy holds the model alone; its sidecar brings the lamp back.
    let mended = scene::mend(&again, &folder.path().join("copy.obj")).unwrap();
    assert_eq!(mended.obj.matches("\nf ").count(), 6, "{}", mended.obj);
    let copy = from_text("copy", &mended.obj, "", mended.sidecar.as_deref()).unwrap();
    assert_eq!(copy.luminaires.len(), 1);
}

/// The room of the command line's tests without its lamp.
fn dark_place() -> cli_support::Workplace {
    let place = cli_support::Workplace::with_room(0.5);
    let obj = place.text("room.obj");
    place.put("room.obj", obj.split("o desk_lamp").next().unwrap());
    let toml = place.text("room.toml");
    place.put("room.toml", toml.split("[[luminaire]]").next().unwrap());
    place
}

#[test]
fn the_command_line_says_at_once_that_there_is_no_lamp_and_shows_the_model() {
    let place = dark_place();
    let arguments = ["solve", "room.obj", "--patches", "300", "--size", "64x40"];
    let outputs = ["--image", "a.png", "--report", "r.json", "--patch-table", "t.csv", "--audit"];
    let output = place.run(&[&arguments[..], &outputs[..]].concat());
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{complaint}");
    assert!(complaint.contains("room has no lamps") && complaint.contains("--ceiling-lamps"), "{complaint}");
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("no lamps, so nothing was solved") && !told.contains("sweep"), "{told}");
    assert!(place.text("r.json").contains("\"entries\": 0"), "no form factor: {}", place.text("r.json"));
    let table = place.text("t.csv");
    assert!(table.lines().count() > 100 && table.lines().skip(1).all(|line| line.contains(",0")), "{table}");

    // The picture is legible, and its faces differ.
    let image = image::open(place.path("a.png")).unwrap().to_rgb8().into_raw();
    let mean = image.iter().map(|&p| f64::from(p)).sum::<f64>() / image.len() as f64;
    assert!(mean > 80.0, "{mean}");
    let (low, high) = (image.iter().min().unwrap(), image.iter().max().unwrap());
    assert!(high - low > 40, "{low} to {high}");
}

#[test]
fn every_output_is_written_in_the_dark() {
    let place = dark_place();
    let second = "[[view]]\nname = \"Corner\"\neye = [500, 1000, 500]\ntarget = [1000, 900, 1900]\n";
    place.put("room.toml", &(place.text("room.toml") + second));
    place.put("p.csv", "1000,1000,1000,0,1,0\n500,10,500,0,1,0\n");
    let arguments = ["solve", "room.obj", "--size", "32x20", "--points", "p.csv"];
    let outputs = ["--irradiance", "i.csv", "--mesh", "m.ply", "--image", "a.exr", "--report", "r.json"];
    for goal in [&[][..], &["--error", "5%"], &["--budget", "1s"], &["--tour", "tour", "--fps", "1"]] {
        place.succeed(&[&arguments[..], &outputs[..], goal].concat());
    }
    let lines = place.text("i.csv");
    assert_eq!(lines.lines().count(), 3, "{lines}");
    assert!(
        lines.lines().skip(1).all(|line| line.ends_with(",0,0,0,0,0")),
        "no light, and no error: {lines}"
    );
    assert!(place.text("r.json").contains("\"points\""));
    assert!(place.path("m.ply").exists() && place.path("a.exr").exists() && place.path("tour").exists());
}

#[test]
fn ceiling_lamps_are_added_by_an_option() {
    let place = dark_place();
    let arguments = ["solve", "room.obj", "--ceiling-lamps", "--patches", "300", "--report", "r.json"];
    let output = place.run(&arguments);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(0), "{complaint}");
    assert!(complaint.contains("1 lamp added to room") && !complaint.contains("no lamps"), "{complaint}");
    assert!(place.text("r.json").contains("Ceiling lamp"));
    let told = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(told.contains("1 lamp,") && told.contains("sweep"), "{told}");
    // The files of the model are left alone.
    assert!(!place.text("room.toml").contains("lamp"));

    for command in ["check", "plan"] {
        let told = place.run(&[command, "room.obj", "--ceiling-lamps"]);
        assert_eq!(told.status.code(), Some(0));
        assert!(!String::from_utf8_lossy(&told.stdout).contains("has no lamp"));
    }
    let told = place.succeed(&["check", "room.obj"]);
    assert!(told.contains("this scene has no lamp") && told.contains("--ceiling-lamps"), "{told}");
    let sentence = place.fail(2, &["accuracy", "room.obj", "--out", "."]);
    assert!(sentence.contains("has no lamps") && sentence.contains("--ceiling-lamps"), "{sentence}");

    // All off is dark as it was meant, and said.
    let off = [&arguments[..5], &["--off", "Ceiling lamp"]].concat();
    let output = place.run(&off);
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && complaint.contains("all lamps of room are off"), "{complaint}");
}
