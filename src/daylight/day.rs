//! When the sun rises and sets.

use super::error::DaylightError;
use super::place::{Date, LocalTime, Place};
use super::sun::SunPosition;

/// The sun of one day of the calendar, by the clocks of its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DayLength {
    /// It rises and sets at these hours since midnight; where it sets before it rises, that is of the day before.
    Between {
        /// Hours since midnight.
        rise: f64,
        /// Hours since midnight.
        set: f64,
    },
    /// It does not set.
    AlwaysUp,
    /// It does not rise.
    AlwaysDown,
}

/// Looks so often a day: the sun of no day rises and sets between two of them, but within a few days of the year beyond
/// the polar circles.
const LOOKS: u32 = 144;

impl DayLength {
    /// When the middle of the sun crosses the horizon, without refraction by the air: almanacs, which count the upper rim
    /// through the air, have it up for some minutes longer at either end.
    ///
    /// # Errors
    /// What the algorithm for the sun refuses.
    pub fn of(place: Place, date: Date) -> Result<Self, DaylightError> {
        let up = |hours: f64| -> Result<bool, DaylightError> {
            Ok(SunPosition::at(place, LocalTime::new(date, hours)?)?.is_up())
        };
        let at = |k: u32| 24.0 * f64::from(k) / f64::from(LOOKS);
        let looks: Vec<bool> = (0..=LOOKS).map(|k| up(at(k))).collect::<Result<_, _>>()?;
        let crossing = |rises: bool| -> Result<Option<f64>, DaylightError> {
            let Some(k) = looks.windows(2).position(|pair| pair[1] == rises && pair[0] != rises) else {
                return Ok(None);
            };
            let (mut low, mut high) = (at(k as u32), at(k as u32 + 1));
            // To a second.
            while high - low > 1.0 / 3600.0 {
                let middle = 0.5 * (low + high);
                if up(middle)? == rises { high = middle } else { low = middle }
            }
            Ok(Some(0.5 * (low + high)))
        };
        Ok(match (crossing(true)?, crossing(false)?) {
            (Some(rise), Some(set)) => Self::Between { rise, set },
            (Some(rise), None) => Self::Between { rise, set: 24.0 },
            (None, Some(set)) => Self::Between { rise: 0.0, set },
            (None, None) if looks[0] => Self::AlwaysUp,
            (None, None) => Self::AlwaysDown,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(latitude: f64, longitude: f64, zone: f64, month: u32, day: u32) -> DayLength {
        let place = Place::new(latitude, longitude, zone).expect("a place");
        DayLength::of(place, Date::new(2026, month, day).expect("a day")).expect("a day length")
    }

    #[test]
    fn the_sun_rises_and_sets_when_it_should_and_at_the_poles_it_does_not() {
        // Almanacs have 04:43 and 21:33 in Berlin, by the upper rim through the air.
        let DayLength::Between { rise, set } = of(52.52, 13.405, 2.0, 6, 21) else { panic!("a day") };
        assert!((4.7..4.95).contains(&rise) && (21.35..21.6).contains(&set), "{rise} to {set}");
        let DayLength::Between { rise, set } = of(0.0, 0.0, 0.0, 3, 20) else { panic!("a day") };
        assert!((rise - 6.1).abs() < 0.15 && (set - rise - 12.0).abs() < 0.05, "{rise} to {set}");
        assert_eq!(of(90.0, 0.0, 0.0, 6, 21), DayLength::AlwaysUp);
        assert_eq!(of(90.0, 0.0, 0.0, 12, 21), DayLength::AlwaysDown);
        assert_eq!(of(69.65, 18.96, 1.0, 12, 21), DayLength::AlwaysDown);
        assert_eq!(of(-69.65, 18.96, 1.0, 12, 21), DayLength::AlwaysUp);
    }
}
