//! Weather by the hour.

use super::epw;
use super::error::{DaylightError, WeatherError};
use super::outdoors::Daylight;
use super::perez::{USUAL_WATER, water_of_dew_point};
use super::place::{Date, LocalTime, Place, is_leap, month_name};
use super::sun::SunPosition;

/// Direct light in so many hours of night is a mistake of zone or longitude, not of a clock by minutes.
const MOST_NIGHT_SUNS: usize = 24;
/// Direct light below this may be scattered light at dawn, W/m².
const LEAST_DIRECT: f64 = 20.0;
/// Global light and the sum of its parts may differ by this share, hour by hour; clocks that run an hour
/// wrong make it 14 % under clear skies.
const BALANCE_TOLERANCE: f64 = 0.06;

/// Where the weather was recorded.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct WeatherStation {
    /// City.
    pub city: String,
    /// State, province or region.
    pub region: String,
    /// Country.
    pub country: String,
    /// Origin of the data.
    pub source: String,
    /// Number of the station with the World Meteorological Organization.
    pub number: String,
    /// Metres above sea level.
    pub altitude: f64,
}

/// One hour of the weather: mean irradiances over the hour that ends at `hour`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WeatherHour {
    /// The year that the row comes from; typical years are put together from several.
    pub year: i32,
    /// 1 to 12.
    pub month: u32,
    /// 1 to 31.
    pub day: u32,
    /// 1 to 24: the hour from `hour` - 1 to `hour` o'clock, without summer time.
    pub hour: u32,
    /// Direct normal irradiance, W/m²; none where it is missing.
    pub direct_normal: Option<f64>,
    /// Diffuse horizontal irradiance, W/m²; none where it is missing.
    pub diffuse_horizontal: Option<f64>,
    /// Global horizontal irradiance, W/m²; none where it is missing.
    pub global_horizontal: Option<f64>,
    /// Dew point, degrees Celsius; none where it is missing.
    pub dew_point: Option<f64>,
}

impl WeatherHour {
    /// The middle of the hour, when the sun stands where it stands on the mean.
    ///
    /// # Errors
    /// A year for which the sun cannot be computed, or 29 February of a year without one.
    pub fn middle(&self) -> Result<LocalTime, DaylightError> {
        self.middle_in(self.year)
    }

    /// As [`WeatherHour::middle`], in another year.
    ///
    /// # Errors
    /// As there.
    pub fn middle_in(&self, year: i32) -> Result<LocalTime, DaylightError> {
        LocalTime::new(Date::new(year, self.month, self.day)?, f64::from(self.hour) - 0.5)
    }

    /// Precipitable water in cm by the dew point, or the usual amount.
    pub fn water(&self) -> f64 {
        self.dew_point.map_or(USUAL_WATER, water_of_dew_point)
    }
}

/// The hour with most light on the horizontal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightestHour {
    /// Its row.
    pub hour: WeatherHour,
    /// Global horizontal irradiance of its parts, W/m².
    pub global: f64,
    /// Where the sun stands in its middle.
    pub sun: SunPosition,
}

/// The figures of a weather file.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherSummary {
    /// Hours with both direct and diffuse light measured or known to be none.
    pub complete: usize,
    /// Of these, hours with any light.
    pub lit: usize,
    /// The hour with most light; none where all are dark.
    pub brightest: Option<BrightestHour>,
    /// Sums over the year of direct normal and diffuse horizontal irradiance, kWh/m².
    pub sums: [f64; 2],
    /// What the user should know, one sentence each without a full stop.
    pub doubts: Vec<String>,
}

/// A weather file: a place, and irradiances by the hour.
#[derive(Clone, Debug, PartialEq)]
pub struct WeatherFile {
    station: WeatherStation,
    place: Place,
    hours: Vec<WeatherHour>,
    notes: Vec<String>,
}

impl WeatherFile {
    pub(super) fn new(
        station: WeatherStation,
        place: Place,
        hours: Vec<WeatherHour>,
        notes: Vec<String>,
    ) -> Self {
        Self { station, place, hours, notes }
    }

    /// Reads a weather file of EnergyPlus (EPW) with one record per hour. `name` appears in messages only.
    ///
    /// # Errors
    /// The first thing that makes the file useless, with its line. Missing values, missing hours and
    /// implausible values are notes of the file.
    pub fn read(name: &str, bytes: &[u8]) -> Result<Self, WeatherError> {
        epw::read(name, bytes)
    }

    /// Where it was recorded.
    pub fn station(&self) -> &WeatherStation {
        &self.station
    }

    /// Latitude, longitude and time zone of its clocks, without summer time.
    pub fn place(&self) -> Place {
        self.place
    }

    /// All hours in the order of the file.
    pub fn hours(&self) -> &[WeatherHour] {
        &self.hours
    }

    /// The hour that holds a time of day (hours since midnight, 0 to 24) of a day of the year.
    ///
    /// # Errors
    /// The file has no such hour.
    pub fn hour(&self, month: u32, day: u32, time: f64) -> Result<&WeatherHour, DaylightError> {
        // Casting saturates; midnight at the end of a day belongs to its last hour.
        let hour = (time.max(0.0) as u32).min(23) + 1;
        let found = self.hours.iter().find(|row| (row.month, row.day, row.hour) == (month, day, hour));
        found.ok_or_else(|| {
            DaylightError::new(format!(
                "the weather file has no hour from {} to {hour} o'clock on {day} {}",
                hour - 1,
                month_name(month)
            ))
        })
    }

    /// Where the sun stands in the middle of an hour of this place, in the year of the row or, where the sun
    /// cannot be computed for that, in 2001 (2000 for 29 February).
    ///
    /// # Errors
    /// None for rows that were read.
    pub fn sun(&self, hour: &WeatherHour) -> Result<SunPosition, DaylightError> {
        let known = hour.middle().or_else(|_| hour.middle_in(2001)).or_else(|_| hour.middle_in(2000))?;
        SunPosition::at(self.place, known)
    }

    /// The daylight of an hour under the all-weather sky of Perez, over a ground of this reflectance.
    ///
    /// # Errors
    /// An hour whose direct or diffuse irradiance is missing, or a reflectance outside 0 to 1.
    pub fn daylight(&self, hour: &WeatherHour, ground: f64) -> Result<Daylight, DaylightError> {
        let missing = |what: &str| {
            DaylightError::new(format!(
                "the {what} irradiance of hour {} on {} {} is missing in the weather file; choose another \
                 hour",
                hour.hour,
                hour.day,
                month_name(hour.month)
            ))
        };
        let direct = hour.direct_normal.ok_or_else(|| missing("direct normal"))?;
        let diffuse = hour.diffuse_horizontal.ok_or_else(|| missing("diffuse horizontal"))?;
        let leap = is_leap(hour.year) || (hour.month, hour.day) == (2, 29);
        let day = Date::new(if leap { 2000 } else { 2001 }, hour.month, hour.day)?.day_of_year();
        Daylight::of_irradiances(direct, diffuse, self.sun(hour)?, day, hour.water(), ground)
    }

    /// All figures at once; some tenths of a second for a year, since the sun is computed for every hour.
    pub fn summary(&self) -> WeatherSummary {
        let (mut complete, mut lit, mut night_suns) = (0, 0, 0);
        let mut brightest: Option<BrightestHour> = None;
        let (mut sums, mut apart, mut whole) = ([0.0; 2], 0.0, 0.0);
        for hour in &self.hours {
            let (Some(direct), Some(diffuse)) = (hour.direct_normal, hour.diffuse_horizontal) else {
                continue;
            };
            complete += 1;
            lit += usize::from(direct + diffuse > 0.0);
            sums[0] += direct / 1000.0;
            sums[1] += diffuse / 1000.0;
            if direct + diffuse <= 0.0 {
                continue;
            }
            let Ok(sun) = self.sun(hour) else { continue };
            night_suns += usize::from(direct > LEAST_DIRECT && sun.elevation() < -5.0);
            let global = diffuse + direct * sun.direction().z.max(0.0);
            if let Some(stated) = hour.global_horizontal {
                apart += (global - stated).abs();
                whole += stated;
            }
            if brightest.is_none_or(|before| global > before.global) {
                brightest = Some(BrightestHour { hour: *hour, global, sun });
            }
        }
        let mut doubts = self.notes.clone();
        let missing = self.hours.len() - complete;
        if missing > 0 {
            doubts.push(format!(
                "{missing} of {} hours have no direct or no diffuse irradiance and cannot be chosen",
                self.hours.len()
            ));
        }
        if lit == 0 {
            doubts.push("no hour has any light".to_owned());
        }
        if night_suns > MOST_NIGHT_SUNS {
            doubts.push(format!(
                "the sun shines in {night_suns} hours in which it is down: time zone or longitude may be \
                 wrong"
            ));
        }
        if whole > 0.0 && apart > BALANCE_TOLERANCE * whole {
            doubts.push(format!(
                "direct and diffuse irradiance miss the global irradiance by {:.1} %, hour by hour: the clocks may \
                 run otherwise than stated",
                100.0 * apart / whole
            ));
        }
        WeatherSummary { complete, lit, brightest, sums, doubts }
    }
}
