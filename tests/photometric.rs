//! Lamps that shine by photometric files: what arrives at points and in rooms, and what sidecars say of them.

mod common;

use common::settings;
use glam::DVec3;
use lumenwalk::accuracy::AuditSettings;
use lumenwalk::direct::{DirectLight, Scratch};
use lumenwalk::form_factors::Method;
use lumenwalk::mesh::{self, MeshSettings, PatchTarget};
use lumenwalk::scene::{
    LUMINOUS_EFFICACY, Scene, SceneSource, load, lumens, luminance_weighted, write_sidecar,
};
use lumenwalk::solve::Solution;
use lumenwalk::solver::photometric_power;
use lumenwalk::study;
use std::sync::Arc;

/// The two files of the tests: round with five-degree steps, 1462 lm; and one-sided with 24 half-planes, 494 lm.
const DOWNLIGHT: &str = include_str!("data/downlight.ies");
const WASHER: &str = include_str!("data/washer.ies");

/// A floor of 40 x 40 m, black, 10 m below the origin; z is up.
const FLOOR: &str = "mtllib m.mtl\no floor\nusemtl black\nv -20 -20 -10\nv 20 -20 -10\nv 20 20 -10\nv -20 20 -10\nf 1 2 3 4\n";
/// A room of 4 x 3 x 5 m, y up, with a block in it and a flat lamp of 1.2 x 0.1 m below its ceiling.
const ROOM: &str = "mtllib m.mtl\no room\nusemtl paint\n\
    v 0 0 0\nv 4 0 0\nv 4 0 5\nv 0 0 5\nv 0 3 0\nv 4 3 0\nv 4 3 5\nv 0 3 5\n\
    f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n\
    o block\nv 2.6 0 1\nv 3.4 0 1\nv 3.4 0 2.2\nv 2.6 0 2.2\nv 2.6 0.9 1\nv 3.4 0.9 1\nv 3.4 0.9 2.2\nv 2.6 0.9 2.2\n\
    f 13 16 15 14\nf 9 13 14 10\nf 10 14 15 11\nf 11 15 16 12\nf 12 16 13 9\n\
    o bar\nusemtl glow\nv 1.4 2.99 2.45\nv 2.6 2.99 2.45\nv 2.6 2.99 2.55\nv 1.4 2.99 2.55\nf 17 18 19 20\n";
const MTL: &str = "newmtl black\nKd 0 0 0\nnewmtl paint\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0 0 0\nKe 3 3 3\n";

/// A file of one plane of `candela(gamma in degrees)` in steps of half a degree down to the horizon, with this width
/// and length of its opening, metres.
fn file(candela: impl Fn(f64) -> f64, opening: [f64; 2]) -> String {
    let gammas: Vec<f64> = (0..=180).map(|k| 0.5 * f64::from(k)).collect();
    let words = |values: Vec<f64>| values.iter().map(|v| format!("{v:.6}")).collect::<Vec<_>>().join("\n");
    let [width, length] = opening;
    format!(
        "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 181 1 1 2 {width} {length} 0\n1 1 10\n{}\n0\n{}\n",
        words(gammas.clone()),
        words(gammas.into_iter().map(candela).collect())
    )
}

fn cosine(gamma: f64) -> f64 {
    1000.0 * gamma.to_radians().cos().max(0.0)
}

/// A model in a folder of its own.
struct Site {
    folder: tempfile::TempDir,
}

impl Site {
    fn new(obj: &str, sidecar: &str) -> Self {
        let site = Self { folder: tempfile::tempdir().expect("a folder") };
        for (name, text) in [("m.obj", obj), ("m.mtl", MTL), ("m.toml", sidecar)] {
            site.write(name, text);
        }
        for (name, text) in [("downlight.ies", DOWNLIGHT), ("washer.ies", WASHER)] {
            site.write(name, text);
        }
        site
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }

    fn read(&self) -> Result<Scene, String> {
        load(&SceneSource::File(self.path("m.obj"))).map_err(|error| error.to_string())
    }

    fn scene(&self) -> Arc<Scene> {
        Arc::new(self.read().unwrap_or_else(|error| panic!("{error}")))
    }
}

/// A scene of the floor and this lamp's entry in z up.
fn over_the_floor(entry: &str, files: &[(&str, String)]) -> Arc<Scene> {
    let site = Site::new(FLOOR, &format!("up = \"z\"\n[[lamp]]\nname = \"Lamp\"\n{entry}\n"));
    files.iter().for_each(|(name, text)| site.write(name, text));
    site.scene()
}

/// Illuminance at points with normals straight from the lamps at full output, lux.
fn direct(scene: &Scene, points: &[(DVec3, DVec3)]) -> Vec<f64> {
    let meshed = MeshSettings { target: PatchTarget::Count(100), ..MeshSettings::default() };
    let mesh = mesh::build(scene, &meshed).expect("a mesh");
    let light = DirectLight::new(&mesh, true);
    let mut scratch = Scratch::default();
    let at = |&(point, normal): &(DVec3, DVec3)| {
        let mut sum = 0.0;
        light.at(point, normal, true, &mut scratch, |basis, value| {
            let basis = light.emitters().bases[basis as usize];
            let exitance = scene.luminaires[basis.lamp as usize].initial.exitance;
            sum += LUMINOUS_EFFICACY * luminance_weighted(exitance) * value;
        });
        sum
    };
    points.iter().map(at).collect()
}

fn close(what: &str, found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let off = found / expected - 1.0;
        assert!(off.abs() < tolerance, "{what} {k}: {found} for {expected}, {:+.4} %", 100.0 * off);
    }
}

const HUNG: &str = "position = [0, 0, 3]\n";

#[test]
fn files_light_points_as_two_independent_quadratures_say() {
    // The downlight as a point; the washer as a point and as a rectangle of 1.2 x 0.1 m, each point of which sends
    // the same share of the intensity.
    let point = |text: &str, opening: &str| text.replace(opening, " 0 0 0\n");
    let round = over_the_floor(
        &format!("{HUNG}photometry = \"p.ies\""),
        &[("p.ies", point(DOWNLIGHT, " -0.12 -0.12 0\n"))],
    );
    let at = |x: f64, y: f64, z: f64, normal: DVec3| (DVec3::new(x, y, z), normal);
    let found = direct(
        &round,
        &[
            at(0.0, 0.0, 0.0, DVec3::Z),
            at(1.0, 0.0, 0.0, DVec3::Z),
            at(0.0, 2.0, 0.0, DVec3::Z),
            at(1.5, 0.0, 1.2, DVec3::NEG_X),
        ],
    );
    close("downlight", &found, &[114.0, 82.93789, 37.71802, 53.67176], 2e-6);
    let places = [
        at(0.0, 0.0, 0.0, DVec3::Z),
        at(0.0, 0.8, 1.5, DVec3::NEG_Y),
        at(1.0, 0.8, 1.5, DVec3::NEG_Y),
        at(-1.0, 0.8, 1.5, DVec3::NEG_Y),
        at(0.0, -1.0, 0.0, DVec3::Z),
    ];
    let washer =
        over_the_floor(&format!("{HUNG}photometry = \"p.ies\""), &[("p.ies", point(WASHER, " 0.1 1.2 0\n"))]);
    let as_point = [18.07111, 86.50703, 19.02014, 13.87050, 10.00851];
    close("washer as a point", &direct(&washer, &places), &as_point, 2e-6);
    let washer = over_the_floor(&format!("{HUNG}photometry = \"washer.ies\""), &[]);
    close("washer", &direct(&washer, &places), &[17.1545, 69.021, 24.467, 19.803, 9.721], 1e-3);
    // Turned by a quarter, it lights what is turned about it by a quarter.
    let turned = over_the_floor(&format!("{HUNG}photometry = \"washer.ies\"\nturn = 90"), &[]);
    let quarter = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
    let around: Vec<(DVec3, DVec3)> = places.iter().map(|&(p, n)| (quarter(p), quarter(n))).collect();
    close("turned", &direct(&turned, &around), &direct(&washer, &places), 1e-9);
    assert!((direct(&turned, &places)[1] / 69.021 - 1.0).abs() > 0.1);
    // Swung to the side it lights the wall as it lit the floor: tilted towards C90, or aimed there.
    for swing in ["tilt = 90", "aim = [0, 1, 0]"] {
        let swung = over_the_floor(&format!("{HUNG}photometry = \"washer.ies\"\n{swing}"), &[]);
        let to_wall = |v: DVec3| DVec3::new(v.x, -v.z, v.y);
        let of = |&(p, n): &(DVec3, DVec3)| (to_wall(p - DVec3::Z * 3.0) + DVec3::Z * 3.0, to_wall(n));
        let around: Vec<(DVec3, DVec3)> = places.iter().map(of).collect();
        close(swing, &direct(&swung, &around), &direct(&washer, &places), 1e-9);
    }
}

#[test]
fn points_and_areas_are_those_of_cie_171() {
    // 5.2: 1000 cd by the cosine from a point 3 m above.
    let lamp = [("p.ies", file(cosine, [0.0, 0.0])), ("a.ies", file(cosine, [1.0, 1.0]))];
    let scene = over_the_floor(&format!("{HUNG}photometry = \"p.ies\""), &lamp);
    let floor = |x: f64, y: f64| (DVec3::new(x, y, 0.0), DVec3::Z);
    let places = [floor(0.0, 0.0), floor(0.5, 0.0), floor(1.0, 0.0), floor(1.5, 1.5)];
    close("5.2", &direct(&scene, &places), &[111.111, 105.186, 90.0, 49.383], 1e-4);
    // 5.3: one square metre by Lambert's law in the middle of a ceiling of 4 x 4 m, 3 m above the floor.
    let scene = over_the_floor("position = [2, 2, 3]\nphotometry = \"a.ies\"", &lamp);
    let wall = |z: f64| (DVec3::new(0.0, 2.0, z), DVec3::X);
    let places = [
        wall(2.75),
        wall(2.25),
        wall(1.75),
        floor(0.25, 2.0),
        floor(0.75, 2.0),
        floor(1.25, 2.0),
        floor(1.75, 2.0),
    ];
    let exact = [32.67, 75.18, 81.34, 61.42, 79.26, 95.66, 105.78];
    close("5.3", &direct(&scene, &places), &exact, 5e-4);
    let published = [32.68, 75.09, 81.38, 61.27, 79.18, 95.52, 105.89];
    close("5.3 as published", &direct(&scene, &places), &published, 3e-3);
}

#[test]
fn arrays_add_up_and_kinds_of_the_program_give_their_lumens() {
    let one = |x: f64, y: f64| {
        over_the_floor(&format!("position = [{x}, {y}, 3]\nphotometry = \"washer.ies\"\nturn = 20"), &[])
    };
    let array = over_the_floor(
        &format!("{HUNG}photometry = \"washer.ies\"\nturn = 20\narray = [2, 3]\nspacing = [1.5, 2]"),
        &[],
    );
    assert!((lumens(&array)[0][0] / 6.0 - lumens(&one(0.0, 0.0))[0][0]).abs() < 1e-6);
    let places: Vec<(DVec3, DVec3)> =
        (0..5).map(|k| (DVec3::new(f64::from(k) - 2.0, 0.3, 0.0), DVec3::Z)).collect();
    let mut sums = vec![0.0; places.len()];
    for (x, y) in [(-2.0, 0.75), (0.0, 0.75), (2.0, 0.75), (-2.0, -0.75), (0.0, -0.75), (2.0, -0.75)] {
        for (sum, value) in sums.iter_mut().zip(direct(&one(x, y), &places)) {
            *sum += value;
        }
    }
    close("array", &direct(&array, &places), &sums, 1e-9);
    for kind in ["panel", "downlight", "pendant", "spot", "wall-washer"] {
        let scene = over_the_floor(&format!("{HUNG}kind = \"{kind}\"\nlumens = 1500"), &[]);
        assert!((lumens(&scene)[0][0] - 1500.0).abs() < 1e-6, "{kind}");
        // Through a floor wide enough for almost all that goes down.
        let at = |k: i32| f64::from(k) - 19.5;
        let grid: Vec<(DVec3, DVec3)> =
            (0..1600).map(|k| (DVec3::new(at(k % 40), at(k / 40), -1.0), DVec3::Z)).collect();
        let flux: f64 = direct(&scene, &grid).iter().sum();
        let down = if kind == "pendant" { 0.5..0.75 } else { 0.93..1.02 };
        assert!(down.contains(&(flux / 1500.0)), "{kind}: {flux} lm of 1500 come down");
    }
}

fn solved(scene: &Arc<Scene>) -> Solution {
    common::solved(scene, &settings(PatchTarget::Count(1200), Method::Lines, 96))
}

const HANGING: &str = "[[lamp]]\nname = \"Round\"\nposition = [1, 2.98, 1.5]\nphotometry = \"downlight.ies\"\n\
    [[lamp]]\nname = \"Globe\"\nposition = [3, 2, 3.5]\nkind = \"pendant\"\nlumens = 900\n\
    [[luminaire]]\nobject = \"bar\"\nname = \"Bar\"\nphotometry = \"washer.ies\"\n";

#[test]
fn in_a_closed_room_the_flux_of_every_lamp_arrives_and_is_absorbed() {
    let scene = Site::new(ROOM, HANGING).scene();
    let names: Vec<&str> = scene.luminaires.iter().map(|lamp| lamp.name.as_str()).collect();
    assert_eq!(names, ["Bar", "Round", "Globe"]);
    let fluxes: Vec<f64> = lumens(&scene).iter().map(|flux| flux[0]).collect();
    close("flux", &fluxes, &[494.0505, 1462.0397, 900.0], 1e-6);
    let solved = solved(&scene);
    let light = solved.element_light.as_ref().expect("elements");
    // Before anything is scaled.
    let means = light.elements.patch_means(&solved.mesh, light.bases.len());
    for (k, basis) in light.bases.iter().enumerate() {
        let given =
            |(i, patch): (usize, &mesh::Patch)| patch.area * f64::from(means[i * light.bases.len() + k]);
        let arrived: f64 =
            solved.mesh.patches.iter().enumerate().filter(|(_, patch)| !patch.buried).map(given).sum();
        let sent = scene.luminaires[basis.lamp as usize].area;
        let share = arrived / sent;
        println!("{}: {share:.5} of the flux arrives", scene.luminaires[basis.lamp as usize].name);
        assert!((share - 1.0).abs() < 5e-3, "{share}");
    }
    let last = solved.sweeps.last().expect("swept");
    let watts = fluxes.iter().sum::<f64>() * 3.0 / LUMINOUS_EFFICACY;
    close("power", &[last.emitted, last.absorbed], &[watts, watts], 1e-4);
    let lighting = scene.lighting();
    let power = solved.light(&lighting).power(&solved.mesh, &solved.reflectance, &lighting);
    close("power as shown", &[power.emitted, power.absorbed], &[watts, watts], 1e-4);
    assert!((photometric_power(&solved.mesh, &lighting) / watts - 1.0).abs() < 1e-9);
    // Dimmed, it is a share.
    let mut dimmed = lighting.clone();
    dimmed.lamps.iter_mut().for_each(|lamp| lamp.dimmer = 0.3);
    let at = |lighting| -> Vec<f64> {
        let light = solved.light(lighting);
        let floor = [(DVec3::new(2.0, 0.0, 2.5), DVec3::Y), (DVec3::new(1.0, 0.0, 1.0), DVec3::Y)];
        solved.irradiance_at(&floor, &light).into_iter().map(luminance_weighted).collect()
    };
    let full: Vec<f64> = at(&lighting).into_iter().map(|h| 0.3 * h).collect();
    close("dimmed", &at(&dimmed), &full, 1e-5);
}

#[test]
fn glowing_faces_keep_their_look_and_light_as_a_bare_luminaire_in_their_place_does() {
    let mesh_lamp =
        solved(&Site::new(ROOM, "[[luminaire]]\nobject = \"bar\"\nphotometry = \"washer.ies\"\n").scene());
    let without_bar = &ROOM[..ROOM.find("o bar").expect("the lamp")];
    let bare = "[[lamp]]\nname = \"Bar\"\nposition = [2, 2.99, 2.5]\nphotometry = \"washer.ies\"\n";
    let bare = solved(&Site::new(without_bar, bare).scene());
    let points: Vec<(DVec3, DVec3)> = (0..12)
        .map(|k| (DVec3::new(0.4 + 0.25 * f64::from(k), 0.0, 0.5 + 0.3 * f64::from(k)), DVec3::Y))
        .filter(|(p, _)| !(2.5..3.5).contains(&p.x) || !(0.9..2.3).contains(&p.z))
        .chain((0..6).map(|k| (DVec3::new(0.4 + 0.6 * f64::from(k), 1.4, 0.0), DVec3::Z)))
        .collect();
    let at = |solved: &Solution| -> Vec<f64> {
        let light = solved.light(&solved.scene.lighting());
        solved.irradiance_at(&points, &light).into_iter().map(luminance_weighted).collect()
    };
    close("as bare", &at(&mesh_lamp), &at(&bare), 0.02);
    let light = mesh_lamp.light(&mesh_lamp.scene.lighting());
    let glow = LUMINOUS_EFFICACY / 494.0505 * 0.12;
    for (patch, radiosity) in mesh_lamp.mesh.patches.iter().zip(&light.radiosity) {
        if patch.luminaire.is_some() {
            assert!((f64::from(radiosity[1]) * glow - 1.0).abs() < 1e-4, "{radiosity:?}");
        }
    }
}

#[test]
fn the_independent_witness_sees_the_same_lamps() {
    let scene = Site::new(ROOM, HANGING).scene();
    let solved = solved(&scene);
    let asked =
        AuditSettings { receivers: 192, precision: 0.5, seconds: f64::INFINITY, ..AuditSettings::default() };
    let found = study::audit(&solved, &scene.lighting(), &asked, &|| false).expect("lit").budget;
    let percent = |error: f64| 100.0 * error;
    println!("{:.2} %, patch averages {:.2} %", percent(found.total.error), percent(found.averages.error));
    assert!(found.averages.error < 0.006, "patch averages are off by {}", found.averages.error);
    assert!(found.total.error < 0.015, "the picture is off by {}", found.total.error);
}

#[test]
fn sidecars_keep_photometry_when_they_are_written_again() {
    let site = Site::new(
        ROOM,
        &format!(
            "{HANGING}turn = 15\ntilt = -5\naim = [0, -1, 0.1]\n[[lamp]]\nname = \"Row\"\nposition = [2, 2.5, 2.5]\n\
            kind = \"wall-washer\"\nturn = 90\narray = [1, 3]\nspacing = [0, 1]\nlumens = 700\n"
        ),
    );
    let first = site.scene();
    let mut lighting = first.lighting();
    lighting.lamps[0].dimmer = 0.5;
    write_sidecar(&site.path("m.toml"), &first, &lighting, &[]).expect("written");
    let text = std::fs::read_to_string(site.path("m.toml")).expect("there");
    let again = site.scene();
    assert_eq!(again.placed, first.placed, "{text}");
    assert_eq!(again.lighting(), lighting, "{text}");
    for (before, after) in first.luminaires.iter().zip(&again.luminaires) {
        assert_eq!((&before.name, &before.photometric), (&after.name, &after.photometric), "{text}");
    }
    assert!(!text.contains("lumens = 1462"), "the flux stays the file's:\n{text}");
    write_sidecar(&site.path("m.toml"), &again, &lighting, &[]).expect("written");
    assert_eq!(std::fs::read_to_string(site.path("m.toml")).expect("there"), text);
}

#[test]
fn what_is_wrong_with_a_file_or_an_entry_is_told_in_a_sentence() {
    let broken = DOWNLIGHT.replace("859.60", "859,6O");
    for (entry, expected) in [
        (
            "photometry = \"none.ies\"",
            "line 5: the lamp 'Lamp' asks for the photometric file 'none.ies', but there is no such file",
        ),
        ("photometry = \"broken.ies\"", "broken.ies, line 16"),
        ("photometry = \"dark.ies\"", "is dark"),
        ("photometry = \"m.mtl\"", "neither IES LM-63"),
        ("photometry = \"washer.ies\"\nkind = \"spot\"", "both kind and photometry"),
        ("photometry = \"washer.ies\"\nsize = [1, 1]", "remove size"),
        ("photometry = \"washer.ies\"\nturn = nan", "between -360 and 360"),
        ("lumens = 5\nturn = 10", "which panels do not have"),
        ("kind = \"spot\"", "needs its lumens"),
        ("lumens = 5\narray = [2, 2]", "without spacing"),
        ("lumens = 5\narray = [0, 2]\nspacing = [1, 1]", "1 to 1000 lamps"),
        ("lumens = 5\narray = [2, 2]\nspacing = [-1, 1]", "spacing of two lengths"),
        ("kind = \"sun\"\nlumens = 5", "unknown variant"),
    ] {
        let sidecar = format!("up = \"z\"\n# A lamp.\n\n[[lamp]]\nname = \"Lamp\"\n{HUNG}{entry}\n");
        let site = Site::new(FLOOR, &sidecar);
        site.write("broken.ies", &broken);
        site.write("dark.ies", &file(|_| 0.0, [0.1, 0.1]));
        let message = site.read().expect_err(entry);
        assert!(message.contains(expected) && message.contains("m.toml, line "), "{entry}: {message}");
        assert_eq!(message.lines().count(), 1, "{message}");
    }
    for (entry, expected) in [
        ("photometry = \"none.ies\"", "the luminaire 'Bar' asks for the photometric file 'none.ies'"),
        ("turn = 10", "only lamps with photometry have"),
        ("photometry = \"washer.ies\"\naim = [0, 0, 0]", "must have an aim"),
    ] {
        let site = Site::new(ROOM, &format!("[[luminaire]]\nobject = \"bar\"\n{entry}\n"));
        let message = site.read().expect_err(entry);
        assert!(message.contains(expected) && message.contains("m.toml, line 1"), "{entry}: {message}");
    }
    // What is doubtful about a file is told with the scene.
    let site =
        Site::new(FLOOR, &format!("up = \"z\"\n[[lamp]]\nname = \"Lamp\"\n{HUNG}photometry = \"odd.ies\"\n"));
    site.write("odd.ies", &DOWNLIGHT.replace("1 1924 1.2", "1 500 1.2"));
    let findings = site.scene().findings.clone();
    assert!(
        findings.iter().any(|f| f.message.contains("'odd.ies': the intensities give 1462 lm")),
        "{findings:?}"
    );
}
