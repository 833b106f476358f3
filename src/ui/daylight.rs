//! The sky over the scene as the user asks for it: what it comes to, how lamps go with it, and a day that plays.

use super::app::App;
use super::command::EditKey;
use super::state::Edits;
use crate::daylight::{DayLength, Phase};
use crate::scene::{DaylightChoice, LampState, Lighting, OutdoorSwitch, Outdoors, Scene, SceneSource};
use std::path::Path;
use std::sync::Arc;

/// A day plays in so many seconds.
const PLAYED_SECS: f64 = 10.0;
/// The handle goes so far beyond sunrise and sunset, hours.
const BEYOND: f64 = 0.5;

/// What daylight that was asked for comes to.
#[derive(Clone, Debug)]
pub(super) struct Day {
    /// As it was asked for, lamps left out.
    pub(super) choice: DaylightChoice,
    /// The sky of the hour.
    pub(super) outdoors: Outdoors,
    /// When the sun rises and sets, where there is a place.
    pub(super) length: Option<DayLength>,
}

impl Day {
    fn new(scene: &Scene, choice: &DaylightChoice, before: Option<&Self>) -> Result<Self, String> {
        let choice = choice.without_lamps();
        let outdoors = scene
            .outdoors_for(&choice, before.map(|day| &day.outdoors))
            .map_err(|error| error.to_string())?;
        let of_day = |choice: &DaylightChoice| {
            (choice.latitude, choice.longitude, choice.zone, choice.date.clone(), choice.weather.clone())
        };
        let same = before.filter(|before| of_day(&before.choice) == of_day(&choice));
        let length = match same {
            Some(before) => before.length,
            None => {
                let station = outdoors.weather.as_ref().map(|file| file.place());
                let place = station.or(choice.place().ok().flatten()).filter(|_| choice.sun.is_none());
                place.zip(choice.date().ok()).and_then(|(place, date)| DayLength::of(place, date).ok())
            }
        };
        Ok(Self { choice, outdoors, length })
    }

    /// Hours since midnight.
    pub(super) fn hours(&self) -> f64 {
        self.choice.hours().unwrap_or(12.0)
    }

    /// From before sunrise to after sunset, hours; the whole day where the present hour lies outside of that.
    pub(super) fn range(&self) -> [f64; 2] {
        match self.length {
            Some(DayLength::Between { rise, set }) if set > rise => {
                let quarters = |hours: f64| (4.0 * hours).round() / 4.0;
                let range = [quarters(rise - BEYOND).max(0.0), quarters(set + BEYOND).min(LAST)];
                if (range[0]..=range[1]).contains(&self.hours()) { range } else { [0.0, LAST] }
            }
            _ => [0.0, LAST],
        }
    }

    /// Whether it is day, twilight or night.
    pub(super) fn phase(&self) -> Phase {
        Phase::of(self.outdoors.daylight.sun())
    }

    fn exitances(&self) -> [f64; 2] {
        [self.outdoors.sky_exitance(), self.outdoors.sun_exitance()]
    }
}

/// The last minute of a day, hours.
pub(super) const LAST: f64 = 24.0 - 1.0 / 60.0;

/// "14:30" of hours since midnight.
pub(super) fn clock(hours: f64) -> String {
    let minutes = (60.0 * hours).round().clamp(0.0, 1439.0) as u32;
    format!("{:02}:{:02}", minutes / 60, minutes % 60)
}

/// The day that a scene without one is offered: noon of midsummer in the middle of Europe.
pub(super) fn first_choice() -> DaylightChoice {
    DaylightChoice {
        latitude: Some(51.51),
        longitude: Some(-0.13),
        zone: Some(1.0),
        date: Some("2026-06-21".to_owned()),
        time: Some("12:00".to_owned()),
        sky: Some("clear".to_owned()),
        ..DaylightChoice::default()
    }
}

/// How a sidecar names a weather file: by its name alone where it lies beside the model, else by its whole path.
fn weather_name(source: &SceneSource, path: &Path) -> String {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let beside = source.path().and_then(|model| std::path::absolute(model).ok());
    let is_beside = beside.is_some_and(|model| model.parent() == whole.parent());
    let name = whole.file_name().filter(|_| is_beside).map(Path::new);
    name.unwrap_or(&whole).to_string_lossy().into_owned()
}

/// A day that plays, and where it stands.
#[derive(Clone, Copy, Debug)]
pub(super) struct DayPlaying {
    hours: f64,
}

/// Puts the lamps of sky and sun from one hour to another.
fn at_hour(states: &mut [LampState], from: [f64; 2], to: [f64; 2], known: [Option<OutdoorSwitch>; 2]) {
    for (((state, from), to), known) in states.iter_mut().zip(from).zip(to).zip(known) {
        *state = OutdoorSwitch::of(state, from, known).state(to);
    }
}

/// The lamps as they stand for the light of a scene, which may be of another hour than the user has asked for by now.
pub(super) fn lighting_for(edits: &Edits, day: Option<&Day>, scene: &Scene) -> Lighting {
    let mut lighting = edits.lighting.clone();
    if let (Some(day), Some(outdoors), Some(choice)) = (day, &scene.outdoors, &edits.daylight)
        && lighting.lamps.len() == scene.luminaires.len()
    {
        let to = [outdoors.sky_exitance(), outdoors.sun_exitance()];
        if day.exitances() != to
            && let Some(states) = lighting.lamps.get_mut(outdoors.sky as usize..=outdoors.sun as usize)
        {
            at_hour(states, day.exitances(), to, [choice.sky_lamp, choice.sun_lamp]);
        }
    }
    lighting
}

impl App {
    /// As [`lighting_for`], by the present edits.
    pub(super) fn lighting_for(&self, scene: &Scene) -> Lighting {
        lighting_for(&self.edits, self.day.as_ref(), scene)
    }

    /// Takes over the scene that has come to the screen under another sky.
    pub(super) fn follow_sky(&mut self) {
        if let (Some(prepared), Some(shown)) = (&self.picture.prepared, &self.scene_shown)
            && !Arc::ptr_eq(&prepared.scene, shown)
        {
            self.scene_shown = Some(Arc::clone(&prepared.scene));
        }
    }

    /// The light of all patches as the lamps stand.
    pub(super) fn settle_picture(&mut self) {
        if let Some(prepared) = self.picture.prepared.clone() {
            let lighting = self.lighting_for(&prepared.scene);
            self.picture.settle(&lighting);
        }
    }

    /// What the edits ask for of the sky, worked out anew where that has changed.
    pub(super) fn follow_day(&mut self) {
        let Some(scene) = &self.scene_shown else { return };
        let Some(choice) = &self.edits.daylight else {
            self.day = None;
            return;
        };
        if self.day.as_ref().is_none_or(|day| day.choice != choice.without_lamps()) {
            self.day = Day::new(scene, choice, self.day.as_ref()).ok();
        }
    }

    /// The edits with this daylight, or without any; what cannot be is told and changes nothing.
    pub(super) fn with_daylight(&mut self, choice: Option<&DaylightChoice>) -> Option<Edits> {
        self.follow_day();
        let scene = Arc::clone(self.scene_shown.as_ref()?);
        let mut edits = self.edits.clone();
        let own = scene.own_luminaires();
        let known = edits.daylight.take();
        let lamps = &mut edits.lighting.lamps;
        let Some(choice) = choice else {
            if known.is_some() && lamps.len() >= own + 2 {
                lamps.drain(own..own + 2);
            }
            return Some(edits);
        };
        let day = match Day::new(&scene, choice, self.day.as_ref()) {
            Ok(day) => day,
            Err(fault) => {
                self.complain(fault);
                return None;
            }
        };
        let mut choice = choice.without_lamps();
        match (&self.day, known) {
            (Some(before), Some(known)) if lamps.len() >= own + 2 => {
                let from = before.exitances();
                let states = &mut lamps[own..own + 2];
                let switch = |k: usize, known| OutdoorSwitch::of(&states[k], from[k], known);
                choice.sky_lamp = Some(switch(0, known.sky_lamp));
                choice.sun_lamp = Some(switch(1, known.sun_lamp));
                at_hour(states, from, day.exitances(), [choice.sky_lamp, choice.sun_lamp]);
            }
            _ => {
                let states = day.outdoors.states();
                let at = own.min(lamps.len());
                lamps.splice(at..at, states);
            }
        }
        edits.daylight = Some(choice);
        Some(edits)
    }

    /// Takes place, clocks and sky from a weather file, at the present date and hour; what makes it useless is told and
    /// changes nothing.
    pub(super) fn take_weather(&mut self, path: &Path) {
        let Some(scene) = self.scene_shown.clone() else {
            self.complain("Open a scene first: a weather file gives it a sky".to_owned());
            return;
        };
        let before = self.edits.daylight.clone().unwrap_or_else(first_choice);
        let weather = Some(weather_name(&scene.source, path));
        let mut choice = DaylightChoice {
            weather,
            sun: None,
            sky: None,
            lux: None,
            irradiance: None,
            ..before.without_lamps()
        };
        match scene.outdoors_for(&choice, None) {
            Ok(outdoors) => {
                if let Some(place) = outdoors.weather.map(|file| file.place()) {
                    // They stay when the file is left again.
                    (choice.latitude, choice.longitude) = (Some(place.latitude()), Some(place.longitude()));
                    choice.zone = Some(place.zone());
                }
            }
            Err(fault) => {
                self.complain(fault.to_string());
                return;
            }
        }
        self.day_playing = None;
        if let Some(edits) = self.with_daylight(Some(&choice)) {
            self.history.seal();
            self.apply(EditKey::Daylight, edits);
            self.history.seal();
        }
    }

    /// Has the scene lit by the daylight that is wanted now.
    pub(super) fn send_daylight(&mut self) {
        if let Some(read) = self.lampless.read() {
            self.worker.set_daylight(read, self.edits.daylight.clone());
        }
    }

    /// Begins to play the day, or ends that.
    pub(super) fn toggle_day(&mut self) {
        if self.day_playing.take().is_some() {
            self.history.seal();
            return;
        }
        self.follow_day();
        if let Some(day) = self.day.as_ref().filter(|day| day.length.is_some()) {
            self.day_playing = Some(DayPlaying { hours: day.hours() });
            // All of it is one step back.
            self.history.seal();
            self.history.record(EditKey::Daylight, self.edits.clone());
            self.history.seal();
        }
    }

    /// Lets the day that plays go on by `dt` seconds.
    pub(super) fn play_day(&mut self, ctx: &egui::Context, dt: f64) {
        let (Some(mut playing), Some(day)) = (self.day_playing, self.day.clone()) else {
            self.day_playing = None;
            return;
        };
        let [from, to] = day.range();
        playing.hours += dt.clamp(0.0, 0.25) * (to - from) / PLAYED_SECS;
        if playing.hours >= to {
            playing.hours = from;
        }
        self.day_playing = Some(playing);
        ctx.request_repaint();
        let time = clock(playing.hours);
        if day.choice.time.as_ref() != Some(&time) {
            let choice = DaylightChoice { time: Some(time), ..day.choice };
            match self.with_daylight(Some(&choice)) {
                Some(edits) => self.replace_edits(edits),
                None => self.day_playing = None,
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::from_text;

    const OBJ: &str = "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nf 1 2 3 4\n";

    #[test]
    fn the_handle_goes_from_dawn_to_dusk_and_through_the_night_where_it_stands_there() {
        let scene = from_text("floor", OBJ, "", Some("[daylight]\nsun = [35, 150]\n")).unwrap();
        let at = |time: &str| DaylightChoice { time: Some(time.to_owned()), ..first_choice() };
        let day = Day::new(&scene, &at("12:00"), None).unwrap();
        let [dawn, dusk] = day.range();
        assert!((3.5..5.0).contains(&dawn) && (21.0..22.5).contains(&dusk), "{dawn} to {dusk}");
        assert_eq!(day.phase(), Phase::Day);
        let night = Day::new(&scene, &at("01:00"), Some(&day)).unwrap();
        assert_eq!((night.range(), night.length), ([0.0, LAST], day.length));
        assert_ne!(night.phase(), Phase::Day);
        let pole = DaylightChoice { latitude: Some(90.0), ..at("12:00") };
        assert_eq!(Day::new(&scene, &pole, None).unwrap().length, Some(DayLength::AlwaysUp));
        let wrong = DaylightChoice { date: Some("2026-02-30".to_owned()), ..at("12:00") };
        assert!(Day::new(&scene, &wrong, None).is_err());
        assert_eq!([clock(9.5), clock(24.0), clock(-1.0)], ["09:30", "23:59", "00:00"]);
    }

    #[test]
    fn a_weather_file_beside_the_model_goes_by_its_name() {
        let source = SceneSource::File("/models/office.obj".into());
        assert_eq!(weather_name(&source, Path::new("/models/berlin.epw")), "berlin.epw");
        assert_eq!(weather_name(&source, Path::new("/weather/berlin.epw")), "/weather/berlin.epw");
        let house = SceneSource::Builtin("house".to_owned());
        assert_eq!(weather_name(&house, Path::new("/weather/berlin.epw")), "/weather/berlin.epw");
    }

    #[test]
    fn a_tint_lasts_through_the_night() {
        let full = |exitance: f64| LampState { on: true, dimmer: 0.5, exitance: [exitance; 3] };
        let mut states = [full(50.0), full(400.0)];
        states[0].exitance = [25.0, 50.0, 100.0];
        let switches = [0, 1].map(|k| Some(OutdoorSwitch::of(&states[k], [50.0, 400.0][k], None)));
        at_hour(&mut states, [50.0, 400.0], [0.0, 0.0], switches);
        assert!(states.iter().all(|state| state.output() == [0.0; 3] && state.dimmer == 0.5));
        let switches = [0, 1].map(|k| Some(OutdoorSwitch::of(&states[k], 0.0, switches[k])));
        at_hour(&mut states, [0.0, 0.0], [10.0, 100.0], switches);
        assert_eq!(states[0].exitance, [5.0, 10.0, 20.0]);
        assert_eq!(states[1].exitance, [100.0; 3]);
    }
}
