//! Files of LM-63 in their editions and habits.

use super::*;
use crate::photometry::{Distribution, Format, LampPosition, Opening, OpeningShape, direction};

const DOWNLIGHT: &str = "IESNA:LM-63-2002\n[TEST] 42\n[MANUFAC] Lumen Works\n[LUMCAT] D-10\n[LUMINAIRE] \
Round downlight\n\
    [MORE] with clear glass\n[LAMP] LED\n[_OWN] text\nTILT=NONE\n1 1000 2 4 1 1 1 -0.5 -0.5 0\n0.9 1 18\n0 30 60 90\n0\n\
    500 400 100 0\n";

#[test]
fn the_header_is_understood() {
    let lamp = good(DOWNLIGHT);
    assert_eq!(lamp.format, Format::Lm63 { year: 2002 });
    assert_eq!(lamp.description.lines(), ["Lumen Works", "Round downlight with clear glass (D-10)", "LED"]);
    assert_eq!((lamp.description.report.as_str(), lamp.description.keywords.len()), ("42", 6));
    near(lamp.distribution.intensity_at(123.0, 30.0), 400.0 * 2.0 * 0.9, 1e-9);
    near(lamp.distribution.intensity_at(0.0, 15.0), 450.0 * 2.0 * 0.9, 1e-9);
    assert_eq!((lamp.lamps.len(), lamp.lamps[0].lumens, lamp.watts), (1, Some(1000.0), 18.0));
    assert_eq!(lamp.lamp_flux, Some(900.0));
    assert_eq!(lamp.opening.shape, OpeningShape::Disc);
    near(lamp.opening.along_c0, 0.1524, 1e-12);
    near(lamp.opening.level_area(), 0.1524 * 0.1524 * std::f64::consts::FRAC_PI_4, 1e-12);
    assert!(lamp.notes.is_empty(), "{:?}", lamp.notes);
}

#[test]
fn the_same_numbers_read_the_same_however_they_are_written() {
    let lamp = good(DOWNLIGHT);
    let same = |text: &[u8]| {
        let other = read("test", text).unwrap();
        assert_eq!(other.distribution, lamp.distribution);
        assert_eq!(other.opening, lamp.opening);
        other
    };
    same(DOWNLIGHT.replace('\n', "\r\n").as_bytes());
    same(DOWNLIGHT.replace('\n', "\r").as_bytes());
    same(DOWNLIGHT.replace('\n', "\r\r\n").as_bytes());
    same((DOWNLIGHT.to_owned() + "\r\n\u{1a}").as_bytes());
    same(DOWNLIGHT.trim_end().as_bytes());
    let (head, numbers) = DOWNLIGHT.split_once("NONE\n").unwrap();
    let one_line = format!("{head}none\n{}", numbers.replace('\n', " "));
    same(one_line.as_bytes());
    same(one_line.replace("TILT=", "tilt = ").as_bytes());
    same(format!("{head}NONE\n{}", numbers.split_whitespace().collect::<Vec<_>>().join("\n\n")).as_bytes());
    same(format!("{head}NONE\n{}", numbers.replace('\n', " ").trim().replace(' ', ",")).as_bytes());
    same(format!("{head}NONE\n{}", numbers.replace(' ', ", ")).as_bytes());
    same(
        DOWNLIGHT.replace("500 400", "5.0E+02 4.0D+02").replace("1 1000 2 4", "1.0 1000. +2 4.0").as_bytes(),
    );
    let utf16: Vec<u8> =
        std::iter::once(0xfeff).chain(DOWNLIGHT.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    same(&utf16);
    same(format!("\u{feff}{DOWNLIGHT}").as_bytes());
    let mut latin = DOWNLIGHT.as_bytes().to_vec();
    let at = DOWNLIGHT.find("Round").unwrap();
    latin.splice(at..at + 5, *b"F\xfcr \x80");
    assert_eq!(same(&latin).description.luminaire, "Für € downlight with clear glass");
}

#[test]
fn editions_differ_in_the_ballast_lamp_factor() {
    let of =
        |head: &str| good(&DOWNLIGHT.replace("IESNA:LM-63-2002\n", head).replace("0.9 1 18", "0.9 0.5 18"));
    for (head, year, factor) in [
        ("", 1986, 0.5),
        ("IESNA91\n", 1991, 0.5),
        ("IESNA:LM-63-1991\n", 1991, 0.5),
        ("\nIESNA:LM-63-1995\n", 1995, 1.0),
        ("IESNA:LM-63-2002\n", 2002, 1.0),
        ("IES:LM-63-2019\n", 2019, 1.0),
        ("IES:LM-63-2031\n", 2019, 1.0),
        ("iesna:lm-63-1995 (draft)\n", 1995, 1.0),
        ("IESNA test file\n", 1986, 0.5),
    ] {
        let lamp = of(head);
        assert_eq!(lamp.format, Format::Lm63 { year }, "{head}");
        near(lamp.distribution.intensity_at(0.0, 0.0), 900.0 * factor, 1e-9);
        assert_eq!(lamp.notes.len(), usize::from([1995, 2002].contains(&year)), "{head} {:?}", lamp.notes);
    }
    // Labels of 1986 are free lines.
    let (_, numbers) = DOWNLIGHT.split_once("TILT").unwrap();
    let labelled = good(&format!("Round downlight\nof Lumen Works\nTILT{numbers}"));
    assert_eq!(labelled.description.lines(), ["Round downlight of Lumen Works"]);
}

#[test]
fn tilt_tables_are_kept_and_tilt_files_are_named() {
    let tilted = DOWNLIGHT.replace("TILT=NONE\n", "TILT=INCLUDE\n2\n3\n0 45 90\n1 .9\n.5\n");
    let lamp = good(&tilted);
    let tilt = lamp.tilt.as_ref().unwrap();
    assert_eq!(tilt.position, LampPosition::Horizontal);
    for (angle, factor) in
        [(-10.0, 1.0), (0.0, 1.0), (22.5, 0.95), (45.0, 0.9), (67.5, 0.7), (90.0, 0.5), (170.0, 0.5)]
    {
        near(tilt.factor(angle), factor, 1e-12);
    }
    assert_eq!(lamp.distribution, good(DOWNLIGHT).distribution);
    assert!(lamp.notes.is_empty());
    let other = good(&tilted.replace("1 .9", ".8 .9"));
    assert!(other.notes[0].contains("0.8 instead of 1"), "{:?}", other.notes);
    let file = good(&DOWNLIGHT.replace("TILT=NONE", "TILT=HID 400.tlt"));
    assert!(file.notes[0].contains("'HID 400.tlt', which is not read"), "{:?}", file.notes);
    assert_eq!(file.tilt, None);
}

#[test]
fn every_symmetry_expands_to_the_same_light() {
    let gammas = every(15.0, 0.0, 180.0);
    let both = |gamma: f64, c: f64| 100.0 + gamma * (2.0 + (2.0 * c).to_radians().cos());
    let about_0 = |gamma: f64, c: f64| both(gamma, c) + gamma * c.to_radians().cos();
    let about_90 = |gamma: f64, c: f64| both(gamma, c) + gamma * c.to_radians().sin();
    let full = every(15.0, 0.0, 360.0);
    let same = |h: &[f64], candela: &dyn Fn(f64, f64) -> f64| {
        let (part, whole) =
            (good(&ies_of(1, &gammas, h, candela)), good(&ies_of(1, &gammas, &full, candela)));
        for c in every(7.5, -180.0, 360.0) {
            for gamma in every(7.5, 0.0, 180.0) {
                near(
                    part.distribution.intensity_at(c, gamma),
                    whole.distribution.intensity_at(c, gamma),
                    1e-9,
                );
            }
        }
        near(part.flux(), whole.flux(), 1e-9 * whole.flux());
        part
    };
    same(&every(15.0, 0.0, 90.0), &both);
    for (from, to) in [(0.0, 180.0), (180.0, 360.0), (-180.0, 0.0)] {
        same(&every(15.0, from, to), &about_0);
    }
    for (from, to) in [(90.0, 270.0), (-90.0, 90.0), (270.0, 450.0)] {
        same(&every(15.0, from, to), &about_90);
    }
    let lopsided = |gamma: f64, c: f64| about_0(gamma, c) + 0.5 * gamma * c.to_radians().sin();
    same(&every(15.0, -180.0, 180.0), &lopsided);
    // Without the plane at 360 the circle closes by itself.
    let open = same(&every(15.0, 0.0, 345.0), &lopsided);
    assert!(open.notes.is_empty());
    let bridged = good(&ies_of(1, &gammas, &every(15.0, 0.0, 330.0), lopsided));
    assert!(bridged.notes[0].contains("end at 330 degrees"), "{:?}", bridged.notes);
    // One plane is rotational wherever it stands.
    let round = good(&ies_of(1, &gammas, &[90.0], |gamma, _| gamma));
    near(round.distribution.intensity_at(217.0, 45.0), 45.0, 1e-12);
}

#[test]
fn vertical_angles_may_cover_a_part() {
    let half = |from, to| good(&ies_of(1, &every(10.0, from, to), &[0.0], |_, _| 10.0));
    let (down, up, all) = (half(0.0, 90.0), half(90.0, 180.0), half(0.0, 180.0));
    near(down.flux() + up.flux(), all.flux(), 1e-9);
    near(up.distribution.intensity(direction(0.0, 89.0)), 0.0, 0.0);
    near(up.distribution.downward_flux(), 0.0, 0.0);
    assert!(down.notes.is_empty() && up.notes.is_empty());
    assert!(half(0.0, 70.0).notes[0].contains("from 0 to 70 degrees: there is no light beyond"));
    let b = good(&ies_of(2, &every(10.0, 0.0, 90.0), &every(10.0, 0.0, 90.0), |_, _| 10.0));
    assert!(b.notes[0].contains("no light beyond"));
}

#[test]
fn openings_follow_the_edition() {
    use OpeningShape::*;
    let of = |year: u16, sizes: [f64; 3]| {
        let [w, l, h] = sizes;
        let head = if year == 2002 {
            "IESNA:LM-63-2002"
        } else if year == 1995 {
            "IESNA:LM-63-1995"
        } else {
            "IESNA91"
        };
        let text =
            DOWNLIGHT.replace("IESNA:LM-63-2002", head).replace("1 -0.5 -0.5 0", &format!("2 {w} {l} {h}"));
        let lamp = good(&text);
        let Opening { shape, along_c0, along_c90, height } = lamp.opening;
        (shape, [along_c0, along_c90, height], lamp.notes.len())
    };
    for year in [1991, 1995, 2002] {
        assert_eq!(of(year, [0.0, 0.0, 0.0]), (Point, [0.0; 3], 0));
        assert_eq!(of(year, [0.2, 1.0, 0.0]), (Rectangle, [1.0, 0.2, 0.0], 0));
        assert_eq!(of(year, [0.2, 1.0, 0.1]), (Box, [1.0, 0.2, 0.1], 0));
        assert_eq!(of(year, [-0.3, 0.0, 0.0]), (Disc, [0.3, 0.3, 0.0], 0));
    }
    assert_eq!(of(1991, [-0.3, 0.0, 0.5]), (VerticalCylinder, [0.3, 0.3, 0.5], 0));
    assert_eq!(of(1991, [-0.3, 0.6, 0.5]), (Ellipsoid, [0.6, 0.3, 0.5], 0));
    assert_eq!(of(1995, [-0.3, 0.6, 0.5]), (VerticalCylinder, [0.6, 0.3, 0.5], 0));
    assert_eq!(of(1995, [-0.3, 0.6, 0.0]), (Disc, [0.6, 0.3, 0.0], 0));
    assert_eq!(of(1995, [-0.3, 0.0, -0.3]), (Ellipsoid, [0.3, 0.3, 0.3], 0));
    assert_eq!(of(1995, [0.0, 0.6, -0.1]), (CylinderAlongC0, [0.6, 0.1, 0.1], 0));
    assert_eq!(of(1995, [0.6, 0.0, -0.1]), (CylinderAlongC90, [0.1, 0.6, 0.1], 0));
    assert_eq!(of(1995, [-0.3, 0.6, -0.2]), (Ellipsoid, [0.6, 0.3, 0.2], 0));
    assert_eq!(of(2002, [-0.3, -0.3, 0.0]), (Disc, [0.3, 0.3, 0.0], 0));
    assert_eq!(of(2002, [-0.3, -0.6, 0.0]), (Disc, [0.6, 0.3, 0.0], 0));
    assert_eq!(of(2002, [-0.3, -0.3, 0.5]), (VerticalCylinder, [0.3, 0.3, 0.5], 0));
    assert_eq!(of(2002, [-0.3, -0.3, -0.3]), (Ellipsoid, [0.3, 0.3, 0.3], 0));
    assert_eq!(of(2002, [-0.1, 1.2, -0.1]), (CylinderAlongC0, [1.2, 0.1, 0.1], 0));
    assert_eq!(of(2002, [1.2, -0.1, -0.1]), (CylinderAlongC90, [0.1, 1.2, 0.1], 0));
    assert_eq!(of(2002, [-0.4, 0.0, -0.4]), (VerticalDiscFacingC0, [0.0, 0.4, 0.4], 0));
    assert_eq!(of(2002, [0.4, 0.4, -0.4]), (Box, [0.4, 0.4, 0.4], 1));
    let cylinder = good(&DOWNLIGHT.replace("1 -0.5 -0.5 0", "2 -0.3 -0.3 0.5")).opening;
    assert_eq!((cylinder.centre_height(), cylinder.longest()), (0.25, 0.5));
}

#[test]
fn stated_and_integrated_flux_are_compared() {
    let flux = good(DOWNLIGHT).flux();
    let check = |lumens: f64| good(&DOWNLIGHT.replace("1 1000", &format!("1 {lumens}"))).flux_check();
    let fitting = check(3000.0);
    assert_eq!((fitting.stated, fitting.of_lamps, &fitting.warning), (Some(2700.0), true, &None));
    near(fitting.ratio.unwrap(), flux / 2700.0, 1e-12);
    assert!(check(500.0).warning.unwrap().contains("more than the 450 lm of the lamps"));
    assert!(check(50_000.0).warning.unwrap().contains("of the 45000 lm of the lamps"));
    let absolute = good(&DOWNLIGHT.replace("1 1000", "1 -1"));
    assert_eq!((absolute.lamp_flux, absolute.flux_check().ratio), (None, None));
    near(absolute.flux(), flux, 0.0);
    near(absolute.summary().efficacy.unwrap(), flux / 18.0, 1e-9);
    let dark = good(&DOWNLIGHT.replace("500 400 100 0", "0 0 0 0"));
    assert!(dark.summary().warnings[0].contains("dark"));
}

#[test]
fn what_follows_the_last_intensity_and_noise_below_zero_are_noted() {
    let more = good(&format!("{DOWNLIGHT}\nEND OF FILE\n"));
    assert!(more.notes[0].starts_with("everything from line 16 on"), "{:?}", more.notes);
    let noisy = good(&DOWNLIGHT.replace("100 0\n", "100 -0.5\n"));
    assert!(noisy.notes[0].contains("slightly negative intensities (1)"));
    near(noisy.distribution.intensity_at(0.0, 90.0), 0.0, 0.0);
}

#[test]
fn a_distribution_of_a_file_and_of_a_table_are_one() {
    let table = Distribution::new(&[0.0], &[0.0, 30.0, 60.0, 90.0], &[900.0, 720.0, 180.0, 0.0]).unwrap();
    assert_eq!(good(DOWNLIGHT).distribution, table);
}
