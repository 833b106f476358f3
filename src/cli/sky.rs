//! Sun and sky of a place and time.

use super::failure::Failure;
use super::options::{self, finite};
use super::sky_picture;
use super::{picture, text, weather};
use crate::daylight::{
    CieType, Date, Daylight, LocalTime, Pattern, Phase, Place, Projection, SunPosition, USUAL_GROUND,
    USUAL_WATER, Weather, direction,
};
use crate::export::atomic;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::DVec3;
use std::f64::consts::PI;
use std::path::PathBuf;

/// Tell where the sun stands and how bright the sky is, and write a picture of it
///
/// The sky is that of --type with the light that such weather usually gives, that of --lux or --perez, or
/// that of an hour of --weather. Azimuths run from north clockwise: east 90, south 180.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// Latitude (north positive) and longitude (east positive), degrees
    #[arg(long, value_name = "LAT,LON", value_parser = pair, allow_hyphen_values = true,
          required_unless_present = "weather", requires = "zone", conflicts_with = "weather")]
    place: Option<[f64; 2]>,
    /// Hours by which the clocks of the place are ahead of UTC, summer time included
    #[arg(long, value_name = "H", value_parser = finite, allow_hyphen_values = true,
          requires = "place", conflicts_with = "weather")]
    zone: Option<f64>,
    /// The day
    #[arg(long, value_name = "YYYY-MM-DD", value_parser = date)]
    date: Date,
    /// The time that the clocks show
    #[arg(long, value_name = "HH:MM", value_parser = clock)]
    time: f64,
    /// Sky of the CIE: 1 to 15, 16 (traditional overcast), clear, intermediate, overcast or uniform [default:
    /// clear]
    #[arg(long = "type", value_name = "SKY", value_parser = kind, conflicts_with_all = ["perez", "weather"])]
    kind: Option<CieType>,
    /// Illuminances of the type's sky in lux, direct normal and diffuse horizontal [default: by its weather]
    #[arg(long, value_name = "DN,DH", value_parser = pair, conflicts_with_all = ["perez", "weather"])]
    lux: Option<[f64; 2]>,
    /// All-weather sky for these irradiances in W/m², direct normal and diffuse horizontal
    #[arg(long, value_name = "DN,DH", value_parser = pair, conflicts_with = "weather")]
    perez: Option<[f64; 2]>,
    /// All-weather sky of an hour of this EPW weather file, which knows its place; its clocks have no summer
    /// time
    #[arg(long, value_name = "FILE.epw")]
    weather: Option<String>,
    /// Reflectance of the ground, 0 to 1 [default: 0.2]
    #[arg(long, value_name = "SHARE", value_parser = finite)]
    ground: Option<f64>,
    /// Write a picture of the sky: tone-mapped as .png, or radiance in W/(m² sr) as .exr
    #[arg(long, value_name = "OUT.png|OUT.exr")]
    image: Option<PathBuf>,
    /// How the picture is laid out: fisheye (a disc, north at the top, east on the right) or latlong (all
    /// directions, south in the middle) [default: fisheye]
    #[arg(long, value_parser = projections(), requires = "image")]
    projection: Option<Projection>,
    /// Pixels across and down of the picture [default: 1024x1024, 2048x1024 for latlong]
    #[arg(long, value_name = "WxH", value_parser = options::size, requires = "image")]
    size: Option<[u32; 2]>,
}

/// The sky of a place and time, and what is to be said about it.
struct Found {
    place: Place,
    /// The time at which the sun stands where it is drawn.
    time: LocalTime,
    daylight: Daylight,
    /// Irradiances in W/m², direct normal and diffuse horizontal, where these were given.
    watts: Option<[f64; 2]>,
    /// One sentence each without a full stop.
    notes: Vec<String>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let kind = arguments.image.as_deref().map(picture::kind_of).transpose()?;
    if let Some(path) = &arguments.image {
        atomic::probe(path)?;
    }
    let found = find(arguments)?;
    let mut told = describe(&found);
    // Written before anything is said, so that a reader who goes away does not cost the picture.
    if let (Some(path), Some(kind)) = (&arguments.image, kind) {
        let projection = arguments.projection.unwrap_or_default();
        let size = arguments.size.unwrap_or_else(|| projection.usual_size());
        sky_picture::write(path, kind, &found.daylight, projection, size)?;
        told += &format!("picture     {}\n", path.display());
    }
    text::print(&told)
}

fn find(arguments: &Arguments) -> Result<Found, Failure> {
    let ground = arguments.ground.unwrap_or(USUAL_GROUND);
    if let Some(name) = &arguments.weather {
        return by_weather(name, arguments.date, arguments.time, ground);
    }
    let ([latitude, longitude], zone) = match (arguments.place, arguments.zone) {
        (Some(place), Some(zone)) => (place, zone),
        _ => return Err(Failure::input("--place and --zone, or --weather, are needed")),
    };
    let place = Place::new(latitude, longitude, zone)?;
    let time = LocalTime::new(arguments.date, arguments.time)?;
    let sun = SunPosition::at(place, time)?;
    let day = arguments.date.day_of_year();
    let mut notes: Vec<String> = place.doubt().into_iter().collect();
    let kind = arguments.kind.unwrap_or(CieType::CLEAR);
    let daylight = match (arguments.perez, arguments.lux) {
        (Some([direct, diffuse]), _) => {
            Daylight::of_irradiances(direct, diffuse, sun, day, USUAL_WATER, ground)?
        }
        (None, Some([direct, diffuse])) => Daylight::new(Pattern::Cie(kind), sun, diffuse, direct, ground)?,
        (None, None) => {
            let weather = Weather::of(kind).name();
            notes.push(format!("the illuminances are those that {weather} weather usually gives"));
            Daylight::of_type(kind, sun, day, ground)?
        }
    };
    Ok(Found { place, time, daylight, watts: arguments.perez, notes })
}

/// The hour of a weather file that holds a time of day.
fn by_weather(name: &str, date: Date, time: f64, ground: f64) -> Result<Found, Failure> {
    let file = weather::read(name)?;
    let hour = file.hour(date.month(), date.day(), time)?;
    let daylight = file.daylight(hour, ground)?;
    let time = LocalTime::new(date, f64::from(hour.hour) - 0.5)?;
    let from = format!("{name}, hour from {} to {} o'clock", hour.hour - 1, hour.hour);
    let notes = vec![format!("the weather is that of {from} in {}; the sun stands in its middle", hour.year)];
    let watts = hour.direct_normal.zip(hour.diffuse_horizontal).map(|(direct, diffuse)| [direct, diffuse]);
    Ok(Found { place: file.place(), time, daylight, watts, notes })
}

fn describe(found: &Found) -> String {
    let Found { place, time, daylight, watts, notes } = found;
    let (sun, sky) = (daylight.sun(), daylight.sky());
    let mut told = String::new();
    let mut line = |what: &str, value: String| told += &format!("{what:12}{value}\n");
    line("place", weather::place(*place));
    line("time", time.to_string());
    let phase = match Phase::of(sun) {
        Phase::Day => "",
        Phase::Twilight => ": twilight",
        Phase::Night => ": night",
    };
    line("sun", format!("elevation {:.2}, azimuth {:.2} degrees{phase}", sun.elevation(), sun.azimuth()));
    line("sky", sky.description());
    if let Some([direct, diffuse]) = watts {
        let efficacy = |lux: f64, watts: f64| {
            if watts > 0.0 { format!(" ({:.1} lm/W)", lux / watts) } else { String::new() }
        };
        line(
            "irradiance",
            format!(
                "direct normal {direct} W/m²{}, diffuse horizontal {diffuse} W/m²{}",
                efficacy(daylight.direct_normal(), *direct),
                efficacy(sky.horizontal(), *diffuse)
            ),
        );
    }
    line("zenith", format!("{} cd/m²", amount(sky.zenith())));
    let disc = if daylight.direct_normal() > 0.0 {
        format!(", disc {:.3e} cd/m²", daylight.sun_luminance())
    } else {
        String::new()
    };
    line("direct", format!("{} lux normal to the sun{disc}", amount(daylight.direct_normal())));
    line(
        "ground",
        format!(
            "{} cd/m², reflectance {:.2}",
            amount(daylight.ground_luminance()),
            daylight.ground_reflectance()
        ),
    );
    told += "\n";
    told += &illuminances(daylight);
    for note in notes {
        told += &format!("note: {note}\n");
    }
    if let Pattern::Perez(perez) = sky.pattern()
        && let Some(doubt) = perez.doubt()
    {
        told += &format!("warning: {doubt}\n");
    }
    told
}

/// The table of illuminances by what they come from.
fn illuminances(daylight: &Daylight) -> String {
    let faces = [
        ("horizontal", DVec3::Z),
        ("north", direction(0.0, 0.0)),
        ("east", direction(0.0, 90.0)),
        ("south", direction(0.0, 180.0)),
        ("west", direction(0.0, 270.0)),
    ];
    let mut rows = vec![["lux", "sky", "sun", "ground", "in all"].map(str::to_owned).to_vec()];
    for (name, normal) in faces {
        let sky = daylight.sky().illuminance(normal);
        let sun = daylight.direct_normal() * normal.dot(daylight.sun().direction()).max(0.0);
        let ground = PI * daylight.ground_luminance() * 0.5 * (1.0 - normal.z);
        let values = [sky, sun, ground, sky + sun + ground].map(|lux| format!("{:>9}", amount(lux)));
        rows.push([vec![format!("{name:10}")], values.to_vec()].concat());
    }
    // The heads stand over numbers that end at the right.
    for head in &mut rows[0][1..] {
        *head = format!("{head:>9}");
    }
    text::table(&rows)
}

/// Whole numbers with separators, or three digits of small ones.
fn amount(value: f64) -> String {
    if value >= 1000.0 {
        text::thousands(value.round() as usize)
    } else {
        // Less than starlight is a rounding error.
        text::significant(if value < 1e-6 { 0.0 } else { value })
    }
}

fn projections() -> impl TypedValueParser<Value = Projection> {
    PossibleValuesParser::new(Projection::ALL.map(Projection::name)).map(|name| {
        Projection::ALL.into_iter().find(|projection| projection.name() == name).unwrap_or_default()
    })
}

/// `A,B`.
fn pair(text: &str) -> Result<[f64; 2], String> {
    let (first, second) = text.split_once(',').ok_or("two numbers with a comma between them are needed")?;
    Ok([finite(first)?, finite(second)?])
}

/// `YYYY-MM-DD`.
fn date(text: &str) -> Result<Date, String> {
    let parts: Option<Vec<u32>> = text.trim().split('-').map(|part| part.parse().ok()).collect();
    let Some(&[year, month, day]) = parts.as_deref() else {
        return Err("a date as 2026-06-21 is needed".into());
    };
    Date::new(i32::try_from(year).unwrap_or(i32::MAX), month, day).map_err(|error| error.to_string())
}

/// `HH:MM`, in hours.
fn clock(text: &str) -> Result<f64, String> {
    let parts = text.trim().split_once(':').and_then(|(h, m)| Some((h.parse().ok()?, m.parse().ok()?)));
    match parts {
        Some((hour, minute)) if hour < 24_u32 && minute < 60_u32 => {
            Ok(f64::from(hour) + f64::from(minute) / 60.0)
        }
        Some((24, 0)) => Ok(24.0),
        _ => Err("a time from 00:00 to 24:00 is needed".into()),
    }
}

/// A number from 1 to 16, or a name.
fn kind(text: &str) -> Result<CieType, String> {
    let name = text.trim().to_lowercase();
    if name == "uniform" {
        return Ok(CieType::UNIFORM);
    }
    if let Some(weather) = Weather::ALL.into_iter().find(|weather| weather.name() == name) {
        return Ok(weather.sky());
    }
    let number = name.parse().map_err(|_| {
        "a number from 1 to 16, or clear, intermediate, overcast or uniform is needed".to_owned()
    })?;
    CieType::new(number).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{daylight, scene};

    #[test]
    fn values_are_read_and_refused_with_a_reason() {
        assert_eq!(pair("52.5, -13"), Ok([52.5, -13.0]));
        assert!(pair("52.5").is_err() && pair("a,1").is_err() && pair("1,nan").is_err());
        assert_eq!(date("2026-06-21"), Ok(Date::new(2026, 6, 21).expect("a day")));
        assert!(date("2026-02-30").expect_err("no day").contains("30 February 2026 does not exist"));
        assert!(date("21.6.2026").is_err() && date("2026-06").is_err() && date("99999999999-1-1").is_err());
        assert_eq!((clock("09:30"), clock("24:00"), clock("0:00")), (Ok(9.5), Ok(24.0), Ok(0.0)));
        assert!(clock("24:01").is_err() && clock("9").is_err() && clock("9:60").is_err());
        assert_eq!(kind("12"), kind("clear"));
        assert_eq!((kind("Overcast"), kind("uniform")), (Ok(CieType::OVERCAST), Ok(CieType::UNIFORM)));
        assert!(kind("17").expect_err("no type").contains("no CIE sky of type 17") && kind("blue").is_err());
    }

    #[test]
    fn daylight_and_lamps_are_converted_by_the_same_efficacy() {
        assert_eq!(daylight::LUMINOUS_EFFICACY, scene::LUMINOUS_EFFICACY);
    }

    #[test]
    fn a_sky_is_described_by_its_figures() {
        let sun = SunPosition::new(30.0, 180.0).expect("a sun");
        let daylight = Daylight::new(Pattern::Cie(CieType::UNIFORM), sun, 10_000.0, 50_000.0, 0.2);
        let time = LocalTime::new(Date::new(2026, 6, 21).expect("a day"), 12.0).expect("a time");
        let found = Found {
            place: Place::new(52.5, 13.4, 1.0).expect("a place"),
            time,
            daylight: daylight.expect("a sky"),
            watts: None,
            notes: vec!["made up".to_owned()],
        };
        let told = describe(&found);
        for part in [
            "52.50 N, 13.40 E; clocks 1 h ahead of UTC",
            "21 June 2026, 12:00",
            "elevation 30.00, azimuth 180.00 degrees\n",
            "zenith      3,183 cd/m²",
            "50,000 lux normal to the sun, disc 7.357e8 cd/m²",
            "horizontal     10,000     25,000          0     35,000",
            "east            5,000          0      3,500      8,500",
            "south           5,000     43,301      3,500     51,801",
            "note: made up",
        ] {
            assert!(told.contains(part), "{part}:\n{told}");
        }
    }
}
