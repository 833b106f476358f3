use super::text;
use crate::session::{Progress, Stage};
use std::io::{self, IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

/// Where a solve stands, on standard error: one line drawn again on a terminal, a line now and then
/// elsewhere.
pub(super) struct ProgressLine {
    terminal: bool,
    last: Option<(Stage, Instant)>,
}

impl ProgressLine {
    pub(super) fn new() -> Self {
        Self { terminal: io::stderr().is_terminal(), last: None }
    }

    /// Shows it if it is news or time.
    pub(super) fn show(&mut self, progress: &Progress<'_>) {
        let interval = Duration::from_millis(if self.terminal { 100 } else { 10_000 });
        if self.last.is_some_and(|(stage, at)| stage == progress.stage && at.elapsed() < interval) {
            return;
        }
        self.last = Some((progress.stage, Instant::now()));
        let line = describe(progress);
        let mut err = io::stderr().lock();
        // Nobody looks if this fails.
        let _ = if self.terminal {
            write!(err, "\r{line}\x1b[K").and_then(|()| err.flush())
        } else {
            writeln!(err, "{line}")
        };
    }

    /// Shows a message of a stage that has no fractions.
    pub(super) fn note(&self, message: &str) {
        let mut err = io::stderr().lock();
        let _ = if self.terminal {
            write!(err, "\r{message}\x1b[K").and_then(|()| err.flush())
        } else {
            writeln!(err, "{message}")
        };
    }
}

impl Drop for ProgressLine {
    fn drop(&mut self) {
        if self.terminal {
            let _ = write!(io::stderr().lock(), "\r\x1b[K");
        }
    }
}

fn describe(progress: &Progress<'_>) -> String {
    let stage = match progress.stage {
        Stage::Idle => "waiting",
        Stage::Loading => "loading",
        Stage::Meshing => "splitting into patches",
        Stage::FirstLight => "first light",
        Stage::Rows => "form factors",
        Stage::Sweeping => "sweeping",
        Stage::Converged => "converged",
        Stage::Stopped => "stopped",
        Stage::Failed => "failed",
    };
    let mut line = format!("{stage:<14} {:3.0} %", 100.0 * progress.fraction.clamp(0.0, 1.0));
    let (done, all) = progress.rows;
    match progress.sweeps.last() {
        Some(sweep) => line += &format!(
            ", sweep {}, residual {}",
            sweep.sweep,
            text::significant(sweep.residual)
        ),
        None if all > 0 => {
            line += &format!(", {} of {} rows", text::thousands(done), text::thousands(all));
        }
        None => {}
    }
    if let Some(left) = progress.seconds_left.filter(|_| progress.stage != Stage::Converged) {
        line += &format!(", {} left", text::seconds(left));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solver::SweepReport;

    #[test]
    fn a_line_tells_stage_share_rows_and_time() {
        let mut progress = Progress {
            stage: Stage::Rows,
            fraction: 0.634,
            seconds_left: Some(4.2),
            rows: (12_800, 20_312),
            sweeps: &[],
            bases: None,
        };
        assert_eq!(describe(&progress), "form factors    63 %, 12,800 of 20,312 rows, 4.20 s left");
        let sweeps = [SweepReport { sweep: 3, residual: 0.0125, ..SweepReport::default() }];
        progress.sweeps = &sweeps;
        progress.stage = Stage::Sweeping;
        progress.seconds_left = None;
        assert_eq!(describe(&progress), "sweeping        63 %, sweep 3, residual 0.0125");
    }
}
