use super::failure::Failure;
use crate::scene;
use crate::solve::Predicted;
use crate::transport::{Transport, TransportKind};
use std::io::{self, IsTerminal as _, Write as _};

/// Writes to standard output.
///
/// # Errors
/// [`Failure::Unread`] where its reader went away, [`Failure::Work`] where it cannot be written to.
pub(super) fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    let written = out.write_all(text.as_bytes()).and_then(|()| out.flush());
    written.map_err(|error| match error.kind() {
        io::ErrorKind::BrokenPipe => Failure::Unread,
        _ => Failure::work(anyhow::Error::new(error).context("cannot write to standard output")),
    })
}

/// Writes one line to standard error, under the name of the program.
pub(super) fn complain(message: &str) {
    // A progress line may stand there.
    let clear = if io::stderr().is_terminal() { "\r\x1b[K" } else { "" };
    // Nobody listens if this fails.
    let _ = writeln!(io::stderr().lock(), "{clear}lumenwalk: {message}");
}

/// `20,312`.
pub(super) fn thousands(number: usize) -> String {
    scene::grouped(number as i64)
}

/// `1 lamp`, `2,000 lamps`.
pub(super) fn count(number: usize, noun: &str) -> String {
    let plural = if number == 1 { "" } else { "s" };
    format!("{} {noun}{plural}", thousands(number))
}

/// `1 patch`, `2,370 patches`.
pub(super) fn patches(number: usize) -> String {
    format!("{} patch{}", thousands(number), if number == 1 { "" } else { "es" })
}

/// `0.35 s`, `12 s`, `3 min 20 s`.
pub(super) fn seconds(seconds: f64) -> String {
    if !seconds.is_finite() || seconds < 0.0 {
        "unknown".into()
    } else if seconds < 9.95 {
        format!("{seconds:.2} s")
    } else if seconds < 120.0 {
        format!("{seconds:.0} s")
    } else {
        // Rounded before it is taken apart, so that no minute has sixty seconds.
        let whole = seconds.round() as u64;
        format!("{} min {} s", whole / 60, whole % 60)
    }
}

/// Three significant digits: `0.00412`, `48.1`, `1230`; exponents for the very small.
pub(super) fn significant(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if !(1e-3..1e7).contains(&size) {
        format!("{value:.2e}")
    } else {
        let decimals = (2.0 - size.log10().floor()).max(0.0) as usize;
        format!("{value:.decimals$}")
    }
}

/// What carries the light between patches, in a line.
pub(super) fn transport(transport: &dyn Transport) -> String {
    let (entries, megabytes) = (transport.entries(), transport.bytes() as f64 / 1e6);
    let held = format!("{}, {} MB", count(entries, "form factor"), significant(megabytes));
    match transport.kind() {
        TransportKind::Tree => format!(
            "transport: tree, {held}, {} per patch; joining them changes passed-on light by at most about {} %\n",
            significant(entries as f64 / transport.len().max(1) as f64),
            significant(100.0 * transport.report().joined_error),
        ),
        TransportKind::Matrix | TransportKind::Auto => format!("transport: matrix, {held}\n"),
    }
}

/// What will carry the light, in a line.
pub(super) fn predicted(predicted: &Predicted) -> String {
    format!(
        "transport: {}, about {} form factors, {} MB\n",
        predicted.kind.name(),
        significant(predicted.entries),
        significant(predicted.bytes / 1e6)
    )
}

/// Columns side by side, two spaces apart; the last one is not padded.
pub(super) fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |column: usize| {
        rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    let mut text = String::new();
    for row in rows {
        let padded: Vec<String> =
            row.iter().zip(&widths).map(|(cell, &width)| format!("{cell:width$}")).collect();
        text.push_str(padded.join("  ").trim_end());
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_grouped_by_thousands() {
        assert_eq!(thousands(0), "0");
        assert_eq!(thousands(999), "999");
        assert_eq!(thousands(1_234_567), "1,234,567");
        assert_eq!(count(1, "lamp"), "1 lamp");
        assert_eq!(count(20_312, "patch row"), "20,312 patch rows");
        assert_eq!((patches(1), patches(2370)), ("1 patch".into(), "2,370 patches".into()));
    }

    #[test]
    fn times_and_values_have_sensible_digits() {
        assert_eq!(seconds(0.345), "0.34 s");
        assert_eq!(seconds(61.2), "61 s");
        assert_eq!(seconds(200.0), "3 min 20 s");
        assert_eq!(seconds(599.7), "10 min 0 s");
        assert_eq!(seconds(f64::NAN), "unknown");
        assert_eq!(significant(0.004_123), "0.00412");
        assert_eq!(significant(48.12), "48.1");
        assert_eq!(significant(1_230.4), "1230");
        assert_eq!(significant(-3.2e-6), "-3.20e-6");
        assert_eq!(significant(0.0), "0");
    }

    #[test]
    fn tables_line_up() {
        let rows = [vec!["a".into(), "bb".into()], vec!["ccc".into(), "d".into()]];
        assert_eq!(table(&rows), "a    bb\nccc  d\n");
    }
}
