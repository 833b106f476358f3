//! The sky and the sun outside of a scene, as lamps of it.

use super::error::SceneError;
use super::lookup::{Files, reason};
use super::names;
use super::sidecar::Source;
use super::types::{LampState, Luminaire, Scene, UpAxis};
use crate::daylight::{
    CieType, Compass, Date, Daylight, DaylightError, LUMINOUS_EFFICACY, LocalTime, Pattern, Place,
    SunPosition, USUAL_GROUND, USUAL_WATER, WeatherFile,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Daylight as a sidecar or a user asks for it. Angles are degrees, azimuths from north clockwise.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
pub struct DaylightChoice {
    /// North positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub latitude: Option<f64>,
    /// East positive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub longitude: Option<f64>,
    /// Hours by which the clocks are ahead of UTC, summer time included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<f64>,
    /// By which the north of the model is turned, clockwise as seen from above, from -z (y up) or +y (z up).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub north: Option<f64>,
    /// `YYYY-MM-DD`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// `HH:MM`, as the clocks of the place show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<String>,
    /// Elevation and azimuth of the sun, instead of a place and a time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun: Option<[f64; 2]>,
    /// A sky of the CIE: 1 to 16, or clear, intermediate, overcast or uniform.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky: Option<String>,
    /// Illuminances in lux, direct normal and diffuse horizontal; those that such weather usually gives otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lux: Option<[f64; 2]>,
    /// Irradiances in W/m², direct normal and diffuse horizontal, for an all-weather sky of Perez.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub irradiance: Option<[f64; 2]>,
    /// An EPW file beside the model, for the sky of its hour.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weather: Option<String>,
    /// Reflectance of the ground beyond the model, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ground: Option<f64>,
}

/// Sky, sun and ground around a model. The sky and the ground shine as one lamp, the sun as another.
#[derive(Clone, Debug, PartialEq)]
pub struct Outdoors {
    /// Luminances by direction.
    pub daylight: Daylight,
    /// How the model lies.
    pub compass: Compass,
    /// As it was asked for.
    pub choice: DaylightChoice,
    /// Index of the lamp that is the sky.
    pub sky: u32,
    /// Of the one that is the sun; dark where it does not shine.
    pub sun: u32,
}

/// Names of these lamps.
pub const SKY: &str = "Sky";
/// See [`SKY`].
pub const SUN: &str = "Sun";

impl Outdoors {
    /// Exitance that the sky counts by, W/m² per band: that of a uniform sky which lights the horizontal as it does.
    pub fn sky_exitance(&self) -> f64 {
        let sky = self.daylight.sky().horizontal();
        // Without a sky there may be a ground that the sun lights.
        let ground = std::f64::consts::PI * self.daylight.ground_luminance();
        if sky > 0.0 { sky / LUMINOUS_EFFICACY } else { ground / LUMINOUS_EFFICACY }
    }

    /// Irradiance of a surface that faces the sun, W/m² per band.
    pub fn sun_exitance(&self) -> f64 {
        self.daylight.direct_normal() / LUMINOUS_EFFICACY
    }

    /// Radiance of sky or ground in a direction of the model, W/(m² sr) per band; without the sun's disc.
    pub fn radiance(&self, direction: DVec3) -> f64 {
        self.daylight.radiance(self.compass.to_sky(direction))
    }

    /// Unit vector to the sun, in the axes of the model.
    pub fn to_sun(&self) -> DVec3 {
        self.compass.to_model(self.daylight.sun().direction())
    }
}

/// The sky that a word or a number names.
fn sky_of(text: &str) -> Result<Pattern, DaylightError> {
    let kind = match text.trim().to_ascii_lowercase().as_str() {
        "clear" => CieType::CLEAR,
        "intermediate" => CieType::INTERMEDIATE,
        "overcast" => CieType::OVERCAST,
        "uniform" => return Ok(Pattern::Uniform),
        number => match number.parse() {
            Ok(number) => CieType::new(number)?,
            Err(_) => {
                let text = names::short(text);
                return Err(DaylightError::new(format!(
                    "the sky '{text}' is none; write clear, intermediate, overcast, uniform or 1 to 16"
                )));
            }
        },
    };
    Ok(Pattern::Cie(kind))
}

fn number_parts<const N: usize>(text: &str, between: char) -> Option<[u32; N]> {
    let parts: Vec<u32> = text.trim().split(between).map(str::parse).collect::<Result<_, _>>().ok()?;
    parts.try_into().ok()
}

impl DaylightChoice {
    fn date(&self) -> Result<Date, DaylightError> {
        let text = self.date.as_deref().unwrap_or("2026-06-21");
        let [year, month, day] = number_parts(text, '-').ok_or_else(|| {
            let text = names::short(text);
            DaylightError::new(format!("the date '{text}' is none; write it as 2026-06-21"))
        })?;
        Date::new(i32::try_from(year).unwrap_or(i32::MAX), month, day)
    }

    fn hours(&self) -> Result<f64, DaylightError> {
        let text = self.time.as_deref().unwrap_or("12:00");
        let [hours, minutes] =
            number_parts(text, ':').filter(|[_, minutes]| *minutes < 60).ok_or_else(|| {
                let text = names::short(text);
                DaylightError::new(format!("the time '{text}' is none; write it as 14:30"))
            })?;
        Ok(f64::from(hours) + f64::from(minutes) / 60.0)
    }

    /// Where the sun stands.
    fn position(&self) -> Result<SunPosition, DaylightError> {
        if let Some([elevation, azimuth]) = self.sun {
            return SunPosition::new(elevation, azimuth);
        }
        match (self.latitude, self.longitude, self.zone) {
            (Some(latitude), Some(longitude), Some(zone)) => {
                let place = Place::new(latitude, longitude, zone)?;
                SunPosition::at(place, LocalTime::new(self.date()?, self.hours()?)?)
            }
            (None, None, None) => Err(DaylightError::new(
                "daylight needs latitude, longitude and zone, or sun = [elevation, azimuth], or a weather file",
            )),
            _ => Err(DaylightError::new("daylight needs latitude, longitude and zone, all three")),
        }
    }

    /// The light that is asked for; `weather` is that of the file that it names.
    fn daylight(&self, weather: Option<&WeatherFile>) -> Result<Daylight, DaylightError> {
        let ground = self.ground.unwrap_or(USUAL_GROUND);
        if let Some(file) = weather {
            let date = self.date()?;
            return file.daylight(file.hour(date.month(), date.day(), self.hours()?)?, ground);
        }
        let (sun, day) = (self.position()?, self.date()?.day_of_year());
        if let Some([direct, diffuse]) = self.irradiance {
            return Daylight::of_irradiances(direct, diffuse, sun, day, USUAL_WATER, ground);
        }
        let pattern = sky_of(self.sky.as_deref().unwrap_or("clear"))?;
        match (self.lux, pattern) {
            (Some([direct, diffuse]), pattern) => Daylight::new(pattern, sun, diffuse, direct, ground),
            (None, Pattern::Cie(kind)) => Daylight::of_type(kind, sun, day, ground),
            (None, _) => {
                let usual = Daylight::of_type(CieType::OVERCAST, sun, day, ground)?;
                Daylight::new(pattern, sun, usual.sky().horizontal(), 0.0, ground)
            }
        }
    }
}

/// What a sidecar's daylight comes to.
///
/// # Errors
/// A place, a time or an illuminance that cannot be, or a weather file that cannot be read.
pub(super) fn read(
    choice: &toml::Spanned<DaylightChoice>,
    files: Files<'_>,
    source: Source<'_>,
) -> Result<(Daylight, DaylightChoice), SceneError> {
    let (at, choice) = (choice.span().start, choice.get_ref());
    let fail = |fault: String| source.error_at(at, fault);
    let weather = match &choice.weather {
        None => None,
        Some(name) => {
            let shown = names::short(name);
            let found = files.photometry(name).map_err(|error| {
                fail(format!("the daylight asks for the weather file '{shown}', but {}", reason(&error)))
            })?;
            let read = WeatherFile::read(&shown, &found.bytes);
            Some(read.map_err(|error| fail(format!("the weather file cannot be used: {error}")))?)
        }
    };
    let daylight = choice.daylight(weather.as_ref()).map_err(|error| fail(error.to_string()))?;
    Ok((daylight, choice.clone()))
}

impl Scene {
    /// Puts a sky over the scene and a sun into it: lamps after those of the model.
    pub(super) fn set_outdoors(&mut self, daylight: Daylight, choice: DaylightChoice) {
        let north = choice.north.unwrap_or(0.0);
        let compass = match self.up {
            UpAxis::Y => Compass::y_up(north),
            UpAxis::Z => Compass::z_up(north),
        };
        let sky = self.luminaires.len() as u32;
        let outdoors = Outdoors { daylight, compass, choice, sky, sun: sky + 1 };
        for (name, exitance) in [(SKY, outdoors.sky_exitance()), (SUN, outdoors.sun_exitance())] {
            let mut taken = self.luminaires.iter().map(|lamp| lamp.name.clone()).collect();
            self.luminaires.push(Luminaire {
                name: names::unique(name, &mut taken),
                area: 1.0,
                initial: LampState { on: true, dimmer: 1.0, exitance: [exitance; 3] },
                photometric: None,
            });
        }
        self.outdoors = Some(outdoors);
    }
}
