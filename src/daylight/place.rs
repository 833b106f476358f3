//! Where on Earth, and when.

use super::error::DaylightError;

/// Years of the Gregorian calendar for which the slowing of the Earth's rotation is known or estimated.
const YEARS: std::ops::RangeInclusive<i32> = 1600..=2999;

/// A place on Earth and the zone of its clocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    latitude: f64,
    longitude: f64,
    zone: f64,
}

impl Place {
    /// A place at a latitude (north positive, -90 to 90 degrees) and a longitude (east positive, -180 to 180
    /// degrees), whose clocks are `zone` hours ahead of UTC (-14 to 14, summer time included where it holds).
    ///
    /// # Errors
    /// A value outside its range or not finite.
    pub fn new(latitude: f64, longitude: f64, zone: f64) -> Result<Self, DaylightError> {
        // Written so that NaN is refused too.
        let within = |value: f64, most: f64| value.abs() <= most;
        if !within(latitude, 90.0) {
            return Err(DaylightError::new(format!(
                "the latitude is {latitude}, but must lie between -90 (South Pole) and 90 (North Pole)"
            )));
        }
        if !within(longitude, 180.0) {
            return Err(DaylightError::new(format!(
                "the longitude is {longitude}, but must lie between -180 and 180, east positive"
            )));
        }
        if !within(zone, 14.0) {
            return Err(DaylightError::new(format!(
                "the time zone is {zone} h, but must lie between -14 and 14 hours ahead of UTC"
            )));
        }
        Ok(Self { latitude, longitude, zone })
    }

    /// Degrees, north positive.
    pub fn latitude(self) -> f64 {
        self.latitude
    }

    /// Degrees, east positive.
    pub fn longitude(self) -> f64 {
        self.longitude
    }

    /// Hours by which its clocks are ahead of UTC.
    pub fn zone(self) -> f64 {
        self.zone
    }

    /// One sentence without a full stop if the zone does not fit the longitude; a sign mistaken is the usual
    /// reason. Zones in use differ from the mean time of their place by at most three hours and a half,
    /// summer time included.
    pub fn doubt(self) -> Option<String> {
        let by_longitude = self.longitude / 15.0;
        // Across the date line either day may be meant.
        let difference = (self.zone - by_longitude + 12.0).rem_euclid(24.0) - 12.0;
        (difference.abs() > 3.5).then(|| {
            format!(
                "the time zone of {:+} h is {:.1} h from the mean time of longitude {}; east is \
                 positive for both",
                self.zone,
                difference.abs(),
                self.longitude
            )
        })
    }
}

/// A day of the Gregorian calendar.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Date {
    year: i32,
    month: u32,
    day: u32,
}

/// Whether a year has 366 days.
pub(super) fn is_leap(year: i32) -> bool {
    year % 4 == 0 && (year % 100 != 0 || year % 400 == 0)
}

/// Days of a month from 1 to 12; 0 for any other.
pub(super) fn days_of(month: u32, leap: bool) -> u32 {
    match month {
        1 | 3 | 5 | 7 | 8 | 10 | 12 => 31,
        4 | 6 | 9 | 11 => 30,
        2 if leap => 29,
        2 => 28,
        _ => 0,
    }
}

/// English names of the months.
pub const MONTHS: [&str; 12] = [
    "January",
    "February",
    "March",
    "April",
    "May",
    "June",
    "July",
    "August",
    "September",
    "October",
    "November",
    "December",
];

/// The name of a month from 1 to 12; empty for any other.
pub(super) fn month_name(month: u32) -> &'static str {
    (month as usize).checked_sub(1).and_then(|index| MONTHS.get(index)).copied().unwrap_or_default()
}

impl Date {
    /// A day of a year from 1600 to 2999.
    ///
    /// # Errors
    /// A day that does not exist, as 30 February, or a year out of range.
    pub fn new(year: i32, month: u32, day: u32) -> Result<Self, DaylightError> {
        if !YEARS.contains(&year) {
            return Err(DaylightError::new(format!(
                "the year is {year}, but must lie between {} and {}",
                YEARS.start(),
                YEARS.end()
            )));
        }
        if !(1..=12).contains(&month) {
            return Err(DaylightError::new(format!("the month is {month}, but must lie between 1 and 12")));
        }
        let last = days_of(month, is_leap(year));
        if !(1..=last).contains(&day) {
            let name = month_name(month);
            return Err(DaylightError::new(format!(
                "{day} {name} {year} does not exist: {name} has {last} days in that year"
            )));
        }
        Ok(Self { year, month, day })
    }

    /// The year.
    pub fn year(self) -> i32 {
        self.year
    }

    /// 1 to 12.
    pub fn month(self) -> u32 {
        self.month
    }

    /// 1 to 31.
    pub fn day(self) -> u32 {
        self.day
    }

    /// 1 for 1 January, to 365 or 366.
    pub fn day_of_year(self) -> u32 {
        let leap = is_leap(self.year);
        (1..self.month).map(|month| days_of(month, leap)).sum::<u32>() + self.day
    }
}

impl std::fmt::Display for Date {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} {} {}", self.day, month_name(self.month), self.year)
    }
}

/// A date and the time that the clocks of a place show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalTime {
    date: Date,
    hours: f64,
}

impl LocalTime {
    /// A time of day in hours since midnight, 0 to 24.
    ///
    /// # Errors
    /// Hours out of range or not finite.
    pub fn new(date: Date, hours: f64) -> Result<Self, DaylightError> {
        if !(0.0..=24.0).contains(&hours) {
            return Err(DaylightError::new(format!("the time is {hours} h, but must lie between 0 and 24")));
        }
        Ok(Self { date, hours })
    }

    /// The date.
    pub fn date(self) -> Date {
        self.date
    }

    /// Hours since midnight, 0 to 24.
    pub fn hours(self) -> f64 {
        self.hours
    }

    /// Hour and minute of the clock, rounded to the minute.
    pub fn clock(self) -> (u32, u32) {
        // Casting saturates, and 24 h are 1440 minutes.
        let minutes = (self.hours * 60.0).round() as u32;
        (minutes / 60, minutes % 60)
    }
}

impl std::fmt::Display for LocalTime {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (hour, minute) = self.clock();
        write!(f, "{}, {hour:02}:{minute:02}", self.date)
    }
}
