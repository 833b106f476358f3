//! Whether a model lies on its side, and whether it is in the unit that it is read in.
//!
//! OBJ files say neither. What speaks for a unit is the height of the rooms; for an axis see
//! [`super::up_axis`].

use super::extent::Extent;
use super::finding::{Finding, FindingKind, Severity};
use super::space::Space;
use super::types::{FrameChoice, LengthUnit, Scene, SceneSource, UpAxis};
use super::up_axis::up_evidence;
use glam::DVec3;
use std::ops::RangeInclusive;

/// Rooms are this high, metres.
const ROOM_HEIGHT: RangeInclusive<f64> = 2.0..=4.5;
/// Lower and higher ones make one doubt the unit.
const BELIEVABLE_ROOM: RangeInclusive<f64> = 0.3..=6.5;
/// Rooms of this height are halls in metres, or rooms in feet.
const HALL_OR_FEET: RangeInclusive<f64> = 6.5..=14.0;
/// Higher ones are none of either.
const HIGHEST_HALL: f64 = 20.0;
/// Houses are this high, metres.
const HOUSE_HEIGHT: RangeInclusive<f64> = 2.0..=15.0;
/// Heights that models have on purpose, metres.
const BELIEVABLE_HEIGHT: RangeInclusive<f64> = 0.3..=60.0;
/// Beyond these extents a model is no building, metres.
const BELIEVABLE_EXTENT: RangeInclusive<f64> = 1e-4..=1e5;

/// What a model is taken for.
pub(super) struct Judgement {
    /// What to tell, worst first.
    pub(super) findings: Vec<Finding>,
    /// Metres of the model to one of an adult, above zero.
    pub(super) scale: f64,
    /// Which way up it is to be looked at.
    pub(super) up: UpAxis,
}

/// Judges a scene whose unit and up axis were `stated` by its sidecar or by the user: what is stated is
/// not doubted, unless it makes a thing of the size of an atom or of a country. Where a model lies on its side and nobody
/// has written a sidecar for it, so that it `may_be_turned`, it is set upright.
pub(super) fn judge(
    scene: &Scene,
    extent: &Extent,
    space: &Space,
    stated: FrameChoice,
    may_be_turned: bool,
) -> Judgement {
    let lies = stated.up.is_none().then(|| up_evidence(scene, extent)).and_then(|e| e.proposal());
    let up = if lies.is_some() { UpAxis::Z } else { scene.up };
    let room = space.headroom(up.vector());
    let unit = doubted_unit(scene, extent, space, stated, up, room);

    let mut findings = Vec::new();
    let proposed = unit.as_ref().and_then(|doubt| doubt.proposal);
    let is_turned = may_be_turned && lies.is_some();
    let looked_at = if is_turned { up } else { scene.up };
    if let Some(reasons) = lies.as_ref().filter(|_| is_turned) {
        let message = format!(
            "z was taken for up: {reasons}; if y is up, say so: {}",
            how_to(scene, "Y is up", "--up y", "up = \"y\"")
        );
        findings.push(
            Finding::new(FindingKind::UpAxis, Severity::Note, message)
                .with("light is the same either way; only views and walking ask which way is up")
                .remedied(scene.unit, UpAxis::Y),
        );
    } else if let Some(reasons) = lies {
        let message = format!(
            "the model seems to lie on its side: {reasons}; if so, choose z up: {}",
            how_to(scene, "Z is up", "--up z", "up = \"z\"")
        );
        findings.push(
            Finding::new(FindingKind::UpAxis, Severity::Warning, message)
                .with("light is the same either way; only views and walking take +y for up")
                .remedied(proposed.unwrap_or(scene.unit), UpAxis::Z),
        );
    }
    if let Some(doubt) = unit {
        let finding = Finding::new(FindingKind::Unit, doubt.severity, doubt.message)
            .with("lux stay the same in a model of any size, if lamps are given by Ke; lumens do not");
        findings.push(match doubt.proposal {
            Some(unit) => finding.remedied(unit, up),
            None => finding,
        });
    }
    // 1. In the unit proposed, people are people. 2. In the one that is, unless no room fits them.
    let adult = match proposed {
        Some(unit) => scene.unit.metres() / unit.metres(),
        None => 1.0,
    };
    let here = if up == looked_at { room } else { space.headroom(looked_at.vector()) };
    let tall = extent.main.size().dot(looked_at.vector());
    let scale = match here {
        Some(room) if room > HIGHEST_HALL * adult => 0.25 * room,
        _ if tall > 0.0 => adult.min(tall / 2.4),
        _ => 0.25 * extent.main.diagonal(),
    };
    let scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
    Judgement { findings, scale, up: looked_at }
}

/// Whether a model is of no size that anything is built in.
pub(super) fn is_absurd(extent: &Extent) -> bool {
    !BELIEVABLE_EXTENT.contains(&extent.main.size().max_element())
}

/// How the user may follow an advice.
fn how_to(scene: &Scene, entry: &str, option: &str, key: &str) -> String {
    match &scene.source {
        SceneSource::Builtin(_) => format!("{key} in {}.toml", scene.name),
        _ => format!(
            "File > Unit and up axis > {entry}, {option} on the command line, or {key} in {}.toml",
            scene.name
        ),
    }
}

struct Doubt {
    proposal: Option<LengthUnit>,
    severity: Severity,
    message: String,
}

fn doubted_unit(
    scene: &Scene,
    extent: &Extent,
    space: &Space,
    stated: FrameChoice,
    up: UpAxis,
    room: Option<f64>,
) -> Option<Doubt> {
    use LengthUnit::{Centimetre, Foot, Inch, Metre, Millimetre};
    let longest = extent.main.size().max_element();
    let absurd = is_absurd(extent);
    if stated.unit.is_some() && !absurd {
        return None;
    }
    let height = extent.main.size().dot(up.vector());
    // Rooms tell more than the whole, which may be a tower.
    let (what, size, wanted) = match room {
        Some(room) => ("its rooms are", room, ROOM_HEIGHT),
        None => ("the model is", height, HOUSE_HEIGHT),
    };
    let in_unit = |unit: LengthUnit| size / scene.unit.metres() * unit.metres();
    let all = [Millimetre, Centimetre, Metre, Foot, Inch].into_iter().filter(|&unit| unit != scene.unit);
    let fitting: Vec<LengthUnit> = all.filter(|&unit| wanted.contains(&in_unit(unit))).collect();
    let (doubted, severity) = match room {
        _ if absurd => (true, Severity::Warning),
        Some(room) if BELIEVABLE_ROOM.contains(&room) => (false, Severity::Note),
        // Furniture decides between a hall in metres and a room in feet; an empty one may be either.
        Some(room) if HALL_OR_FEET.contains(&room) => match furniture(space, up.vector()) {
            Furniture::InMetres => (false, Severity::Note),
            Furniture::InFeet => (true, Severity::Warning),
            Furniture::None => (fitting.contains(&Foot), Severity::Note),
        },
        Some(room) if room > HIGHEST_HALL => {
            (true, if fitting.is_empty() { Severity::Note } else { Severity::Warning })
        }
        Some(room) if room > *BELIEVABLE_ROOM.end() => (!fitting.is_empty(), Severity::Note),
        _ => (height > 0.0 && !BELIEVABLE_HEIGHT.contains(&height) && !fitting.is_empty(), Severity::Warning),
    };
    if !doubted {
        return None;
    }
    let proposal = fitting.first().copied();
    let message = match proposal {
        Some(unit) => {
            let symbol = unit.symbol();
            format!(
                "{what} {} m high; in {} {} be {:.2} m: {}",
                rounded(size),
                unit.name(),
                if room.is_some() { "they would" } else { "it would" },
                in_unit(unit),
                how_to(
                    scene,
                    capitalised(unit.name()).as_str(),
                    &format!("--unit {symbol}"),
                    &format!("unit = \"{symbol}\"")
                ),
            )
        }
        None if absurd => format!(
            "the model measures {longest:.3e} m, which is very {} for a building; choose its unit: {}",
            if longest > *BELIEVABLE_EXTENT.end() { "large" } else { "small" },
            how_to(scene, "...", "--unit mm, cm, m, in or ft", "unit = \"...\"")
        ),
        None => format!(
            "{what} {} m high, and in no unit of mm, cm, m, in or ft that of a room; scale the model where it was made",
            rounded(size)
        ),
    };
    Some(Doubt { proposal, severity, message })
}

fn rounded(metres: f64) -> String {
    if metres >= 100.0 {
        format!("{metres:.0}")
    } else if metres >= 0.1 {
        format!("{metres:.2}")
    } else {
        format!("{metres:.2e}")
    }
}

fn capitalised(word: &str) -> String {
    let mut letters = word.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

/// In which unit seats and tables are as high as seats and tables are.
enum Furniture {
    InMetres,
    InFeet,
    None,
}

fn furniture(space: &Space, up: DVec3) -> Furniture {
    const SAMPLES: usize = 600;
    let (mut in_metres, mut in_feet) = (0, 0);
    for top in space.floors(up, SAMPLES) {
        // With room to sit or to work above it, and beside it a drop to the floor.
        let drop = [0.6, 1.8].map(|aside| drop_beside(space, top.place, aside, up));
        let has_room = |least: f64| top.headroom.is_none_or(|room| room > least);
        in_metres += usize::from(has_room(0.9) && drop.iter().flatten().any(|d| (0.35..=1.0).contains(d)));
        in_feet += usize::from(has_room(2.9) && drop.iter().flatten().any(|d| (1.2..=3.2).contains(d)));
    }
    if in_metres.max(in_feet) < SAMPLES / 100 {
        Furniture::None
    } else if in_feet > 2 * in_metres {
        Furniture::InFeet
    } else {
        Furniture::InMetres
    }
}

/// How far the floor is below a place on a piece of furniture, seen from right beside it.
fn drop_beside(space: &Space, place: DVec3, aside: f64, up: DVec3) -> Option<f64> {
    let level = up.any_orthonormal_vector();
    let sides = [level, -level, up.cross(level), -up.cross(level)];
    let from = place + up * 1e-3;
    let drops = sides.iter().filter(|&&side| space.distance(from, side).is_none_or(|free| free > aside));
    drops.filter_map(|&side| space.distance(from + side * aside, -up)).max_by(f64::total_cmp)
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    /// A model made of quads, written with y or z up.
    #[derive(Default)]
    struct Model {
        text: String,
        corners: usize,
    }

    impl Model {
        fn new(name: &str) -> Self {
            Self { text: format!("mtllib m.mtl\no {name}\n"), corners: 0 }
        }

        fn object(&mut self, name: &str, material: &str) -> &mut Self {
            self.text += &format!("o {name}\nusemtl {material}\n");
            self
        }

        fn quad(&mut self, corners: [[f64; 3]; 4]) -> &mut Self {
            for [x, y, z] in corners {
                self.text += &format!("v {x} {y} {z}\n");
            }
            let n = self.corners;
            self.text += &format!("f {} {} {} {}\n", n + 1, n + 2, n + 3, n + 4);
            self.corners += 4;
            self
        }

        /// A level face that faces up, or down.
        fn level(&mut self, [x, y, z]: [f64; 3], [w, d]: [f64; 2], upwards: bool) -> &mut Self {
            let (a, b) = ([x, y, z], [x + w, y, z]);
            let (c, e) = ([x + w, y, z + d], [x, y, z + d]);
            if upwards { self.quad([a, e, c, b]) } else { self.quad([a, b, c, e]) }
        }

        fn block(&mut self, [x, y, z]: [f64; 3], [w, h, d]: [f64; 3]) -> &mut Self {
            self.level([x, y, z], [w, d], false).level([x, y + h, z], [w, d], true);
            self.walls([x, y, z], [w, h, d])
        }

        fn walls(&mut self, [x, y, z]: [f64; 3], [w, h, d]: [f64; 3]) -> &mut Self {
            for at in [z, z + d] {
                self.quad([[x, y, at], [x + w, y, at], [x + w, y + h, at], [x, y + h, at]]);
            }
            for at in [x, x + w] {
                self.quad([[at, y, z], [at, y + h, z], [at, y + h, z + d], [at, y, z + d]]);
            }
            self
        }

        fn scaled(&self, factor: f64) -> Self {
            self.mapped(|[x, y, z]| [x * factor, y * factor, z * factor])
        }

        fn z_up(&self) -> Self {
            self.mapped(|[x, y, z]| [x, -z, y])
        }

        fn mapped(&self, map: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
            let line = |line: &str| match line.strip_prefix("v ") {
                Some(rest) => {
                    let values: Vec<f64> = rest.split(' ').map(|word| word.parse().unwrap()).collect();
                    let [x, y, z] = map([values[0], values[1], values[2]]);
                    format!("v {x} {y} {z}\n")
                }
                None => format!("{line}\n"),
            };
            Self { text: self.text.lines().map(line).collect(), corners: self.corners }
        }

        fn doubts(&self, sidecar: &str) -> Vec<Finding> {
            let mtl = "newmtl a\nKd 0.5 0.5 0.5\nnewmtl light\nKd 0 0 0\nKe 9 9 9\n";
            let scene = from_text("t", &self.text, mtl, Some(sidecar)).unwrap();
            let kinds = [FindingKind::Unit, FindingKind::UpAxis];
            scene.findings.into_iter().filter(|finding| kinds.contains(&finding.kind)).collect()
        }

        /// What would set it right, by the first doubt.
        fn remedy(&self) -> Option<(LengthUnit, UpAxis)> {
            self.doubts("").first().and_then(|finding| finding.remedy)
        }
    }

    /// One storey with a table, chairs and shelves; no names and no lamp.
    fn storey() -> Model {
        let mut model = Model::new("house");
        model.object("part", "a").level([0.0; 3], [9.0, 7.0], true).level([0.0, 2.6, 0.0], [9.0, 7.0], false);
        model.walls([0.0; 3], [9.0, 2.6, 7.0]).walls([4.0, 0.0, 0.0], [0.1, 2.6, 5.0]);
        for k in 0..12 {
            let (x, z) = (f64::from(k % 4) * 1.93 + 0.4, f64::from(k / 4) * 1.71 + 0.5);
            let height = [0.45, 0.74, 0.9][k as usize % 3];
            model.object(&format!("thing{k}"), "a").block([x, 0.0, z], [0.6, height, 0.8]);
        }
        model
    }

    fn lamp(model: &mut Model, at: [f64; 3]) {
        model.object("lamp", "light").level(at, [0.6, 0.6], false);
    }

    #[test]
    fn a_furnished_storey_is_seen_to_lie_on_its_side() {
        let model = storey();
        assert!(model.doubts("").is_empty(), "{:?}", model.doubts(""));
        assert_eq!(model.z_up().remedy(), Some((LengthUnit::Metre, UpAxis::Z)));
        let doubts = model.z_up().doubts("");
        assert!(doubts[0].message.contains("lie on its side") && doubts[0].message.contains("up = \"z\""));
        for stated in ["up = \"z\"", "up = \"y\""] {
            let doubts = model.z_up().doubts(stated);
            let lies = doubts.iter().any(|finding| finding.kind == FindingKind::UpAxis);
            assert!(!lies, "what is stated is not doubted");
        }
    }

    #[test]
    fn a_model_without_a_sidecar_that_lies_on_its_side_is_set_upright() {
        let mtl = "newmtl a\nKd 0.5 0.5 0.5\nnewmtl light\nKd 0 0 0\nKe 9 9 9\n";
        let read = |model: &Model| from_text("t", &model.text, mtl, None).unwrap();
        let scene = read(&storey().z_up());
        let told = scene.findings.iter().find(|finding| finding.kind == FindingKind::UpAxis).unwrap();
        assert_eq!(
            (scene.up, told.severity, told.remedy),
            (UpAxis::Z, Severity::Note, Some((LengthUnit::Metre, UpAxis::Y)))
        );
        assert!(told.message.starts_with("z was taken for up: "), "{}", told.message);
        assert!(told.message.contains("up = \"y\""), "{}", told.message);
        let view = &scene.views[scene.start_view];
        assert!((0.5..2.5).contains(&view.eye.z), "one stands on the floor: {view:?}");
        assert_eq!(read(&storey()).up, UpAxis::Y);
        // In feet and on its side: both are told, and the buttons do not undo each other.
        let feet = read(&storey().scaled(1.0 / 0.3048).z_up());
        assert_eq!(feet.up, UpAxis::Z);
        let unit = feet.findings.iter().find(|finding| finding.kind == FindingKind::Unit).unwrap();
        assert_eq!(unit.remedy, Some((LengthUnit::Foot, UpAxis::Z)));
    }

    #[test]
    fn lamps_and_names_tell_up_where_shapes_do_not() {
        // A tower: most of its area is upright.
        let mut tower = Model::new("tower");
        for k in 0..9 {
            let y = 3.0 * f64::from(k);
            tower.object(&format!("floor {k}"), "a").level([0.0, y, 0.0], [5.0, 5.0], true);
            tower.object("part", "a").walls([0.0, y, 0.0], [5.0, 3.0, 5.0]);
            tower.object(&format!("ceiling {k}"), "a").level([0.0, y + 2.8, 0.0], [5.0, 5.0], false);
            lamp(&mut tower, [2.0, y + 2.7, 2.0]);
        }
        assert!(tower.doubts("").is_empty(), "{:?}", tower.doubts(""));
        assert_eq!(tower.z_up().remedy(), Some((LengthUnit::Metre, UpAxis::Z)));
        // A corridor along x: its long walls are larger than its floor.
        let mut corridor = Model::new("corridor");
        corridor.object("part", "a").block([0.0; 3], [30.0, 3.0, 1.8]);
        lamp(&mut corridor, [15.0, 2.9, 0.6]);
        assert!(corridor.doubts("").is_empty(), "{:?}", corridor.doubts(""));
        assert_eq!(corridor.z_up().doubts("").len(), 0, "a lamp alone is not enough");
    }

    #[test]
    fn where_nothing_speaks_for_an_axis_nothing_is_said() {
        let mut cornell = Model::new("box");
        cornell.object("part", "a").block([0.0; 3], [0.55, 0.55, 0.56]);
        cornell.block([0.1, 0.0, 0.1], [0.16, 0.33, 0.16]).block([0.3, 0.0, 0.3], [0.16, 0.16, 0.16]);
        // The front of a house: windows and ledges on a wall.
        let mut front = Model::new("front");
        front.object("part", "a").quad([
            [0.0, 0.0, 0.0],
            [20.0, 0.0, 0.0],
            [20.0, 12.0, 0.0],
            [0.0, 12.0, 0.0],
        ]);
        for k in 0..24 {
            let at = [f64::from(k % 6) * 3.1 + 1.0, f64::from(k / 6) * 2.9 + 0.7, 0.0];
            front.object(&format!("window{k}"), "a").block(at, [1.1, 1.4, 0.2]);
        }
        let tilted = storey().mapped(|[x, y, z]| [x, y * 0.8 - z * 0.6, y * 0.6 + z * 0.8]);
        for (what, model) in [("a Cornell box", &cornell), ("a front", &front), ("a tilted storey", &tilted)]
        {
            assert!(model.doubts("").is_empty(), "{what}: {:?}", model.doubts(""));
        }
        assert!(cornell.z_up().doubts("").is_empty());
        assert!(storey().mapped(|[x, y, z]| [y, x, z]).doubts("").is_empty(), "x is no axis to choose");
    }

    #[test]
    fn the_height_of_rooms_tells_the_unit() {
        use LengthUnit::{Centimetre, Foot, Inch, Millimetre};
        for (factor, unit) in
            [(1000.0, Millimetre), (100.0, Centimetre), (1.0 / 0.0254, Inch), (1.0 / 0.3048, Foot)]
        {
            let model = storey().scaled(factor);
            assert_eq!(model.remedy(), Some((unit, UpAxis::Y)), "{unit:?}");
            assert_eq!(model.z_up().remedy(), Some((unit, UpAxis::Z)), "{unit:?}, on its side");
            let doubts = model.doubts("");
            let symbol = format!("unit = \"{}\"", unit.symbol());
            assert!(doubts.len() == 1 && doubts[0].severity == Severity::Warning, "{doubts:?}");
            let message = &doubts[0].message;
            assert!(message.contains(&symbol) && message.contains("2.60 m"), "{message}");
            assert!(model.doubts(&symbol).is_empty(), "stated: {unit:?}");
        }
        // A hall of 9 m with chairs in it is a hall.
        let mut hall = Model::new("hall");
        hall.object("part", "a").block([0.0; 3], [30.0, 9.0, 20.0]);
        for k in 0..60 {
            let at = [f64::from(k % 10) * 2.0 + 4.0, 0.0, f64::from(k / 10) * 2.0 + 4.0];
            hall.object(&format!("chair{k}"), "a").block(at, [0.9, 0.45, 0.9]);
        }
        assert!(hall.doubts("").is_empty(), "{:?}", hall.doubts(""));
        // An empty one may be a room in feet: a note.
        let mut empty = Model::new("hall");
        empty.object("part", "a").block([0.0; 3], [30.0, 9.0, 20.0]);
        assert!(matches!(&empty.doubts("")[..], [one] if one.severity == Severity::Note));
        // In no unit a room: no unit is proposed.
        let odd = storey().scaled(13.12);
        assert!(matches!(&odd.doubts("")[..], [one] if one.remedy.is_none()), "{:?}", odd.doubts(""));
    }

    #[test]
    fn sizes_of_countries_and_atoms_are_doubted_even_where_they_are_stated() {
        for factor in [1e6, 1e-6] {
            let doubts = storey().scaled(factor).doubts("unit = \"m\"\nup = \"y\"");
            assert!(doubts.len() == 1 && doubts[0].message.contains("for a building"), "{doubts:?}");
        }
        let upright = "v 0 0 0\nv 4000 0 0\nv 4000 3000 0\nf 1 2 3\n";
        let findings = from_text("t", upright, "", None).unwrap().findings;
        let has = |words: &str| findings.iter().any(|finding| finding.message.contains(words));
        assert!(has("unit = \"mm\"") && has("3.00 m"), "{findings:?}");
    }
}
