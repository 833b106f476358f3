use super::text;
use crate::solve::{Progress, Stage};
use crate::solver::SweepReport;
use std::io::{self, IsTerminal as _, Write as _};
use std::time::{Duration, Instant};

/// Where work stands, on standard error: one line drawn again on a terminal, a line now and then
/// elsewhere.
pub(super) struct ProgressLine {
    terminal: bool,
    /// Which stage was told last, and when.
    last: Option<(&'static str, Instant)>,
}

impl ProgressLine {
    pub(super) fn new() -> Self {
        Self { terminal: io::stderr().is_terminal(), last: None }
    }

    /// Shows where a solve stands, if it is news or time.
    pub(super) fn solve(&mut self, progress: &Progress<'_>) {
        self.show(stage_name(progress.stage), || {
            describe(progress.stage, progress.fraction, progress.rows, progress.sweeps, progress.seconds_left)
        });
    }

    /// Shows how much of a picture is done, 0 to 1, if it is time.
    pub(super) fn picture(&mut self, share: f64) {
        self.show("picture", || line("picture", share));
    }

    /// Shows which frame of a tour is at work, 0 being the first, if it is time. `share` of the whole
    /// is done, 0 to 1, after this time.
    pub(super) fn tour(&mut self, index: usize, count: usize, share: f64, elapsed: Duration) {
        self.show("tour", || describe_tour(index, count, share, elapsed.as_secs_f64()));
    }

    /// Shows which of a number of named parts runs now, if it is time.
    pub(super) fn part(&mut self, stage: &'static str, done: usize, all: usize, name: &str) {
        self.show(stage, || format!("{}, {name}", line(stage, done as f64 / all.max(1) as f64)));
    }

    /// Shows that an answer is being checked.
    pub(super) fn audit(&mut self) {
        self.show("checking", || "checking by independent rays".to_owned());
    }

    /// Shows how much of a sweep is done, 0 to 1, and what it is at; without progress it is checking.
    pub(super) fn sweep(&mut self, share: f64, what: &str, progress: Option<&Progress<'_>>) {
        const BAR: usize = 24;
        self.show("sweep", || {
            let full = (share.clamp(0.0, 1.0) * BAR as f64) as usize;
            let stage = progress.map_or("checking", |p| stage_name(p.stage));
            let part = progress.map_or(String::new(), |p| format!(" {:.0} %", 100.0 * p.fraction));
            format!("[{:<BAR$}] {:3.0} %  {what}: {stage}{part}", "#".repeat(full), 100.0 * share)
        });
    }

    fn show(&mut self, stage: &'static str, line: impl FnOnce() -> String) {
        let interval = Duration::from_millis(if self.terminal { 100 } else { 10_000 });
        if self.last.is_some_and(|(last, at)| last == stage && at.elapsed() < interval) {
            return;
        }
        self.last = Some((stage, Instant::now()));
        let mut err = io::stderr().lock();
        // Nobody looks if this fails.
        let _ = if self.terminal {
            write!(err, "\r{}\x1b[K", line()).and_then(|()| err.flush())
        } else {
            writeln!(err, "{}", line())
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

fn stage_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Idle => "waiting",
        Stage::Loading => "loading",
        Stage::Meshing => "meshing",
        Stage::FirstLight => "first light",
        Stage::Elements => "direct light",
        Stage::Rows => "form factors",
        Stage::Balancing => "balancing",
        Stage::Sweeping => "sweeping",
        Stage::Converged => "converged",
        Stage::Unlit => "no lamps",
        Stage::Stopped => "stopped",
        Stage::Failed => "failed",
    }
}

fn line(stage: &str, share: f64) -> String {
    format!("{stage:<12} {:3.0} %", 100.0 * share.clamp(0.0, 1.0))
}

fn describe_tour(index: usize, count: usize, share: f64, elapsed: f64) -> String {
    let mut line = line("tour", share);
    line += &format!(", frame {} of {}", text::thousands(index + 1), text::thousands(count));
    if share > 0.005 {
        line += &format!(", {} left", text::seconds(elapsed * (1.0 / share.min(1.0) - 1.0)));
    }
    line
}

fn describe(
    stage: Stage,
    share: f64,
    (done, all): (usize, usize),
    sweeps: &[SweepReport],
    seconds_left: Option<f64>,
) -> String {
    let mut line = line(stage_name(stage), share);
    match sweeps.last() {
        Some(sweep) => {
            line += &format!(", sweep {}, residual {}", sweep.sweep, text::significant(sweep.residual));
        }
        None if all > 0 => {
            line += &format!(", {} of {} rows", text::thousands(done), text::thousands(all));
        }
        None => {}
    }
    if let Some(left) = seconds_left.filter(|_| stage != Stage::Converged) {
        line += &format!(", {} left", text::seconds(left));
    }
    line
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tour_tells_its_frame_and_the_time_left() {
        let told = describe_tour(299, 1_200, 0.25, 30.0);
        assert_eq!(told, "tour          25 %, frame 300 of 1,200, 90 s left");
    }

    #[test]
    fn a_line_tells_stage_share_rows_and_time() {
        let rows = (12_800, 20_312);
        assert_eq!(
            describe(Stage::Rows, 0.634, rows, &[], Some(4.2)),
            "form factors  63 %, 12,800 of 20,312 rows, 4.20 s left"
        );
        let sweeps = [SweepReport { sweep: 3, residual: 0.0125, ..SweepReport::default() }];
        assert_eq!(
            describe(Stage::Sweeping, 0.97, rows, &sweeps, None),
            "sweeping      97 %, sweep 3, residual 0.0125"
        );
    }
}
