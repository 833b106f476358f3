//! The sky and the sun outside of a scene, as lamps of it.

use super::error::SceneError;
use super::lookup::{Files, reason};
use super::names;
use super::sidecar::Source;
use super::types::{LampState, Luminaire, Scene, SceneSource, UpAxis};
use crate::daylight::{
    CieType, Compass, Date, Daylight, DaylightError, LUMINOUS_EFFICACY, LocalTime, Pattern, Place,
    SunPosition, USUAL_GROUND, USUAL_WATER, WeatherFile,
};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::sync::Arc;

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
    /// How the sky is switched at first; fully on otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sky_lamp: Option<OutdoorSwitch>,
    /// The same of the sun.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sun_lamp: Option<OutdoorSwitch>,
}

/// How the sky or the sun is switched, dimmed and coloured, whatever the hour.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OutdoorSwitch {
    /// Whether it shines.
    pub on: bool,
    /// 0 to 1.
    pub dimmer: f64,
    /// What the light of the hour is multiplied by, per band; zero or more.
    pub factor: [f64; 3],
}

impl Default for OutdoorSwitch {
    fn default() -> Self {
        Self { on: true, dimmer: 1.0, factor: [1.0; 3] }
    }
}

impl OutdoorSwitch {
    /// That of a lamp in this state, whose light is `exitance` at this hour, W/m² per band; `before` tells the factor
    /// where that is dark.
    pub fn of(state: &LampState, exitance: f64, before: Option<Self>) -> Self {
        let before = before.unwrap_or_default();
        let factor = if exitance > 0.0 { state.exitance.map(|e| e / exitance) } else { before.factor };
        // What is the same up to rounding is the same.
        let is_plain = factor.iter().all(|f| (f - 1.0).abs() < 1e-9);
        Self { on: state.on, dimmer: state.dimmer, factor: if is_plain { [1.0; 3] } else { factor } }
    }

    /// The state of a lamp whose light is `exitance` at this hour, W/m² per band.
    pub fn state(&self, exitance: f64) -> LampState {
        LampState { on: self.on, dimmer: self.dimmer, exitance: self.factor.map(|f| f * exitance) }
    }

    fn is_valid(&self) -> bool {
        (0.0..=1.0).contains(&self.dimmer) && self.factor.iter().all(|f| (0.0..=1e6).contains(f))
    }
}

/// Sky, sun and ground around a model. The sky and the ground shine as one lamp, the sun as another.
#[derive(Clone, Debug, PartialEq)]
pub struct Outdoors {
    /// Luminances by direction.
    pub daylight: Daylight,
    /// How the model lies.
    pub compass: Compass,
    /// The same were its north not turned: what is fixed to the model is told by this.
    pub upright: Compass,
    /// As it was asked for.
    pub choice: DaylightChoice,
    /// The weather file that this names.
    pub weather: Option<Arc<WeatherFile>>,
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

    /// As it was asked for, with the lamps in these states.
    pub fn switched(&self, lighting: &super::Lighting) -> DaylightChoice {
        let switch = |lamp: u32, exitance: f64, before: Option<OutdoorSwitch>| {
            let state = lighting.lamps.get(lamp as usize)?;
            let switch = OutdoorSwitch::of(state, exitance, before);
            (switch != OutdoorSwitch::default()).then_some(switch)
        };
        DaylightChoice {
            sky_lamp: switch(self.sky, self.sky_exitance(), self.choice.sky_lamp),
            sun_lamp: switch(self.sun, self.sun_exitance(), self.choice.sun_lamp),
            ..self.choice.clone()
        }
    }

    /// The two lamps as they are switched at first.
    pub fn states(&self) -> [LampState; 2] {
        let DaylightChoice { sky_lamp, sun_lamp, .. } = &self.choice;
        [(sky_lamp, self.sky_exitance()), (sun_lamp, self.sun_exitance())]
            .map(|(lamp, exitance)| lamp.unwrap_or_default().state(exitance))
    }

    /// What the lamp of the sky counts by: its exitance, or 1 where it is dark.
    pub fn sky_unit(&self) -> f64 {
        let exitance = self.sky_exitance();
        if exitance > 0.0 && exitance.is_finite() { exitance } else { 1.0 }
    }

    /// Whether this is the sky that daylight factors are defined under: the traditional overcast sky of the CIE, without
    /// direct sun, at any brightness above zero.
    pub fn is_reference(&self) -> bool {
        let sky = self.daylight.sky();
        let is_overcast = sky.pattern() == Pattern::Cie(CieType::OVERCAST) && sky.horizontal() > 0.0;
        is_overcast && self.daylight.direct_normal() <= 0.0
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
    /// The day; midsummer where none is named.
    ///
    /// # Errors
    /// A date that is none.
    pub fn date(&self) -> Result<Date, DaylightError> {
        let text = self.date.as_deref().unwrap_or("2026-06-21");
        let [year, month, day] = number_parts(text, '-').ok_or_else(|| {
            let text = names::short(text);
            DaylightError::new(format!("the date '{text}' is none; write it as 2026-06-21"))
        })?;
        Date::new(i32::try_from(year).unwrap_or(i32::MAX), month, day)
    }

    /// Hours since midnight by the clocks of the place; noon where no time is named.
    ///
    /// # Errors
    /// A time that is none.
    pub fn hours(&self) -> Result<f64, DaylightError> {
        let text = self.time.as_deref().unwrap_or("12:00");
        let [hours, minutes] =
            number_parts(text, ':').filter(|[_, minutes]| *minutes < 60).ok_or_else(|| {
                let text = names::short(text);
                DaylightError::new(format!("the time '{text}' is none; write it as 14:30"))
            })?;
        Ok(f64::from(hours) + f64::from(minutes) / 60.0)
    }

    /// The place, where there is one.
    ///
    /// # Errors
    /// A latitude, longitude or zone that cannot be.
    pub fn place(&self) -> Result<Option<Place>, DaylightError> {
        match (self.latitude, self.longitude, self.zone) {
            (Some(latitude), Some(longitude), Some(zone)) => Place::new(latitude, longitude, zone).map(Some),
            _ => Ok(None),
        }
    }

    /// The same without what says how the lamps are switched.
    #[must_use]
    pub fn without_lamps(&self) -> Self {
        Self { sky_lamp: None, sun_lamp: None, ..self.clone() }
    }

    /// The sky that daylight factors are defined under, over the same ground: the traditional overcast sky of the CIE,
    /// 10,000 lux on the horizontal, lamps of sky and sun as they come.
    #[must_use]
    pub fn reference(&self) -> Self {
        Self {
            north: self.north,
            ground: self.ground,
            // An overcast sky is the same all around: the sun has to be somewhere, and does not shine.
            sun: Some([90.0, 0.0]),
            sky: Some(CieType::OVERCAST.number().to_string()),
            lux: Some([0.0, 10_000.0]),
            ..Self::default()
        }
    }

    /// The same with some of its keys changed, as in "date=2026-06-21 time=14:30 sky=overcast"; pairs of numbers have a
    /// comma between them.
    ///
    /// # Errors
    /// A key that is none, or a value that is no number where one is asked for.
    pub fn changed(&self, text: &str) -> Result<Self, DaylightError> {
        let mut choice = self.clone();
        for word in text.split_whitespace() {
            let shown = names::short(word);
            let fault = |what: &str| DaylightError::new(format!("'{shown}' {what}"));
            let (key, value) =
                word.split_once('=').ok_or_else(|| fault("has no value; write it as time=14:30"))?;
            let number = |value: &str| {
                let number = value.parse::<f64>().ok().filter(|number| number.is_finite());
                number.ok_or_else(|| fault("asks for a number"))
            };
            let pair = || {
                let (a, b) =
                    value.split_once(',').ok_or_else(|| fault("asks for two numbers, as in sun=35,180"))?;
                Ok::<_, DaylightError>([number(a)?, number(b)?])
            };
            match key {
                "latitude" => choice.latitude = Some(number(value)?),
                "longitude" => choice.longitude = Some(number(value)?),
                "zone" => choice.zone = Some(number(value)?),
                "north" => choice.north = Some(number(value)?),
                "ground" => choice.ground = Some(number(value)?),
                "date" => choice.date = Some(value.to_owned()),
                "time" => choice.time = Some(value.to_owned()),
                "sky" => choice.sky = Some(value.to_owned()),
                "weather" => choice.weather = Some(value.to_owned()),
                "sun" => choice.sun = Some(pair()?),
                "lux" => choice.lux = Some(pair()?),
                "irradiance" => choice.irradiance = Some(pair()?),
                _ => {
                    return Err(fault(
                        "is no key of daylight: latitude, longitude, zone, north, ground, date, time, sky, weather, \
                         sun, lux, irradiance",
                    ));
                }
            }
        }
        Ok(choice)
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
        if ![self.sky_lamp, self.sun_lamp].iter().flatten().all(OutdoorSwitch::is_valid) {
            return Err(DaylightError::new(
                "the dimmers of sky_lamp and sun_lamp must lie between 0 and 1, and their factors be 0 or more",
            ));
        }
        if !self.north.unwrap_or(0.0).is_finite() {
            return Err(DaylightError::new("north is no angle"));
        }
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
) -> Result<Asked, SceneError> {
    let (at, choice) = (choice.span().start, choice.get_ref());
    let fail = |fault: String| source.error_at(at, fault);
    let weather = match &choice.weather {
        None => None,
        Some(name) => {
            let shown = names::short(name);
            let found = files.companion(name).map_err(|error| {
                fail(format!("the daylight asks for the weather file '{shown}', but {}", reason(&error)))
            })?;
            let read = WeatherFile::read(&shown, &found.bytes);
            Some(read.map_err(|error| fail(format!("the weather file cannot be used: {error}")))?)
        }
    };
    let daylight = choice.daylight(weather.as_ref()).map_err(|error| fail(error.to_string()))?;
    Ok(Asked { daylight, choice: choice.clone(), weather: weather.map(Arc::new) })
}

/// Daylight that was asked for, and what it came to.
pub(super) struct Asked {
    daylight: Daylight,
    choice: DaylightChoice,
    weather: Option<Arc<WeatherFile>>,
}

impl Scene {
    /// Puts a sky over the scene and a sun into it: lamps after those of the model.
    pub(super) fn set_outdoors(&mut self, asked: Asked) {
        let outdoors = self.outdoors_of(asked, self.luminaires.len() as u32);
        for (name, initial) in [SKY, SUN].into_iter().zip(outdoors.states()) {
            let mut taken = self.luminaires.iter().map(|lamp| lamp.name.clone()).collect();
            let name = names::unique(name, &mut taken);
            self.luminaires.push(Luminaire { name, area: 1.0, initial, photometric: None });
        }
        self.outdoors = Some(outdoors);
    }

    fn outdoors_of(&self, asked: Asked, sky: u32) -> Outdoors {
        let Asked { daylight, choice, weather } = asked;
        let turned = |north: f64| match self.up {
            UpAxis::Y => Compass::y_up(north),
            UpAxis::Z => Compass::z_up(north),
        };
        let (compass, upright) = (turned(choice.north.unwrap_or(0.0)), turned(0.0));
        Outdoors { daylight, compass, upright, choice, weather, sky, sun: sky + 1 }
    }

    /// The same scene under another sky: of another hour, place or kind, or none. Everything else stays, and so do the
    /// indices of all luminaires where there was daylight before and there still is.
    ///
    /// # Errors
    /// A place, a time or an illuminance that cannot be, or a weather file that cannot be read.
    pub fn with_daylight(&self, choice: Option<&DaylightChoice>) -> Result<Self, SceneError> {
        let asked = choice.map(|choice| self.asked(choice, None)).transpose()?;
        let mut scene = self.clone();
        match (asked, &self.outdoors) {
            (Some(asked), Some(before)) => {
                let outdoors = self.outdoors_of(asked, before.sky);
                for (lamp, initial) in [outdoors.sky, outdoors.sun].into_iter().zip(outdoors.states()) {
                    if let Some(lamp) = scene.luminaires.get_mut(lamp as usize) {
                        lamp.initial = initial;
                    }
                }
                scene.outdoors = Some(outdoors);
            }
            (asked, before) => {
                // The lamps of the sky stand before those that were placed.
                let placed = scene.placed.clone();
                scene.take_away_placed();
                if before.is_some() {
                    scene.luminaires.truncate(scene.luminaires.len().saturating_sub(2));
                    scene.outdoors = None;
                }
                if let Some(asked) = asked {
                    scene.set_outdoors(asked);
                }
                scene.place(placed);
            }
        }
        Ok(scene)
    }

    /// The sky that daylight comes to over this scene. A weather file that the scene or a sky `known` before has is not
    /// read again.
    ///
    /// # Errors
    /// As [`Self::with_daylight`].
    pub fn outdoors_for(
        &self,
        choice: &DaylightChoice,
        known: Option<&Outdoors>,
    ) -> Result<Outdoors, SceneError> {
        Ok(self.outdoors_of(self.asked(choice, known)?, self.own_luminaires() as u32))
    }

    fn asked(&self, choice: &DaylightChoice, known: Option<&Outdoors>) -> Result<Asked, SceneError> {
        let fail = |fault: String| SceneError::file(&format!("{}.toml", self.name), fault);
        let mut known = [self.outdoors.as_ref(), known].into_iter().flatten();
        let known = known.find(|before| before.choice.weather == choice.weather);
        let weather = match (&choice.weather, known.and_then(|before| before.weather.clone())) {
            (None, _) => None,
            (Some(_), Some(file)) => Some(file),
            (Some(name), None) => {
                let shown = names::short(name);
                let missing = |why: String| fail(format!("the weather file '{shown}' cannot be used: {why}"));
                let folder = match &self.source {
                    SceneSource::File(path) | SceneSource::FileAs(path, _) => path.parent(),
                    SceneSource::Builtin(_) => None,
                };
                let files = Files::beside(folder.unwrap_or(Path::new(".")));
                let found = files.companion(name).map_err(|error| missing(reason(&error)))?;
                let read = WeatherFile::read(&shown, &found.bytes);
                Some(Arc::new(read.map_err(|error| missing(error.to_string()))?))
            }
        };
        let daylight = choice.daylight(weather.as_deref()).map_err(|error| fail(error.to_string()))?;
        Ok(Asked { daylight, choice: choice.clone(), weather })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_changed_by_words_and_faults_name_them() {
        let own = DaylightChoice {
            latitude: Some(52.5),
            sky: Some("clear".to_owned()),
            ..DaylightChoice::default()
        };
        let other = own.changed("time=14:30  sky=overcast lux=0,9000 north=-30").unwrap();
        let expected = DaylightChoice {
            time: Some("14:30".to_owned()),
            sky: Some("overcast".to_owned()),
            lux: Some([0.0, 9000.0]),
            north: Some(-30.0),
            ..own.clone()
        };
        assert_eq!(other, expected);
        assert_eq!(own.changed("").unwrap(), own);
        for (text, told) in
            [("time", "has no value"), ("hour=3", "is no key"), ("zone=two", "a number"), ("sun=3", "two")]
        {
            let fault = own.changed(text).unwrap_err().to_string();
            assert!(fault.contains(told) && fault.contains(text), "{fault}");
        }
        assert!(own.changed("ground=nan").is_err());
    }
}
