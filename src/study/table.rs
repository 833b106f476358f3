//! The table of a sweep: written after every row, read again to go on from it.

use super::sweep::Entry;
use crate::accuracy::{ErrorBudget, Estimate, Ranged};
use crate::export::{ExportError, atomic};
use crate::form_factors::{Method, ReceivingPoints};
use std::collections::HashMap;
use std::io::Write as _;
use std::path::Path;

/// One measured point.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// [`super::scene_hash`] of it.
    pub hash: u64,
    /// Threads at work.
    pub threads: usize,
    /// What was asked for.
    pub entry: Entry,
    /// Patches that there were.
    pub patches: usize,
    /// Seconds of meshing, rows, balancing and sweeps.
    pub seconds: [f64; 4],
    /// Seconds in all, the audit left out.
    pub total_seconds: f64,
    /// Most memory held during the solve, bytes.
    pub peak_memory: Option<u64>,
    /// What the audit found; all zero where no light arrives, and not a number what a table of an earlier
    /// version does not tell.
    pub budget: ErrorBudget,
}

impl Default for Entry {
    fn default() -> Self {
        let (method, points) = (Method::Lines, ReceivingPoints::Auto);
        Self { method, resolution: method.default_resolution(), points, patches: 1 }
    }
}

const HEADER: &str = "scene,hash,threads,method,resolution,receiving_points,patches_wanted,patches,seconds_mesh,seconds_rows,\
    seconds_balance,seconds_sweeps,seconds_total,peak_memory_bytes,direct,direct_low,direct_high,form_factors,form_factors_low,\
    form_factors_high,patch_error,patch_error_low,patch_error_high,solver,solver_low,solver_high,solver_bound,\
    total,total_low,total_high,averages,averages_low,averages_high,of_mean,of_mean_low,of_mean_high,median,within_1,within_5,within_10,mean_irradiance,receivers,rays,audit_seconds";

/// Writes all rows; errors are shares of the light there (the mean at least), `of_mean` of the mean.
///
/// # Errors
/// A refusal of the system.
pub fn write(path: &Path, rows: &[Row]) -> Result<(), ExportError> {
    atomic::write(path, |file| {
        writeln!(file, "{HEADER}")?;
        for row in rows {
            let b = &row.budget;
            let name: String =
                row.scene.chars().map(|c| if c == ',' || c == '"' { '_' } else { c }).collect();
            let memory = row.peak_memory.map_or(String::new(), |bytes| bytes.to_string());
            write!(
                file,
                "{name},{:016x},{},{},{},{},{},{}",
                row.hash,
                row.threads,
                row.entry.method.name(),
                row.entry.resolution,
                row.entry.points.name(),
                row.entry.patches,
                row.patches
            )?;
            for seconds in row.seconds.iter().chain([&row.total_seconds]) {
                write!(file, ",{seconds:.4}")?;
            }
            write!(file, ",{memory}")?;
            let estimate = |e: Estimate| [e.error, e.low, e.high].map(scientific).join(",");
            for e in [b.direct, b.form_factors, b.mesh, b.solver.estimate] {
                write!(file, ",{}", estimate(e))?;
            }
            write!(file, ",{:.4e}", b.solver.bound)?;
            for e in [b.total, b.averages, b.of_mean] {
                write!(file, ",{}", estimate(e))?;
            }
            write!(file, ",{}", scientific(b.spread.median.value))?;
            for within in b.spread.within {
                write!(file, ",{}", unless_unknown(within.value, |v| format!("{v:.4}")))?;
            }
            writeln!(file, ",{:.6e},{},{},{:.3}", b.mean_irradiance, b.receivers, b.rays, b.seconds)?;
        }
        Ok(())
    })
}

/// What is not a number is not known, and its field stays empty.
fn unless_unknown(value: f64, format: impl Fn(f64) -> String) -> String {
    if value.is_nan() { String::new() } else { format(value) }
}

fn scientific(value: f64) -> String {
    unless_unknown(value, |v| format!("{v:.4e}"))
}

/// Reads rows that [`write()`] wrote; lines that are none (of another version, cut short) are left out.
pub fn parse(text: &str) -> Vec<Row> {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap_or_default().split(',').collect();
    lines.filter_map(|line| parse_row(&names, line)).collect()
}

fn parse_row(names: &[&str], line: &str) -> Option<Row> {
    let fields: HashMap<&str, &str> = names.iter().copied().zip(line.split(',')).collect();
    let text = |name: &str| fields.get(name).copied();
    let number = |name: &str| text(name)?.parse::<f64>().ok().filter(|v| v.is_finite());
    let count = |name: &str| text(name)?.parse::<u64>().ok();
    let estimate = |name: &str| {
        let end = |suffix: &str| number(&format!("{name}{suffix}"));
        Some(Estimate { error: end("")?, low: end("_low")?, high: end("_high")? })
    };
    let method = Method::ALL.into_iter().find(|m| Some(m.name()) == text("method"))?;
    // Tables of before this was a choice hold what was chosen by itself.
    let points = text("receiving_points").unwrap_or(ReceivingPoints::Auto.name());
    let points = ReceivingPoints::ALL.into_iter().find(|p| p.name() == points)?;
    let mut budget = ErrorBudget {
        direct: estimate("direct").unwrap_or_default(),
        form_factors: estimate("form_factors")?,
        mesh: estimate("patch_error")?,
        total: estimate("total")?,
        averages: estimate("averages")?,
        // A table of before this column was there is read all the same.
        of_mean: estimate("of_mean").unwrap_or(Estimate { error: f64::NAN, low: f64::NAN, high: f64::NAN }),
        mean_irradiance: number("mean_irradiance")?,
        receivers: count("receivers")? as usize,
        rays: count("rays")?,
        seconds: number("audit_seconds")?,
        ..ErrorBudget::default()
    };
    budget.solver.estimate = estimate("solver")?;
    budget.solver.bound = number("solver_bound")?;
    // So is one of before these were; their intervals are not written.
    let [median, within @ ..] = ["median", "within_1", "within_5", "within_10"].map(|name| {
        let value = number(name).unwrap_or(f64::NAN);
        Ranged { value, low: value, high: value }
    });
    (budget.spread.median, budget.spread.within) = (median, within);
    Some(Row {
        scene: text("scene")?.to_owned(),
        hash: u64::from_str_radix(text("hash")?, 16).ok()?,
        threads: count("threads")? as usize,
        entry: Entry {
            method,
            resolution: u32::try_from(count("resolution")?).ok()?,
            points,
            patches: count("patches_wanted")? as usize,
        },
        patches: count("patches")? as usize,
        seconds: [
            number("seconds_mesh")?,
            number("seconds_rows")?,
            number("seconds_balance")?,
            number("seconds_sweeps")?,
        ],
        total_seconds: number("seconds_total")?,
        peak_memory: count("peak_memory_bytes"),
        budget,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_back_as_they_were_written_and_broken_lines_do_not_count() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("accuracy.csv");
        let estimate = Estimate { error: 0.0125, low: 0.0075, high: 0.025 };
        let mut row = Row {
            scene: "a room".into(),
            hash: 0xfeed_0000_0000_0001,
            threads: 2,
            entry: Entry {
                method: Method::Hemicube,
                resolution: 256,
                points: ReceivingPoints::Sixteen,
                patches: 2000,
            },
            patches: 2100,
            seconds: [0.5, 1.25, 0.25, 0.125],
            total_seconds: 2.25,
            peak_memory: Some(123_456_789),
            budget: ErrorBudget { total: estimate, receivers: 128, rays: 99, ..ErrorBudget::default() },
        };
        row.budget.solver.bound = 0.5;
        let without_peak = Row { peak_memory: None, scene: "b".into(), ..row.clone() };
        write(&path, &[row.clone(), without_peak.clone()]).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(parse(&text), [row.clone(), without_peak]);
        let cut = &text[..text.len() - 150];
        assert_eq!(parse(cut), [row], "the last line is cut short");
        assert!(parse("").is_empty() && parse("x,y\n1,2\n").is_empty());
    }

    #[test]
    fn what_an_earlier_version_did_not_measure_stays_unknown() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("accuracy.csv");
        let row = Row { scene: "a room".into(), threads: 1, total_seconds: 2.5, ..Row::default() };
        write(&path, &[row]).unwrap();
        // A table without the columns that were added later.
        let text = std::fs::read_to_string(&path).unwrap();
        let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
        let is_later =
            |name: &str| ["of_mean", "within", "median"].iter().any(|column| name.starts_with(column));
        let without = |line: &str| {
            let fields = names.iter().zip(line.split(',')).filter(|(name, _)| !is_later(name));
            fields.map(|(_, field)| field).collect::<Vec<_>>().join(",")
        };
        let early = text.lines().map(without).collect::<Vec<_>>().join("\n");
        let mut rows = parse(&early);
        // Written anew, as by a run that goes on from it, and read again.
        for _ in 0..2 {
            assert_eq!((rows.len(), rows[0].total_seconds), (1, 2.5), "{early}");
            let b = &rows[0].budget;
            assert!(b.of_mean.error.is_nan() && b.spread.median.value.is_nan(), "{b:?}");
            assert!(b.spread.within.iter().all(|w| w.value.is_nan()), "{b:?}");
            write(&path, &rows).unwrap();
            let anew = std::fs::read_to_string(&path).unwrap();
            let line = anew.lines().nth(1).unwrap();
            for (name, field) in names.iter().zip(line.split(',')) {
                assert_eq!(
                    field.is_empty(),
                    is_later(name) || *name == "peak_memory_bytes",
                    "{name}: {field:?}"
                );
            }
            rows = parse(&anew);
        }
    }
}
