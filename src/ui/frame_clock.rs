//! How long the window's own thread is at work for a frame, and what keeps it waiting.
//!
//! Counted are this program's parts: taking over snapshots, the panels, the lighting mix, what is
//! handed to the graphics card. Not counted is what the driver and the display make of it.

use std::fs::File;
use std::io::Write as _;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Names a file to which a line a frame is written.
const LOG_VARIABLE: &str = "LUMENWALK_FRAME_LOG";
const HEADER: &str = "seconds,work_ms,work_processor_ms,draw_ms,processor_ms,queued_ms,stage";

/// Adds up the work for frames.
pub(super) struct FrameClock {
    begun: Option<Instant>,
    work: f64,
    longest: f64,
    drawing: DrawTime,
    log: Option<Log>,
}

/// Time spent on preparing the picture, which happens after the frame has been put together. Clones
/// count into one sum.
#[derive(Clone, Debug, Default)]
pub(super) struct DrawTime(Arc<AtomicU64>);

impl DrawTime {
    /// Runs a part of the drawing and counts it.
    pub(super) fn count<T>(&self, part: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = part();
        self.0.fetch_add(start.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }

    fn take(&self) -> f64 {
        self.0.swap(0, Ordering::Relaxed) as f64 * 1e-9
    }
}

impl Default for FrameClock {
    fn default() -> Self {
        let log = std::env::var_os(LOG_VARIABLE).and_then(|path| Log::open(path.as_ref()));
        Self { begun: None, work: 0.0, longest: 0.0, drawing: DrawTime::default(), log }
    }
}

impl FrameClock {
    /// What counts the drawing.
    pub(super) fn drawing(&self) -> DrawTime {
        self.drawing.clone()
    }

    /// A frame begins: that before it is complete. `stage` says what the solver was at.
    pub(super) fn begin_frame(&mut self, stage: &dyn std::fmt::Debug) {
        let drawn = self.drawing.take();
        let work = std::mem::take(&mut self.work);
        self.longest = self.longest.max(work + drawn);
        if let Some(log) = &mut self.log
            && work > 0.0
        {
            log.line(work, drawn, stage);
        }
        self.resume();
    }

    /// Work on the frame goes on.
    pub(super) fn resume(&mut self) {
        self.begun = Some(Instant::now());
        if let Some(log) = &mut self.log {
            log.resumed = scheduled()[0];
        }
    }

    /// Work on the frame rests.
    pub(super) fn rest(&mut self) {
        if let Some(begun) = self.begun.take() {
            self.work += begun.elapsed().as_secs_f64();
            if let Some(log) = &mut self.log {
                log.work_processor += scheduled()[0] - log.resumed;
            }
        }
    }

    /// The longest work for one frame, seconds.
    pub(super) fn longest(&self) -> f64 {
        self.longest
    }

    /// Forgets the longest: another scene is shown.
    pub(super) fn forget(&mut self) {
        self.longest = 0.0;
    }
}

struct Log {
    file: File,
    start: Instant,
    /// Processor time of this thread and time that it stood in the queue for a processor, seconds.
    before: [f64; 2],
    /// Processor time when the work on the frame went on last, and that of the work so far, seconds.
    resumed: f64,
    work_processor: f64,
}

impl Log {
    fn open(path: &std::path::Path) -> Option<Self> {
        let mut file = File::create(path).ok()?;
        writeln!(file, "{HEADER}").ok()?;
        Some(Self { file, start: Instant::now(), before: scheduled(), resumed: 0.0, work_processor: 0.0 })
    }

    fn line(&mut self, work: f64, drawn: f64, stage: &dyn std::fmt::Debug) {
        let now = scheduled();
        let [processor, queued] = [0, 1].map(|k| 1e3 * (now[k] - self.before[k]));
        self.before = now;
        let seconds = self.start.elapsed().as_secs_f64();
        let own = std::mem::take(&mut self.work_processor);
        let [work, own, drawn] = [work, own, drawn].map(|s| 1e3 * s);
        // A diagnosis that cannot be written is not worth a word to the user.
        let _ = writeln!(
            self.file,
            "{seconds:.3},{work:.2},{own:.2},{drawn:.2},{processor:.2},{queued:.2},{stage:?}"
        );
    }
}

/// Seconds that this thread has run and has waited for a processor, where the system tells (Linux).
fn scheduled() -> [f64; 2] {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let mut fields = text.split_whitespace().map(|field| field.parse::<f64>().unwrap_or(0.0) * 1e-9);
    [fields.next().unwrap_or(0.0), fields.next().unwrap_or(0.0)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn the_longest_frame_counts_its_parts_and_not_its_pauses() {
        let mut clock = FrameClock::default();
        let part = |clock: &mut FrameClock| {
            std::thread::sleep(Duration::from_millis(3));
            clock.rest();
        };
        clock.begin_frame(&"rows");
        part(&mut clock);
        std::thread::sleep(Duration::from_millis(60));
        clock.resume();
        part(&mut clock);
        let work = clock.work;
        assert!(work >= 0.006, "{work} s");
        clock.drawing().count(|| std::thread::sleep(Duration::from_millis(2)));
        clock.begin_frame(&"rows");
        let longest = clock.longest();
        assert!(longest >= work + 0.002, "{longest} s of work and drawing");
        clock.rest();
        clock.begin_frame(&"rows");
        assert_eq!(clock.longest(), longest, "a short frame does not shorten it");
        clock.forget();
        assert_eq!(clock.longest(), 0.0);
    }
}
