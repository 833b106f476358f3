//! The sky over the model: day, hour, kind of sky, place, and what they come to.

use super::{Commands, Model, empty};
use crate::daylight::{Date, DayLength, MONTHS, Phase};
use crate::scene::DaylightChoice;
use crate::ui::command::Command;
use crate::ui::daylight::{Day, clock, first_choice};
use crate::ui::{theme, units};
use egui::{Button, ComboBox, DragValue, RichText, Slider, Ui};

/// Cities: latitude, longitude, and hours ahead of UTC in winter and in summer.
const CITIES: [(&str, f64, f64, [f64; 2]); 12] = [
    ("Berlin", 52.52, 13.41, [1.0, 2.0]),
    ("Cairo", 30.04, 31.24, [2.0, 3.0]),
    ("London", 51.51, -0.13, [0.0, 1.0]),
    ("Los Angeles", 34.05, -118.24, [-8.0, -7.0]),
    ("Mumbai", 19.08, 72.88, [5.5, 5.5]),
    ("New York", 40.71, -74.01, [-5.0, -4.0]),
    ("Paris", 48.86, 2.35, [1.0, 2.0]),
    ("Reykjavik", 64.15, -21.94, [0.0, 0.0]),
    ("Singapore", 1.35, 103.82, [8.0, 8.0]),
    ("Stockholm", 59.33, 18.07, [1.0, 2.0]),
    ("Sydney", -33.87, 151.21, [10.0, 11.0]),
    ("Tokyo", 35.68, 139.65, [9.0, 9.0]),
];

/// Skies by the words of a sidecar, and what they are called.
const SKIES: [(&str, &str); 20] = [
    ("clear", "Clear"),
    ("intermediate", "Intermediate"),
    ("overcast", "Overcast"),
    ("uniform", "Uniform"),
    ("1", "CIE 1: overcast, steep gradation"),
    ("2", "CIE 2: overcast, brighter at the sun"),
    ("3", "CIE 3: overcast, moderate gradation"),
    ("4", "CIE 4: the same, brighter at the sun"),
    ("5", "CIE 5: uniform luminance"),
    ("6", "CIE 6: partly cloudy, uniform"),
    ("7", "CIE 7: partly cloudy, bright sun"),
    ("8", "CIE 8: partly cloudy, solar corona"),
    ("9", "CIE 9: partly cloudy, obscured sun"),
    ("10", "CIE 10: partly cloudy, circumsolar"),
    ("11", "CIE 11: white-blue, solar corona"),
    ("12", "CIE 12: clear, low turbidity"),
    ("13", "CIE 13: clear, polluted"),
    ("14", "CIE 14: cloudless turbid, broad corona"),
    ("15", "CIE 15: white-blue turbid, broad corona"),
    ("16", "CIE 16: traditional overcast"),
];

/// Width of the names at the left and height of a row, points.
const LABEL: f32 = 50.0;
const HEIGHT: f32 = 20.0;

/// Shows the sky over the scene.
pub(in crate::ui) fn show(ui: &mut Ui, model: &Model<'_>, out: &mut Commands) {
    if model.scene.is_none() {
        super::no_scene(ui, model, "No scene is open.");
        return;
    }
    let (Some(day), Some(_)) = (model.day, &model.edits.daylight) else {
        empty(ui, "No sky: light comes from the lamps alone.");
        ui.horizontal(|ui| {
            let tip = "A sky and a sun over the model, by place and time";
            if ui.button("Add daylight").on_hover_text(tip).clicked() {
                out.push(Command::SetDaylight(Some(Box::new(first_choice()))));
            }
            weather_button(ui, out);
        });
        return;
    };
    let mut choice = day.choice.clone();
    match choice.sun {
        Some(_) => sun_by_hand(ui, &mut choice),
        None => {
            hour(ui, model, day, &mut choice, out);
            date(ui, &mut choice);
        }
    }
    sky(ui, day, &mut choice);
    if choice.sun.is_none() && choice.weather.is_none() {
        place(ui, &mut choice);
    }
    surroundings(ui, &mut choice);
    told(ui, day);
    ui.horizontal(|ui| {
        if choice.sun.is_some() {
            let tip = "By place, date and time instead of its position";
            if ui.button("Use place and time").on_hover_text(tip).clicked() {
                let DaylightChoice { latitude, longitude, zone, date, time, .. } = first_choice();
                choice =
                    DaylightChoice { sun: None, latitude, longitude, zone, date, time, ..choice.clone() };
            }
        }
        if choice.sun.is_none() {
            weather_button(ui, out);
        }
        if ui.button("Remove daylight").on_hover_text("Light from the lamps alone").clicked() {
            out.push(Command::SetDaylight(None));
        }
    });
    if choice != day.choice {
        out.push(Command::SetDaylight(Some(Box::new(choice))));
    }
}

fn weather_button(ui: &mut Ui, out: &mut Commands) {
    let tip = "Place, clocks and the sky of the date and hour from an EPW file; it can also be dropped on the window";
    if ui.button("Weather file...").on_hover_text(tip).clicked() {
        out.push(Command::WeatherDialog);
    }
}

/// A row with its name at the left.
fn row(ui: &mut Ui, name: &str, contents: impl FnOnce(&mut Ui, egui::Id)) {
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 6.0;
        let size = egui::vec2(LABEL, HEIGHT);
        let layout = egui::Layout::left_to_right(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_size(size);
            ui.label(name).id
        });
        contents(ui, label.inner);
    });
}

fn hour(ui: &mut Ui, model: &Model<'_>, day: &Day, choice: &mut DaylightChoice, out: &mut Commands) {
    let before = day.hours();
    let mut hours = before;
    row(ui, "Time", |ui, label| {
        let [from, to] = day.range();
        ui.spacing_mut().slider_width = 86.0;
        let slider = Slider::new(&mut hours, from..=to).step_by(1.0 / 60.0).show_value(false);
        ui.add(slider).labelled_by(label);
        let field = DragValue::new(&mut hours)
            .range(0.0..=crate::ui::daylight::LAST)
            .speed(1.0 / 60.0)
            .custom_formatter(|hours, _| clock(hours))
            .custom_parser(parsed);
        ui.add_sized([44.0, HEIGHT], field).on_hover_text("Any hour, by the clocks of the place");
        let (text, tip) = match model.is_day_playing {
            true => ("Stop", "Stay at this hour"),
            false => ("Play", "A day in ten seconds, over and over"),
        };
        let play = ui.add_sized([38.0, HEIGHT], Button::new(text)).on_hover_text(tip);
        if play.accessible_name(format!("{text} the day")).clicked() {
            out.push(Command::ToggleDay);
        }
    });
    let time = clock(hours);
    if time != clock(before) {
        choice.time = Some(time);
    }
    let text = match day.length {
        Some(DayLength::Between { rise, set }) => {
            format!("Sunrise {}, sunset {}", clock(rise), clock(set))
        }
        Some(DayLength::AlwaysUp) => "The sun does not set".to_owned(),
        Some(DayLength::AlwaysDown) => "The sun does not rise".to_owned(),
        None => " ".to_owned(),
    };
    row(ui, "", |ui, _| {
        let text = RichText::new(text).small().color(theme::TEXT_WEAK);
        ui.label(text).on_hover_text(
            "Of the middle of the sun, without refraction: almanacs have it up some minutes longer",
        );
    });
}

/// Hours of "14:30", "14.5" or "14".
fn parsed(text: &str) -> Option<f64> {
    let text = text.trim();
    match text.split_once(':') {
        Some((hours, minutes)) => {
            let (hours, minutes) = (hours.trim().parse::<u32>().ok()?, minutes.trim().parse::<u32>().ok()?);
            (hours < 24 && minutes < 60).then(|| f64::from(hours) + f64::from(minutes) / 60.0)
        }
        None => text.parse().ok(),
    }
}

fn date(ui: &mut Ui, choice: &mut DaylightChoice) {
    let Ok(now) = choice.date() else { return };
    let (mut year, mut month, mut day) = (now.year(), now.month(), now.day());
    row(ui, "Date", |ui, _| {
        let field = DragValue::new(&mut day).range(1..=31).speed(0.1);
        ui.add_sized([30.0, HEIGHT], field).accessible_name("Day");
        let chosen = MONTHS[(month as usize - 1).min(11)];
        let months = ComboBox::from_id_salt("month").width(92.0).selected_text(chosen);
        let shown = months.show_ui(ui, |ui| {
            for (name, number) in MONTHS.into_iter().zip(1..) {
                ui.selectable_value(&mut month, number, name);
            }
        });
        shown.response.accessible_name("Month");
        let field = DragValue::new(&mut year)
            .range(1600..=2999)
            .speed(0.1)
            .custom_formatter(|y, _| format!("{y:.0}"));
        ui.add_sized([46.0, HEIGHT], field).accessible_name("Year");
    });
    // The last day of a month that is shorter.
    let last = (28..=31).rev().find(|&last| Date::new(year, month, last).is_ok()).unwrap_or(28);
    let day = day.min(last);
    if (year, month, day) != (now.year(), now.month(), now.day()) {
        choice.date = Some(format!("{year:04}-{month:02}-{day:02}"));
    }
}

fn sun_by_hand(ui: &mut Ui, choice: &mut DaylightChoice) {
    let Some([elevation, azimuth]) = &mut choice.sun else { return };
    row(ui, "Sun", |ui, _| {
        let field = DragValue::new(elevation).range(-90.0..=90.0).speed(0.2).fixed_decimals(1).suffix("°");
        ui.add_sized([62.0, HEIGHT], field)
            .on_hover_text("Elevation above the horizon")
            .accessible_name("Elevation of the sun");
        let field = DragValue::new(azimuth).range(0.0..=360.0).speed(0.5).fixed_decimals(1).suffix("°");
        ui.add_sized([62.0, HEIGHT], field)
            .on_hover_text("Azimuth from north, clockwise: east 90, south 180")
            .accessible_name("Azimuth of the sun");
    });
}

fn sky(ui: &mut Ui, day: &Day, choice: &mut DaylightChoice) {
    if let Some(file) = choice.weather.clone() {
        row(ui, "Weather", |ui, _| {
            // Room for the button beside it.
            ui.scope(|ui| {
                ui.set_max_width(ui.available_width() - 62.0);
                let name = file.rsplit(['/', '\\']).next().unwrap_or(&file);
                ui.add(egui::Label::new(name).truncate())
                    .on_hover_text(format!("Place and sky of the hour from {file}"));
            });
            let tip = "A clear sky over the same place instead";
            if ui.button("Remove").on_hover_text(tip).accessible_name("Remove the weather file").clicked() {
                if let Some(place) = day.outdoors.weather.as_ref().map(|file| file.place()) {
                    (choice.latitude, choice.longitude) = (Some(place.latitude()), Some(place.longitude()));
                    choice.zone = Some(place.zone());
                }
                choice.weather = None;
                choice.sky = Some("clear".to_owned());
            }
        });
        return;
    }
    if let Some([direct, diffuse]) = choice.irradiance {
        row(ui, "Sky", |ui, _| {
            ui.label(format!("Perez, {direct:.0} + {diffuse:.0} W/m²"))
                .on_hover_text("Direct normal and diffuse horizontal irradiance, as the sidecar gives them");
        });
        return;
    }
    let word = choice.sky.clone().unwrap_or_else(|| "clear".to_owned()).trim().to_lowercase();
    let known = SKIES.into_iter().find(|sky| sky.0 == word);
    let mut chosen = word.clone();
    row(ui, "Sky", |ui, label| {
        let shown = known.map_or(word.as_str(), |sky| sky.1);
        let skies = ComboBox::from_id_salt("sky").width(182.0).truncate().selected_text(shown);
        let shown = skies.height(420.0).show_ui(ui, |ui| {
            for (word, name) in SKIES {
                ui.selectable_value(&mut chosen, word.to_owned(), name);
            }
        });
        shown.response.labelled_by(label);
    });
    if chosen != word {
        choice.sky = Some(chosen);
        // Illuminances that were given are those of another sky.
        choice.lux = None;
    }
}

fn place(ui: &mut Ui, choice: &mut DaylightChoice) {
    let (Some(latitude), Some(longitude)) = (choice.latitude, choice.longitude) else { return };
    let near = |a: f64, b: f64| (a - b).abs() < 0.011;
    let city = CITIES.iter().find(|city| near(city.1, latitude) && near(city.2, longitude));
    let mut chosen = city.map(|city| city.0);
    row(ui, "Place", |ui, label| {
        let shown = chosen.unwrap_or("Elsewhere");
        let places = ComboBox::from_id_salt("place").width(182.0).selected_text(shown);
        let shown = places.show_ui(ui, |ui| {
            for city in CITIES {
                ui.selectable_value(&mut chosen, Some(city.0), city.0);
            }
        });
        shown.response.labelled_by(label);
    });
    if chosen != city.map(|city| city.0)
        && let Some(city) = CITIES.iter().find(|city| Some(city.0) == chosen)
    {
        // Summer time goes with the half of the year; the field beside it is there for the rest.
        let is_north_summer = choice.date().is_ok_and(|date| (4..=10).contains(&date.month()));
        let is_summer = is_north_summer == (city.1 >= 0.0);
        (choice.latitude, choice.longitude) = (Some(city.1), Some(city.2));
        choice.zone = Some(city.3[usize::from(is_summer)]);
        return;
    }
    let DaylightChoice { latitude: Some(latitude), longitude: Some(longitude), zone: Some(zone), .. } =
        choice
    else {
        return;
    };
    row(ui, "", |ui, _| {
        let field = DragValue::new(latitude)
            .range(-90.0..=90.0)
            .speed(0.05)
            .custom_formatter(|x, _| format!("{:.2}° {}", x.abs(), if x < 0.0 { "S" } else { "N" }))
            .custom_parser(|text| degrees(text, 'S'));
        ui.add_sized([62.0, HEIGHT], field).on_hover_text("Latitude").accessible_name("Latitude");
        let field = DragValue::new(longitude)
            .range(-180.0..=180.0)
            .speed(0.05)
            .custom_formatter(|x, _| format!("{:.2}° {}", x.abs(), if x < 0.0 { "W" } else { "E" }))
            .custom_parser(|text| degrees(text, 'W'));
        ui.add_sized([62.0, HEIGHT], field).on_hover_text("Longitude").accessible_name("Longitude");
        let field = DragValue::new(zone)
            .range(-12.0..=14.0)
            .speed(0.02)
            .custom_formatter(|x, _| format!("UTC{}{}", if x < 0.0 { "−" } else { "+" }, x.abs()))
            .custom_parser(|text| {
                text.trim().trim_start_matches("UTC").replace('−', "-").trim_start_matches('+').parse().ok()
            });
        ui.add_sized([50.0, HEIGHT], field)
            .on_hover_text("Hours by which its clocks are ahead of UTC, summer time included")
            .accessible_name("Time zone");
    });
    // As clocks have it.
    *zone = (4.0 * *zone).round() / 4.0;
}

/// Degrees of "52.5", "52.5° N" or "0.13 W", negative where the letter says so.
fn degrees(text: &str, negative: char) -> Option<f64> {
    let number: String =
        text.chars().filter(|c| c.is_ascii_digit() || matches!(c, '.' | '-' | '+')).collect();
    let value: f64 = number.parse().ok()?;
    Some(if text.to_uppercase().contains(negative) { -value.abs() } else { value })
}

fn surroundings(ui: &mut Ui, choice: &mut DaylightChoice) {
    row(ui, "North", |ui, _| {
        let before = choice.north.unwrap_or(0.0);
        let mut north = before;
        let field = DragValue::new(&mut north).range(-360.0..=360.0).speed(0.5).max_decimals(1).suffix("°");
        ui.add_sized([56.0, HEIGHT], field)
            .on_hover_text(
                "By which the model's north is turned, clockwise from above, from -z (y up) or +y (z up)",
            )
            .accessible_name("North");
        if north != before {
            choice.north = Some(north);
        }
        ui.label("Ground");
        let before = 100.0 * choice.ground.unwrap_or(crate::daylight::USUAL_GROUND);
        let mut ground = before;
        let field = DragValue::new(&mut ground).range(0.0..=100.0).speed(0.2).max_decimals(0).suffix(" %");
        ui.add_sized([52.0, HEIGHT], field)
            .on_hover_text("Reflectance of the ground beyond the model")
            .accessible_name("Reflectance of the ground");
        if ground != before {
            choice.ground = Some((ground / 100.0).clamp(0.0, 1.0));
        }
    });
}

/// What it comes to, in as many lines by night as by day.
fn told(ui: &mut Ui, day: &Day) {
    let daylight = &day.outdoors.daylight;
    let sun = daylight.sun();
    let winds = ["N", "NE", "E", "SE", "S", "SW", "W", "NW"];
    let wind = winds[((sun.azimuth() / 45.0).round() as usize) % 8];
    let stands = match sun.is_up() {
        true => format!("{:.1}° high, {:.0}° ({wind})", sun.elevation(), sun.azimuth()),
        false => format!("{:.1}° below, {:.0}° ({wind})", -sun.elevation(), sun.azimuth()),
    };
    let lines = [("Sun", stands), ("Outside", lux(day))];
    for (name, text) in lines {
        row(ui, name, |ui, _| {
            ui.add(egui::Label::new(text).truncate()).on_hover_text(match name {
                "Sun" => "Elevation, and azimuth from north clockwise",
                _ => "Illuminance of the open horizontal: from sky and sun",
            });
        });
    }
    let [sky, direct] = [daylight.sky().horizontal(), daylight.direct_horizontal()].map(units::light);
    let note = match day.phase() {
        Phase::Day => format!("sky {sky} lx, sun {direct} lx"),
        Phase::Twilight => "Twilight: the sky alone".to_owned(),
        Phase::Night => "Night: the sky is dark, lamps go on as they are".to_owned(),
    };
    row(ui, "", |ui, _| {
        ui.add(egui::Label::new(RichText::new(note).small().color(theme::TEXT_WEAK)).truncate());
    });
}

fn lux(day: &Day) -> String {
    format!("{} lx", units::light(day.outdoors.daylight.global_horizontal()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hours_and_degrees_are_read_as_people_write_them() {
        assert_eq!(parsed("14:30"), Some(14.5));
        assert_eq!(parsed(" 7.25 "), Some(7.25));
        assert_eq!([parsed("25:00"), parsed("12:75"), parsed("noon")], [None; 3]);
        assert_eq!(degrees("33.87° S", 'S'), Some(-33.87));
        assert_eq!(degrees("52.52° N", 'S'), Some(52.52));
        assert_eq!(degrees("-0.13", 'W'), Some(-0.13));
        assert_eq!(degrees("north", 'S'), None);
    }

    #[test]
    fn every_sky_and_every_city_of_the_menus_can_be_had() {
        let obj = "v 0 0 0\nv 4 0 0\nv 4 0 -4\nv 0 0 -4\nf 1 2 3 4\n";
        let scene = crate::scene::from_text("floor", obj, "", None).unwrap();
        for (word, name) in SKIES {
            let choice = DaylightChoice { sky: Some(word.to_owned()), ..first_choice() };
            assert!(scene.outdoors_for(&choice, None).is_ok(), "{name}");
        }
        for (city, latitude, longitude, zones) in CITIES {
            for zone in zones {
                let place = crate::daylight::Place::new(latitude, longitude, zone).expect(city);
                assert_eq!(place.doubt(), None, "{city}");
            }
        }
    }
}
