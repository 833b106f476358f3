//! No bytes make a reader panic, and whatever it accepts is finite and not negative.

use super::*;
use crate::photometry::direction;
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(63),
        ..ProptestConfig::default()
    }
}

fn is_sound(bytes: &[u8]) -> Result<(), TestCaseError> {
    let photometry = match read("fuzzed", bytes) {
        Ok(photometry) => photometry,
        Err(error) => {
            prop_assert!(error.to_string().len() < 1000);
            return Ok(());
        }
    };
    let figure = |value: f64| value.is_finite() && value >= 0.0;
    for c in [0.0, 45.0, 133.3, 270.0, 359.9] {
        for gamma in [0.0, 0.1, 30.0, 90.0, 135.0, 180.0] {
            prop_assert!(figure(photometry.intensity(direction(c, gamma))));
            prop_assert!(figure(photometry.distribution.intensity_at(c, gamma)));
        }
    }
    let flux = photometry.flux();
    prop_assert!(figure(flux) && figure(photometry.watts));
    let peak = photometry.distribution.maximum();
    prop_assert!(flux <= peak.candela * 4.0 * std::f64::consts::PI * (1.0 + 1e-9));
    let opening = photometry.opening;
    for size in [opening.along_c0, opening.along_c90, opening.height, opening.level_area(), opening.longest()]
    {
        prop_assert!(figure(size));
    }
    let check = photometry.flux_check();
    prop_assert!([check.stated, check.ratio].into_iter().flatten().all(figure));
    for set in &photometry.lamps {
        prop_assert!(figure(set.count) && figure(set.watts) && set.lumens.is_none_or(figure));
    }
    for plane in crate::photometry::MainPlane::ALL {
        for spread in
            [photometry.distribution.beam(plane), photometry.distribution.field(plane)].into_iter().flatten()
        {
            prop_assert!((0.0..=360.0).contains(&spread.angle()), "{spread:?}");
        }
        prop_assert!(photometry.distribution.polar_curve(plane, 15.0).iter().all(|point| figure(point[1])));
    }
    if let Some(tilt) = &photometry.tilt {
        prop_assert!([-1e9, 0.0, 33.0, 1e9].into_iter().all(|angle| figure(tilt.factor(angle))));
    }
    Ok(())
}

/// Good files of every kind.
fn good_files() -> Vec<String> {
    let (quarter, all) = (every(30.0, 0.0, 90.0), every(45.0, 0.0, 360.0));
    let level = every(30.0, -90.0, 90.0);
    let light = |v: f64, h: f64| 50.0 + v.abs() + 0.25 * h.abs();
    let ies = ies_of(1, &quarter, &all, light);
    let (head, tail) = ies.split_once("TILT=NONE").unwrap();
    let with_tilt = format!("{head}TILT=INCLUDE\n1 2 0 90 1 .8\n{tail}");
    let c = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0];
    vec![
        ies_of(1, &quarter, &[0.0], light),
        ies_of(2, &level, &level, light),
        ies_of(3, &level, &quarter, light),
        with_tilt,
        ies,
        ldt_of(0, 8, &c, &quarter, light),
        ldt_of(1, 8, &c[..1], &quarter, light),
        ldt_of(2, 8, &c[..5], &quarter, light),
        ldt_of(3, 8, &c[..5], &quarter, light),
        ldt_of(4, 8, &c[..3], &quarter, light)
            .replace("\n1\n1\nLED\n1000\n3000\n80\n20\n", "\n2\n1\n1\nA\nB\n9\n9\n3\n4\n8\n8\n2\n2\n"),
    ]
}

/// Words that break numbers and structure.
const WORDS: &[&str] = &[
    "",
    "-",
    "0",
    "-1",
    "1",
    "2",
    "3",
    "90",
    "180",
    "360",
    "1e12",
    "-1e12",
    "1e308",
    "1e-300",
    "nan",
    "inf",
    "0,5",
    ",",
    ";",
    "TILT=NONE",
    "TILT=INCLUDE",
    "\n",
    "\n\n",
    "\r",
    "\0",
    "\u{1a}",
    "[MORE]",
    "=",
    "7201",
    "3601",
    "4e9",
    "0.01",
    "1d5",
];

#[derive(Clone, Debug)]
enum Change {
    Word(usize, usize),
    Line(usize, usize),
    Byte(usize, u8),
    Cut(usize),
    Drop(usize, usize),
    Repeat(usize, usize),
}

fn change() -> impl Strategy<Value = Change> {
    let at = any::<usize>;
    prop_oneof![
        4 => (at(), 0..WORDS.len()).prop_map(|(a, w)| Change::Word(a, w)),
        3 => (at(), 0..WORDS.len()).prop_map(|(a, w)| Change::Line(a, w)),
        2 => (at(), any::<u8>()).prop_map(|(a, b)| Change::Byte(a, b)),
        1 => at().prop_map(Change::Cut),
        1 => (at(), 1_usize..40).prop_map(|(a, n)| Change::Drop(a, n)),
        1 => (at(), 1_usize..40).prop_map(|(a, n)| Change::Repeat(a, n)),
    ]
}

fn apply(bytes: &mut Vec<u8>, change: &Change) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    let span = |from: usize, is_end: fn(u8) -> bool| {
        let start = bytes[..from].iter().rposition(|&b| is_end(b)).map_or(0, |at| at + 1);
        start..bytes[from..].iter().position(|&b| is_end(b)).map_or(length, |at| from + at)
    };
    match *change {
        Change::Word(at, word) => {
            let word_span = span(at % length, |b| b.is_ascii_whitespace());
            bytes.splice(word_span, WORDS[word].bytes());
        }
        Change::Line(at, word) => {
            let line_span = span(at % length, |b| b == b'\n');
            bytes.splice(line_span, WORDS[word].bytes());
        }
        Change::Byte(at, byte) => bytes[at % length] = byte,
        Change::Cut(at) => bytes.truncate(at % length),
        Change::Drop(at, count) => {
            let from = at % length;
            bytes.drain(from..(from + count).min(length));
        }
        Change::Repeat(at, count) => {
            let from = at % length;
            let again = bytes[from..(from + count).min(length)].to_vec();
            bytes.splice(from..from, again);
        }
    }
}

#[test]
fn the_good_files_are_good() {
    for text in good_files() {
        assert!(good(&text).flux() > 0.0);
        is_sound(text.as_bytes()).unwrap();
    }
}

proptest! {
    #![proptest_config(config(10_000))]

    #[test]
    fn mutated_files_are_refused_or_sound(
        file in 0_usize..10,
        changes in prop::collection::vec(change(), 1..5),
    ) {
        let mut bytes = good_files().swap_remove(file).into_bytes();
        for change in &changes {
            apply(&mut bytes, change);
        }
        is_sound(&bytes)?;
    }
}

proptest! {
    #![proptest_config(config(2_000))]

    #[test]
    fn random_bytes_are_refused_or_sound(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        is_sound(&bytes)?;
    }

    #[test]
    fn random_words_after_a_header_are_refused_or_sound(
        eulumdat in any::<bool>(),
        words in prop::collection::vec(0..WORDS.len(), 0..120),
    ) {
        let separator = if eulumdat { "\n" } else { " " };
        let body = words.iter().map(|&word| WORDS[word]).collect::<Vec<_>>().join(separator);
        let head = if eulumdat { "a\n1\n1\n1\n0\n2\n0\n" } else { "IESNA91\nTILT=NONE\n1 1 1 2 1 1 2 0 0 0 \
        1 1 1 " };
        is_sound(format!("{head}{body}").as_bytes())?;
    }
}
