//! Weather files in the format of EnergyPlus.

use super::error::{Fault, WeatherError};
use super::place::{Place, days_of, month_name};
use super::weather::{WeatherFile, WeatherHour, WeatherStation};

/// Larger files are not weather files of a year.
const MOST_BYTES: usize = 16 << 20;
/// Hours of a leap year.
const MOST_HOURS: usize = 8784;
/// Hours of a year of 365 days.
const USUAL_HOURS: usize = 8760;
/// Columns up to the diffuse irradiance.
const FEWEST_COLUMNS: usize = 16;
/// Irradiances from here on mean that none was measured, W/m².
const MISSING_IRRADIANCE: f64 = 9999.0;
/// More than ever arrives at the ground, W/m².
const MOST_IRRADIANCE: f64 = 1500.0;
/// Dew points from here on mean that none was measured, degrees Celsius.
const MISSING_DEW_POINT: f64 = 99.9;

/// Columns of a row, counted from 0 (EnergyPlus, "Auxiliary Programs: EPW data dictionary").
mod column {
    pub(super) const YEAR: usize = 0;
    pub(super) const MONTH: usize = 1;
    pub(super) const DAY: usize = 2;
    pub(super) const HOUR: usize = 3;
    pub(super) const DEW_POINT: usize = 7;
    pub(super) const GLOBAL: usize = 13;
    pub(super) const DIRECT_NORMAL: usize = 14;
    pub(super) const DIFFUSE: usize = 15;
}

/// Reads a weather file of EnergyPlus (EPW). `name` appears in messages only.
///
/// # Errors
/// The first thing that makes the file useless, with its line. What is only doubtful is noted in the file.
pub(super) fn read(name: &str, bytes: &[u8]) -> Result<WeatherFile, WeatherError> {
    if bytes.len() > MOST_BYTES {
        let fault =
            Fault::whole("the file is larger than 16 MiB, which no weather file is; choose another one");
        return Err(fault.in_file(name));
    }
    let text = crate::encoding::decode(bytes);
    read_text(&text).map_err(|fault| fault.in_file(name))
}

fn read_text(text: &str) -> Result<WeatherFile, Fault> {
    // Old Macs end lines with a single CR, and a transfer may have doubled it.
    let joined = text.replace("\r\n", "\n").replace('\r', "\n");
    let mut lines = (1..).zip(joined.lines()).filter(|(_, line)| !line.trim().is_empty());
    let Some((line, first)) = lines.next() else {
        return Err(Fault::whole("the file is empty; get it again from its source"));
    };
    let (station, place) = location(line, first)?;
    let mut notes: Vec<String> = place.doubt().into_iter().collect();
    data_periods(&mut lines)?;
    let mut hours = Vec::new();
    let mut counts = Counts::default();
    for (line, row) in lines {
        if hours.len() == MOST_HOURS {
            return Err(Fault::at(
                line,
                format!("more than {MOST_HOURS} hours follow, which no year has; choose a file of one year"),
            ));
        }
        hours.push(hour(line, row, &mut counts)?);
    }
    if hours.is_empty() {
        return Err(Fault::whole("no hour follows the header; get the file again from its source"));
    }
    counts.note(&mut notes);
    note_order(&hours, &mut notes);
    Ok(WeatherFile::new(station, place, hours, notes))
}

/// `LOCATION,city,region,country,source,station,latitude,longitude,zone,elevation`.
fn location(line: usize, text: &str) -> Result<(WeatherStation, Place), Fault> {
    let fields: Vec<&str> = text.split(',').map(str::trim).collect();
    if !fields[0].eq_ignore_ascii_case("LOCATION") {
        return Err(Fault::at(
            line,
            "this is no EPW file, whose first line starts with LOCATION; choose an .epw file",
        ));
    }
    let text_of = |index: usize| fields.get(index).copied().unwrap_or_default().to_owned();
    let number_of = |index: usize, what: &str| {
        let word = fields.get(index).copied().unwrap_or_default();
        number(word).ok_or_else(|| {
            Fault::at(
                line,
                format!("{what} should stand in field {}, but {} is no number", index + 1, quoted(word)),
            )
        })
    };
    let (latitude, longitude) = (number_of(6, "the latitude")?, number_of(7, "the longitude")?);
    let zone = number_of(8, "the time zone")?;
    let place = Place::new(latitude, longitude, zone).map_err(|error| Fault::at(line, error.to_string()))?;
    // Nothing hangs on it, and some files leave it out.
    let altitude = fields.get(9).and_then(|word| number(word)).unwrap_or(0.0);
    let station = WeatherStation {
        city: text_of(1),
        region: text_of(2),
        country: text_of(3),
        source: text_of(4),
        number: text_of(5),
        altitude,
    };
    Ok((station, place))
}

/// Skips the header up to its last line, `DATA PERIODS,periods,records per hour,...`.
fn data_periods<'a>(lines: &mut impl Iterator<Item = (usize, &'a str)>) -> Result<(), Fault> {
    for (line, text) in lines.by_ref() {
        let mut fields = text.split(',').map(str::trim);
        if !fields.next().is_some_and(|word| word.eq_ignore_ascii_case("DATA PERIODS")) {
            continue;
        }
        let per_hour = fields.nth(1).unwrap_or_default();
        return match number(per_hour) {
            Some(1.0) => Ok(()),
            Some(count) => Err(Fault::at(
                line,
                format!(
                    "the file has {count} records per hour, but only files of one are read; choose an hourly \
                     file"
                ),
            )),
            None => Err(Fault::at(
                line,
                format!(
                    "the records per hour should stand in field 3, but {} is no number",
                    quoted(per_hour)
                ),
            )),
        };
    }
    Err(Fault::whole(
        "no line starts with DATA PERIODS, the end of an EPW header; get the file again from its source",
    ))
}

/// How often something doubtful was met.
#[derive(Default)]
struct Counts {
    negative: usize,
    excessive: usize,
}

impl Counts {
    fn note(&self, notes: &mut Vec<String>) {
        let mut note = |count: usize, what: &str| {
            if count > 0 {
                notes.push(format!("{count} irradiances {what} and count as missing"));
            }
        };
        note(self.negative, "are negative");
        note(self.excessive, "exceed 1500 W/m²");
    }

    /// The irradiance of a field in W/m²; none where it is missing.
    fn irradiance(&mut self, value: Option<f64>) -> Option<f64> {
        let value = value.filter(|&value| value < MISSING_IRRADIANCE)?;
        self.negative += usize::from(value < 0.0);
        self.excessive += usize::from(value > MOST_IRRADIANCE);
        (0.0..=MOST_IRRADIANCE).contains(&value).then_some(value)
    }
}

fn hour(line: usize, row: &str, counts: &mut Counts) -> Result<WeatherHour, Fault> {
    let fields: Vec<&str> = row.split(',').map(str::trim).collect();
    if fields.len() < FEWEST_COLUMNS {
        return Err(Fault::at(
            line,
            format!(
                "the row has {} values, but needs {FEWEST_COLUMNS} up to the diffuse irradiance; it is \
                 incomplete",
                fields.len()
            ),
        ));
    }
    let whole = |index: usize, what: &str, least: i32, most: i32| {
        let word = fields[index];
        let value = number(word).unwrap_or(f64::NAN);
        // Casting saturates and makes NaN 0, so that the comparison catches everything.
        let count = value as i32;
        if f64::from(count) == value && (least..=most).contains(&count) {
            return Ok(count);
        }
        Err(Fault::at(
            line,
            format!("the {what} is {}, but must be a whole number from {least} to {most}", quoted(word)),
        ))
    };
    let month = whole(column::MONTH, "month", 1, 12)? as u32;
    let day = whole(column::DAY, "day", 1, days_of(month, true) as i32)? as u32;
    let optional = |index: usize| -> Result<Option<f64>, Fault> {
        let word = fields[index];
        if word.is_empty() {
            return Ok(None);
        }
        let wrong = || {
            let column = index + 1;
            Fault::at(
                line,
                format!("a number should stand in field {column}, but there is {}; correct it", quoted(word)),
            )
        };
        number(word).map(Some).ok_or_else(wrong)
    };
    Ok(WeatherHour {
        year: whole(column::YEAR, "year", 0, 9999)?,
        month,
        day,
        hour: whole(column::HOUR, "hour", 1, 24)? as u32,
        direct_normal: counts.irradiance(optional(column::DIRECT_NORMAL)?),
        diffuse_horizontal: counts.irradiance(optional(column::DIFFUSE)?),
        global_horizontal: counts.irradiance(optional(column::GLOBAL)?),
        dew_point: optional(column::DEW_POINT)?.filter(|&celsius| celsius.abs() < MISSING_DEW_POINT),
    })
}

/// Notes rows that are missing, doubled or out of order.
fn note_order(hours: &[WeatherHour], notes: &mut Vec<String>) {
    if hours.len() != USUAL_HOURS && hours.len() != MOST_HOURS {
        notes.push(format!(
            "the file holds {} hours, and a year has {USUAL_HOURS} or {MOST_HOURS}",
            hours.len()
        ));
    }
    let key = |hour: &WeatherHour| (hour.month, hour.day, hour.hour);
    if let Some(pair) = hours.windows(2).find(|pair| key(&pair[0]) >= key(&pair[1])) {
        let [_, next] = pair else { return };
        notes.push(format!(
            "hour {} of {} {} is out of order or there twice; the first counts",
            next.hour,
            next.day,
            month_name(next.month)
        ));
    }
}

/// A finite number.
fn number(word: &str) -> Option<f64> {
    let begins = word.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c));
    word.parse().ok().filter(|value: &f64| begins && value.is_finite())
}

/// A word of a message: short, without control characters, in quotation marks.
fn quoted(word: &str) -> String {
    let short: String = word.chars().take(24).map(|c| if c.is_control() { '?' } else { c }).collect();
    let more = if word.chars().count() > 24 { "..." } else { "" };
    format!("'{short}{more}'")
}
