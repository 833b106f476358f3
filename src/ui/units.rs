//! Numbers as people read them: three digits, a unit, no jumping decimals.

pub(super) use crate::scene::grouped;

/// A quantity to three significant digits, in plain decimals between 0.001 and 99,999.
pub(super) fn digits(value: f64) -> String {
    if !value.is_finite() {
        return "-".to_owned();
    }
    let size = value.abs();
    if size == 0.0 {
        return "0".to_owned();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{value:.2e}");
    }
    // Rounded first: 9.996 is "10.0", not "9.996".
    let exponent =
        format!("{size:.2e}").split_once('e').and_then(|(_, e)| e.parse::<i32>().ok()).unwrap_or(0);
    if exponent >= 3 {
        let scale = 10_f64.powi(exponent - 2);
        return grouped((value / scale).round() as i64 * scale as i64);
    }
    format!("{value:.*}", (2 - exponent).max(0) as usize)
}

/// A coordinate: three digits, or hundredths where it is far from zero, as survey coordinates are.
pub(super) fn coordinate(value: f64) -> String {
    if value.is_finite() && value.abs() >= 1000.0 { format!("{value:.2}") } else { digits(value) }
}

/// Lux or cd/m² to three digits, and none that no meter shows: in thousandths below one.
pub(super) fn light(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 || size >= 1.0 || !size.is_finite() {
        digits(value)
    } else if size < 0.001 {
        "< 0.001".to_owned()
    } else {
        format!("{value:.3}")
    }
}

/// A count with commas between thousands.
pub(super) fn count(value: usize) -> String {
    grouped(value as i64)
}

/// A time left or taken: "0.4 ms", "3.2 s", "2 min 05 s".
pub(super) fn duration(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        return "-".to_owned();
    }
    if seconds < 5e-5 {
        return "< 0.1 ms".to_owned();
    }
    if seconds < 0.0995 {
        return format!("{:.1} ms", seconds * 1e3);
    }
    if seconds < 9.95 {
        return format!("{seconds:.1} s");
    }
    let whole = seconds.round() as u64;
    match whole {
        0..60 => format!("{whole} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole / 60 % 60),
    }
}

/// A time that is estimated, no more exactly than that can be known: "3.2 s", "40 s", "3 min".
pub(super) fn estimate(seconds: f64) -> String {
    if !(99.5..3540.0).contains(&seconds) {
        return duration(seconds);
    }
    format!("{:.0} min", seconds / 60.0)
}

/// Bytes in MB or GB.
pub(super) fn bytes(count: u64) -> String {
    let megabytes = count as f64 / 1e6;
    if megabytes < 1000.0 { format!("{megabytes:.0} MB") } else { format!("{:.2} GB", megabytes / 1e3) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_digits_whatever_the_size() {
        let expected = [
            (0.0, "0"),
            (412.4, "412"),
            (9.996, "10.0"),
            (0.01234, "0.0123"),
            (83.26, "83.3"),
            (12_345.0, "12,300"),
            (-2.5, "-2.50"),
            (1.5e-7, "1.50e-7"),
            (f64::NAN, "-"),
        ];
        for (value, text) in expected {
            assert_eq!(digits(value), text);
        }
        assert_eq!(count(20_312), "20,312");
        let lux = [(0.0, "0"), (5e-13, "< 0.001"), (0.012_34, "0.012"), (0.857, "0.857"), (412.4, "412")];
        for (value, text) in lux {
            assert_eq!(light(value), text);
        }
        assert_eq!(count(7), "7");
    }

    #[test]
    fn durations_read_as_people_say_them() {
        let expected = [
            (0.0004, "0.4 ms"),
            (3.21, "3.2 s"),
            (59.7, "1 min 00 s"),
            (125.0, "2 min 05 s"),
            (7260.0, "2 h 01 min"),
        ];
        for (seconds, text) in expected {
            assert_eq!(duration(seconds), text);
        }
        let estimated = [(3.21, "3.2 s"), (99.4, "1 min 39 s"), (125.0, "2 min"), (7260.0, "2 h 01 min")];
        for (seconds, text) in estimated {
            assert_eq!(estimate(seconds), text);
        }
    }
}
