//! Files of EULUMDAT.

use super::*;
use crate::photometry::{Format, OpeningShape};

fn lopsided(c: f64, gamma: f64) -> f64 {
    let (sin, cos) = c.to_radians().sin_cos();
    (100.0 + gamma * (1.0 + 0.5 * cos + 0.3 * sin)).round()
}

fn plain() -> String {
    ldt_of(0, 24, &every(15.0, 0.0, 345.0), &every(5.0, 0.0, 90.0), lopsided)
}

#[test]
fn all_fields_are_understood() {
    let lamp = good(&plain());
    assert_eq!(lamp.format, Format::Eulumdat);
    assert_eq!(lamp.description.lines(), ["Lumen Works", "Test lamp (LW 7)", "LED"]);
    assert_eq!((lamp.description.report.as_str(), lamp.description.date.as_str()), ("report", "2024-05-01"));
    let set = &lamp.lamps[0];
    assert_eq!((set.count, set.lumens, set.watts), (1.0, Some(1000.0), 20.0));
    assert_eq!((set.colour.as_str(), set.rendering.as_str()), ("3000", "80"));
    assert_eq!(
        (lamp.stated_flux, lamp.lamp_flux, lamp.stated_downward_share),
        (Some(800.0), Some(1000.0), Some(1.0))
    );
    // Lengths lie along C90.
    assert_eq!(lamp.opening.shape, OpeningShape::Rectangle);
    near(lamp.opening.along_c90, 1.2, 1e-12);
    near(lamp.opening.along_c0, 0.1, 1e-12);
    let housing = lamp.housing.unwrap();
    assert_eq!((housing.round, housing.along_c90, housing.height), (false, 1.2, 0.04));
    near(lamp.distribution.intensity_at(345.0, 85.0), lopsided(345.0, 85.0), 1e-9);
    near(lamp.distribution.intensity_at(352.5, 0.0), 0.5 * (lopsided(345.0, 0.0) + lopsided(0.0, 0.0)), 1e-9);
    assert!(lamp.notes.is_empty(), "{:?}", lamp.notes);
}

#[test]
fn every_symmetry_expands_to_the_same_light() {
    let gammas = every(15.0, 0.0, 180.0);
    let round = |_: f64, gamma: f64| 200.0 - gamma;
    let about_0 = |c: f64, gamma: f64| 400.0 + gamma * c.to_radians().cos();
    let about_90 = |c: f64, gamma: f64| 400.0 + gamma * c.to_radians().sin();
    let both = |c: f64, gamma: f64| 400.0 + gamma * (2.0 * c).to_radians().cos();
    let all = every(15.0, 0.0, 345.0);
    let same = |symmetry: u8, stored: &[f64], candela: &dyn Fn(f64, f64) -> f64| {
        let part = good(&ldt_of(symmetry, 24, stored, &gammas, candela));
        let whole = good(&ldt_of(0, 24, &all, &gammas, candela));
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
    };
    same(1, &[0.0], &round);
    same(2, &every(15.0, 0.0, 180.0), &about_0);
    same(3, &every(15.0, -90.0, 90.0), &about_90);
    same(4, &every(15.0, 0.0, 90.0), &both);
}

#[test]
fn one_luminaire_agrees_in_both_formats() {
    let gammas = every(5.0, 0.0, 90.0);
    // The length lies along C0 in one format, along C90 in the other: C differs by 90 degrees.
    let ies = good(&ies_of(1, &gammas, &every(15.0, 0.0, 360.0), |gamma, c| lopsided(c - 90.0, gamma)));
    let ldt = good(&plain());
    near(ies.flux(), ldt.flux(), 1e-6 * ldt.flux());
    for c in every(4.0, 0.0, 360.0) {
        for gamma in every(4.0, 0.0, 88.0) {
            near(
                ies.distribution.intensity_at(c, gamma),
                ldt.distribution.intensity_at(c - 90.0, gamma),
                1e-9,
            );
        }
    }
    assert_eq!((ies.opening.along_c0, ies.opening.along_c90), (1.2, 0.1));
    assert_eq!((ldt.opening.along_c90, ldt.opening.along_c0), (1.2, 0.1));
}

#[test]
fn line_ends_commas_and_blank_tails_do_not_matter() {
    let text = plain();
    let lamp = good(&text);
    for other in [
        text.replace('\n', "\r\n"),
        text.replace('\n', "\r"),
        text.replace('\n', "\r\r\n"),
        text.replace('\n', "\n\r"),
        text.trim_end().to_owned(),
        format!("{text}\n\n \n\u{1a}"),
        text.replace("0.5\n", "0,5\n").replace("\n1\n0\n1\n1\nLED", "\n1,000\n0\n1\n1\nLED"),
        text.replace("\n1\n0\n1\n1\nLED", "\n\n\n1\n1\nLED"),
    ] {
        assert_eq!(good(&other).distribution, lamp.distribution);
    }
    let commas = good(&text.replace("\n1000\n3000", "\n1000,5\n3000"));
    near(commas.flux(), lamp.flux() * 1.0005, 1e-9);
    let more = good(&format!("{text}maker's remark\n"));
    assert!(more.notes[0].starts_with("everything after line"), "{:?}", more.notes);
}

#[test]
fn factors_and_lamp_sets_make_candela() {
    let text = plain();
    let lamp = good(&text);
    let of = |from: &str, to: &str| good(&text.replace(from, to));
    let twice = of("\n1\n0\n1\n1\nLED", "\n2\n0\n1\n1\nLED");
    near(twice.flux(), 2.0 * lamp.flux(), 1e-9);
    assert!(twice.notes[0].contains("conversion factor 2"));
    let zero = of("\n1\n0\n1\n1\nLED", "\n0\n5\n1\n1\nLED");
    near(zero.flux(), lamp.flux(), 0.0);
    assert_eq!((zero.notes.len(), zero.measurement_tilt), (2, 5.0));
    // Two sets, field by field and set by set.
    for sets in [
        "2\n1\n2\nLED\nT5\n1000\n500\n3000\n4000\n80\n90\n20\n10",
        "2\n1\nLED\n1000\n3000\n80\n20\n2\nT5\n500\n4000\n90\n10",
    ] {
        let both = of("1\n1\nLED\n1000\n3000\n80\n20", sets);
        near(both.flux(), 1.5 * lamp.flux(), 1e-9);
        assert_eq!(both.lamps.len(), 2);
        let second = &both.lamps[1];
        assert_eq!(
            (second.kind.as_str(), second.count, second.lumens, second.watts),
            ("T5", 2.0, Some(500.0), 10.0)
        );
        assert_eq!((both.watts, both.lamp_flux), (30.0, Some(1500.0)));
        assert!(both.notes[0].contains("2 lamp sets are added"));
    }
    // A negative number of lamps: the flux is that of the luminaire.
    let absolute = of("\n1\n0\n1\n1\nLED", "\n1\n0\n1\n-1\nLED");
    assert_eq!(
        (absolute.stated_flux, absolute.lamp_flux, absolute.lamps[0].lumens),
        (Some(1000.0), None, None)
    );
    near(absolute.flux(), lamp.flux(), 0.0);
}

#[test]
fn stated_flux_and_share_are_compared() {
    let text = plain();
    let flux = good(&text).flux();
    let stated = |ratio: f64, down: f64| {
        let text = text.replace("\n100\n80\n1\n0\n", &format!("\n{down}\n{ratio}\n1\n0\n"));
        good(&text).summary()
    };
    let fitting = stated(flux / 10.0, 100.0);
    near(fitting.flux.ratio.unwrap(), 1.0, 1e-9);
    assert!(fitting.warnings.is_empty(), "{:?}", fitting.warnings);
    let wrong = stated(flux / 10.0 * 1.1, 60.0);
    assert!(wrong.warnings[0].contains("(-9.1 %)"), "{:?}", wrong.warnings);
    assert!(wrong.warnings[1].contains("100 % of the light goes down, but the file states 60 %"));
}

#[test]
fn round_and_high_openings_are_recognised() {
    let text = plain();
    let of = |sizes: &str| good(&text.replace("\n1200\n100\n40\n1200\n100\n0\n0\n0\n0\n", sizes));
    let round = of("\n300\n0\n40\n250\n0\n0\n0\n0\n0\n");
    assert_eq!(
        (round.opening.shape, round.opening.along_c0, round.opening.along_c90),
        (OpeningShape::Disc, 0.25, 0.25)
    );
    assert!(round.housing.unwrap().round);
    let high = of("\n300\n0\n40\n250\n0\n30\n30\n50\n30\n");
    assert_eq!((high.opening.shape, high.opening.height), (OpeningShape::VerticalCylinder, 0.05));
    assert_eq!(of("\n300\n200\n40\n250\n100\n30\n0\n30\n0\n").opening.shape, OpeningShape::Box);
    let none = of("\n\n\n\n0\n0\n0\n0\n0\n0\n");
    assert_eq!((none.opening.shape, none.housing), (OpeningShape::Point, None));
}
