//! What a weather file holds.

use super::failure::Failure;
use super::text;
use crate::daylight::{Place, WeatherFile};
use std::path::Path;

/// Whether a name is that of a weather file rather than of a scene.
pub(super) fn is_weather(name: &str) -> bool {
    Path::new(name).extension().is_some_and(|ending| ending.eq_ignore_ascii_case("epw"))
}

/// Reads a weather file.
///
/// # Errors
/// It cannot be read, or is no weather file.
pub(super) fn read(name: &str) -> Result<WeatherFile, Failure> {
    let bytes = std::fs::read(name).map_err(|error| Failure::input(format!("{name}: {error}")))?;
    Ok(WeatherFile::read(name, &bytes)?)
}

/// Reads the file and tells what it holds and what is doubtful about it.
///
/// # Errors
/// It cannot be read, or is no weather file.
pub(super) fn check(name: &str) -> Result<String, Failure> {
    Ok(describe(name, &read(name)?))
}

/// `52.47 N, 13.40 E; clocks 1 h ahead of UTC`.
pub(super) fn place(place: Place) -> String {
    let side = |value: f64, names: [&str; 2]| {
        format!("{:.2} {}", value.abs(), if value < 0.0 { names[1] } else { names[0] })
    };
    let (latitude, longitude) = (side(place.latitude(), ["N", "S"]), side(place.longitude(), ["E", "W"]));
    let clocks = match place.zone() {
        ahead if ahead > 0.0 => format!("clocks {ahead} h ahead of UTC"),
        behind if behind < 0.0 => format!("clocks {} h behind UTC", -behind),
        _ => "clocks on UTC".to_owned(),
    };
    format!("{latitude}, {longitude}; {clocks}")
}

fn describe(name: &str, file: &WeatherFile) -> String {
    let (station, summary) = (file.station(), file.summary());
    let mut told = format!("{name} (EPW)\n");
    let mut line = |what: &str, value: String| told += &format!("  {what:12}{value}\n");
    let names = [&station.city, &station.region, &station.country].map(|text| text.trim());
    let names: Vec<&str> = names.into_iter().filter(|text| !text.is_empty() && *text != "-").collect();
    line("station", format!("{}, {} m above sea level", names.join(", "), station.altitude));
    line("place", place(file.place()));
    line("source", station.source.clone());
    line(
        "hours",
        format!(
            "{}, {} of them complete, {} with light",
            text::thousands(file.hours().len()),
            text::thousands(summary.complete),
            text::thousands(summary.lit)
        ),
    );
    line(
        "sums",
        format!(
            "{:.0} kWh/m² direct normal, {:.0} kWh/m² diffuse horizontal",
            summary.sums[0], summary.sums[1]
        ),
    );
    if let Some(brightest) = summary.brightest {
        let hour = brightest.hour;
        line(
            "brightest",
            format!(
                "{:02}-{:02}, {} to {} o'clock: {:.0} W/m² on the horizontal, sun {:.1} degrees high",
                hour.month,
                hour.day,
                hour.hour - 1,
                hour.hour,
                brightest.global,
                brightest.sun.elevation()
            ),
        );
    }
    for doubt in &summary.doubts {
        told += &format!("warning: {doubt}\n");
    }
    told + &text::count(summary.doubts.len(), "warning") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: &str = "\
LOCATION,Quito,-,ECU,Made,840710,-0.15,-78.48,-5.0,2812
DATA PERIODS,1,1,Data,Sunday,1/1,12/31
1999,3,21,12,60,?,20,9.5,50,72000,0,1415,300,900,700,220
1999,3,21,13,60,?,20,9.5,50,72000,0,1415,300,1000,9999,220
";

    #[test]
    fn a_weather_file_is_described_with_its_doubts() {
        let file = WeatherFile::read("quito.epw", SHORT.as_bytes()).expect("a weather file");
        let told = describe("quito.epw", &file);
        for part in [
            "Quito, ECU, 2812 m above sea level",
            "0.15 S, 78.48 W; clocks 5 h behind UTC",
            "2, 1 of them complete, 1 with light",
            "03-21, 11 to 12 o'clock: 903 W/m² on the horizontal, sun 77.2 degrees high",
            "warning: the file holds 2 hours",
            "warning: 1 of 2 hours have no direct",
            "2 warnings",
        ] {
            assert!(told.contains(part), "{part}: {told}");
        }
    }

    #[test]
    fn weather_files_are_known_by_their_endings() {
        assert!(is_weather("a/City.EPW") && is_weather("b.epw"));
        assert!(!is_weather("a.obj") && !is_weather("builtin:house") && !is_weather("epw"));
    }
}
