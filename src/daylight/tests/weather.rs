//! Weather files made here: good ones, faulty ones, and mutated ones.

use crate::daylight::{Place, SunPosition, WeatherFile};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::fmt::Write as _;
use std::sync::LazyLock;

const HEADER: &str = "\
LOCATION,Pr\u{fc}fstadt,Teststate,DEU,Made,103840,52.47,13.40,1.0,49.0
DESIGN CONDITIONS,0
TYPICAL/EXTREME PERIODS,0
GROUND TEMPERATURES,0
HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0
COMMENTS 1,Made of a clear sky
COMMENTS 2,
DATA PERIODS,1,1,Data,Sunday, 1/ 1,12/31
";

const DAYS: [u32; 12] = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];

/// A row with these irradiances: global, direct normal, diffuse horizontal.
fn row(out: &mut String, month: u32, day: u32, hour: u32, light: [f64; 3]) {
    let [global, direct, diffuse] = light;
    writeln!(
        out,
        "1999,{month},{day},{hour},60,?9?9,5.0,9.5,81,100900,0,1415,280,{global:.1},{direct:.1},{diffuse:.1},\
         9999,9999,9999,9999,230,3.1,4,2,9999,99999,9,999999999,110,0.1,0,88,0.2,0.0,1.0"
    )
    .unwrap();
}

/// A year of clear days in which direct and diffuse light follow the sun at the middle of each hour.
fn year(zone: f64) -> String {
    let place = Place::new(52.47, 13.40, zone).unwrap();
    let mut text = HEADER.to_owned();
    for (index, days) in DAYS.into_iter().enumerate() {
        for day in 1..=days {
            for hour in 1..=24 {
                let month = index as u32 + 1;
                let date = crate::daylight::Date::new(1999, month, day).unwrap();
                let time = crate::daylight::LocalTime::new(date, f64::from(hour) - 0.5).unwrap();
                let sine = SunPosition::at(place, time).unwrap().direction().z.max(0.0);
                let direct = if sine > 0.0 { 1000.0 * (-0.15 / sine).exp() } else { 0.0 };
                let diffuse = 120.0 * sine.sqrt();
                row(&mut text, month, day, hour, [diffuse + direct * sine, direct, diffuse]);
            }
        }
    }
    text
}

static YEAR: LazyLock<String> = LazyLock::new(|| year(1.0));

/// The header and two days, for faults and mutations.
fn short() -> String {
    YEAR.lines().take(8 + 48).fold(String::new(), |text, line| text + line + "\n")
}

fn read(text: &str) -> WeatherFile {
    WeatherFile::read("city.epw", text.as_bytes()).unwrap()
}

#[test]
fn a_year_is_read_with_its_place_and_its_hours() {
    let file = read(&YEAR);
    let (station, place) = (file.station(), file.place());
    assert_eq!(
        (station.city.as_str(), station.country.as_str(), station.altitude),
        ("Prüfstadt", "DEU", 49.0)
    );
    assert_eq!((place.latitude(), place.longitude(), place.zone()), (52.47, 13.40, 1.0));
    assert_eq!(file.hours().len(), 8760);
    let summary = file.summary();
    assert_eq!((summary.complete, summary.doubts.len()), (8760, 0), "{:?}", summary.doubts);
    assert!((4000..4700).contains(&summary.lit), "{}", summary.lit);
    let brightest = summary.brightest.unwrap();
    assert_eq!((brightest.hour.month, brightest.hour.hour), (6, 13), "{brightest:?}");
    assert!((brightest.sun.elevation() - 60.67).abs() < 0.02, "{brightest:?}");
    assert!((brightest.global - brightest.hour.global_horizontal.unwrap()).abs() < 0.2);
}

#[test]
fn an_hour_is_that_which_ends_at_its_number_and_has_its_sun_in_the_middle() {
    let file = read(&YEAR);
    for (time, hour) in [(0.0, 1), (11.99, 12), (12.0, 13), (12.5, 13), (23.9, 24), (24.0, 24)] {
        let found = file.hour(6, 21, time).unwrap();
        assert_eq!((found.month, found.day, found.hour), (6, 21, hour));
    }
    let noon = file.hour(6, 21, 12.0).unwrap();
    assert_eq!(noon.middle().unwrap().hours(), 12.5);
    let daylight = file.daylight(noon, 0.2).unwrap();
    // Lux over watts: what the sun gives, about 105 lm/W, and a blue sky, about 130.
    let direct = daylight.direct_normal() / noon.direct_normal.unwrap();
    let diffuse = daylight.sky().horizontal() / noon.diffuse_horizontal.unwrap();
    assert!((90.0..115.0).contains(&direct) && (110.0..150.0).contains(&diffuse), "{direct}, {diffuse}");
    // Mean noon at 13.4 degrees east is at 12:06, and the sun moves fast when it stands high.
    assert!((daylight.sun().azimuth() - 190.3).abs() < 0.1, "{:?}", daylight.sun());
    let night = file.daylight(file.hour(12, 24, 0.0).unwrap(), 0.2).unwrap();
    assert_eq!(night.global_horizontal(), 0.0);
    let said = file.hour(2, 29, 12.0).unwrap_err().to_string();
    assert!(said.contains("no hour from 12 to 13 o'clock on 29 February"), "{said}");
    // A dew point of 9.5 degrees makes 1.8 cm of water.
    assert!((noon.water() - (0.07_f64 * 9.5 - 0.075).exp()).abs() < 1e-12);
}

#[test]
fn line_ends_and_encodings_do_not_matter() {
    let text = short();
    let wanted = read(&text);
    assert_eq!(read(&text.replace('\n', "\r\n")), wanted);
    assert_eq!(read(&text.replace('\n', "\r")), wanted);
    assert_eq!(read(&format!("\u{feff}{text}\n\n")), wanted);
    let latin: Vec<u8> = text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    assert_eq!(WeatherFile::read("city.epw", &latin).unwrap(), wanted);
    let wide: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(WeatherFile::read("city.epw", &wide).unwrap(), wanted);
    assert_eq!(read(&text.replace("LOCATION", "Location").replace("DATA PERIODS", "data periods")), wanted);
}

#[test]
fn missing_and_doubtful_values_are_told() {
    let good = short();
    let edited = |hour: u32, light: [f64; 3]| {
        let mut text = String::new();
        for (index, line) in good.lines().enumerate() {
            if index == 7 + hour as usize {
                row(&mut text, 1, 1, hour, light);
            } else {
                writeln!(text, "{line}").unwrap();
            }
        }
        read(&text)
    };
    let doubts = |file: &WeatherFile| file.summary().doubts.join("; ");
    assert!(doubts(&read(&good)).contains("holds 48 hours"));
    let file = edited(12, [300.0, 9999.0, 80.0]);
    assert!(doubts(&file).contains("1 of 48 hours have no direct or no diffuse"), "{}", doubts(&file));
    let said = file.daylight(file.hour(1, 1, 11.2).unwrap(), 0.2).unwrap_err().to_string();
    assert!(said.contains("direct normal irradiance of hour 12 on 1 January is missing"), "{said}");
    assert!(doubts(&edited(12, [300.0, 200.0, 99990.0])).contains("1 of 48"));
    assert!(doubts(&edited(12, [300.0, -5.0, 80.0])).contains("1 irradiances are negative"));
    assert!(doubts(&edited(12, [300.0, 2000.0, 80.0])).contains("1 irradiances exceed 1500 W/m²"));
    let mut twice = good.clone();
    row(&mut twice, 1, 2, 24, [0.0; 3]);
    assert!(doubts(&read(&twice)).contains("hour 24 of 2 January is out of order"));
    let dark = good.lines().take(8).fold(String::new(), |text, line| text + line + "\n");
    let mut dark = dark;
    row(&mut dark, 1, 1, 1, [0.0; 3]);
    assert!(doubts(&read(&dark)).contains("no hour has any light"));
    // The wrong sign of the longitude puts the sun into the night.
    let west = YEAR.replacen(",13.40,1.0,", ",-103.40,1.0,", 1);
    let doubts = doubts(&read(&west));
    assert!(doubts.contains("in which it is down") && doubts.contains("east is positive"), "{doubts}");
    // With clocks an hour late nothing adds up.
    let late = read(&YEAR.replacen(",13.40,1.0,", ",13.40,2.0,", 1)).summary().doubts.join("; ");
    assert!(late.contains("miss the global irradiance by 14"), "{late}");
}

#[track_caller]
fn fault(text: &str, wanted: &str) {
    let error = WeatherFile::read("city.epw", text.as_bytes()).expect_err("should be refused").to_string();
    assert!(error.starts_with("city.epw") && error.contains(wanted), "'{error}' does not say '{wanted}'");
    assert!(!error.ends_with('.') && !error.contains('\n') && !error.contains(". "), "{error}");
}

#[test]
fn faults_are_one_sentence_with_file_and_line() {
    let good = short();
    fault("", "city.epw: the file is empty");
    fault("\n \r\n", "the file is empty");
    fault("v 0 0 0\n", "city.epw, line 1: this is no EPW file");
    let broken = |from: &str, to: &str, wanted: &str| {
        assert!(good.contains(from), "{from}");
        fault(&good.replacen(from, to, 1), wanted);
    };
    broken(",52.47,", ",fifty,", "line 1: the latitude should stand in field 7, but 'fifty' is no number");
    broken(",52.47,", ",91,", "line 1: the latitude is 91");
    broken(",52.47,", ",nan,", "line 1: the latitude should stand");
    broken(",13.40,1.0,49.0", "", "line 1: the longitude should stand in field 8, but '' is no number");
    broken(",13.40,1.0,", ",13.40,99,", "line 1: the time zone is 99 h");
    broken("DATA PERIODS,1,1", "DATA PERIODS,1,4", "line 8: the file has 4 records per hour");
    broken("DATA PERIODS,1,1", "DATA PERIODS", "line 8: the records per hour");
    broken("DATA PERIODS", "DATA", "no line starts with DATA PERIODS");
    broken(
        "1999,1,1,1,",
        "1999,13,1,1,",
        "line 9: the month is '13', but must be a whole number from 1 to 12",
    );
    broken("1999,1,1,1,", "1999,2,30,1,", "line 9: the day is '30', but must be a whole number from 1 to 29");
    broken("1999,1,1,2,", "1999,1,1,25,", "line 10: the hour is '25'");
    broken("1999,1,1,2,", "1999,1,1,1.5,", "line 10: the hour is '1.5'");
    broken("1999,1,1,3,", "19x9,1,1,3,", "line 11: the year is '19x9'");
    broken(
        ",280,0.0,0.0,",
        ",280,0.0,much,",
        "line 9: a number should stand in field 15, but there is 'much'",
    );
    fault(&good[..HEADER.len() + 20], "line 9: the row has");
    fault(HEADER, "no hour follows the header");
    let mut long = YEAR.clone();
    for hour in 1..=24 {
        row(&mut long, 12, 31, hour, [0.0; 3]);
    }
    assert!(read(&long).summary().doubts.len() == 1, "8784 rows are a leap year's");
    row(&mut long, 12, 31, 24, [0.0; 3]);
    fault(&long, "line 8793: more than 8784 hours");
    assert!(WeatherFile::read("a", &vec![b' '; (16 << 20) + 1]).unwrap_err().to_string().contains("16 MiB"));
}

/// Words that break numbers and structure.
const WORDS: &[&str] = &[
    "",
    "-",
    "0",
    "-1",
    "1",
    "2",
    "13",
    "24",
    "25",
    "29",
    "31",
    "90",
    "180",
    "360",
    "9999",
    "99990",
    "99.9",
    "1e12",
    "-1e12",
    "1e308",
    "1e-300",
    "nan",
    "inf",
    "0.5",
    ",",
    ",,",
    "LOCATION",
    "DATA PERIODS",
    "\n",
    "\n\n",
    "\r",
    "\0",
    "\u{1a}",
    "2147483648",
    "ö",
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
    // Half of the changes concern the first lines, where most structure is.
    let at = || prop_oneof![any::<usize>(), 0..1000_usize];
    prop_oneof![
        4 => (at(), 0..WORDS.len()).prop_map(|(a, w)| Change::Word(a, w)),
        2 => (at(), 0..WORDS.len()).prop_map(|(a, w)| Change::Line(a, w)),
        2 => (at(), any::<u8>()).prop_map(|(a, b)| Change::Byte(a, b)),
        1 => at().prop_map(Change::Cut),
        1 => (at(), 1_usize..200).prop_map(|(a, n)| Change::Drop(a, n)),
        1 => (at(), 1_usize..200).prop_map(|(a, n)| Change::Repeat(a, n)),
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
            let word_span = span(at % length, |b| b == b',' || b == b'\n');
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

/// Whatever is accepted has finite figures, and every hour of it gives light or a sentence.
fn is_sound(bytes: &[u8]) -> Result<(), TestCaseError> {
    let file = match WeatherFile::read("fuzzed", bytes) {
        Ok(file) => file,
        Err(error) => {
            prop_assert!(error.to_string().len() < 500);
            return Ok(());
        }
    };
    let summary = file.summary();
    prop_assert!(summary.complete <= file.hours().len() && summary.lit <= summary.complete);
    prop_assert!(summary.sums.iter().all(|sum| sum.is_finite() && *sum >= 0.0));
    let brightest = summary.brightest.map(|found| found.hour);
    for hour in brightest.iter().chain(file.hours().last()) {
        if let Ok(daylight) = file.daylight(hour, 0.2) {
            let lux = daylight.global_horizontal();
            prop_assert!(lux.is_finite() && lux >= 0.0, "{hour:?}: {lux}");
        } else {
            prop_assert!(hour.direct_normal.is_none() || hour.diffuse_horizontal.is_none(), "{hour:?}");
        }
    }
    Ok(())
}

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        failure_persistence: None,
        rng_seed: RngSeed::Fixed(8760),
        ..ProptestConfig::default()
    }
}

proptest! {
    #![proptest_config(config(10_000))]

    #[test]
    fn mutated_files_are_refused_or_sound(changes in prop::collection::vec(change(), 1..5)) {
        let mut bytes = short().into_bytes();
        for change in &changes {
            apply(&mut bytes, change);
        }
        is_sound(&bytes)?;
    }
}

proptest! {
    #![proptest_config(config(2_000))]

    #[test]
    fn random_bytes_are_refused_or_sound(
        with_header in any::<bool>(),
        bytes in prop::collection::vec(any::<u8>(), 0..400),
    ) {
        let head = if with_header { HEADER.as_bytes() } else { b"" };
        is_sound(&[head, &bytes].concat())?;
    }
}
