//! Long work that is watched: it tells how far it has come, and ends early when it is asked to.

use rayon::prelude::*;
use std::sync::mpsc;
use std::time::Duration;

/// The work was ended before it was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cancelled;

/// Parallel work is done in so many batches at most, each of so many items per thread at least; between two of
/// them it is told how far it is.
const BATCHES: usize = 64;
const PER_THREAD: usize = 4;

/// What long work asks and tells while it runs. Whoever does the work polls it between steps that take a few
/// milliseconds at most, so that a request to end is obeyed at once.
pub struct Watch<'a> {
    cancelled: &'a (dyn Fn() -> bool + Sync),
    report: &'a mut dyn FnMut(f64),
    /// What the present work is of all that is reported: where it starts and how much it is, of 1.
    start: f64,
    share: f64,
}

impl<'a> Watch<'a> {
    /// `cancelled` says whether to end; `report` is told how much is done, 0 to 1, and may be called often.
    pub fn new(cancelled: &'a (dyn Fn() -> bool + Sync), report: &'a mut dyn FnMut(f64)) -> Self {
        Self { cancelled, report, start: 0.0, share: 1.0 }
    }

    /// Does the work for nobody who looks on: it is never ended.
    pub fn nobody<T>(work: impl FnOnce(&mut Watch<'_>) -> T) -> T {
        work(&mut Watch::new(&|| false, &mut |_| {}))
    }

    /// A part of the work, from one share of this to another, both 0 to 1.
    pub fn part(&mut self, from: f64, to: f64) -> Watch<'_> {
        Watch {
            cancelled: self.cancelled,
            report: &mut *self.report,
            start: self.start + from * self.share,
            share: (to - from) * self.share,
        }
    }

    /// Says whether to end; may be asked by several threads, while the work goes on.
    pub fn cancelled(&self) -> &'a (dyn Fn() -> bool + Sync) {
        self.cancelled
    }

    /// Tells that `share` of the present work is done, 0 to 1.
    ///
    /// # Errors
    /// The work is to end.
    pub fn done(&mut self, share: f64) -> Result<(), Cancelled> {
        if (self.cancelled)() {
            return Err(Cancelled);
        }
        (self.report)(self.start + share * self.share);
        Ok(())
    }

    /// Calls `each` with every item and its index, in parallel, and keeps the results in order. Asks before
    /// every item whether to end.
    ///
    /// # Errors
    /// The work is to end; items that were not begun are left undone.
    pub fn map<T: Sync, R: Send>(
        &mut self,
        items: &[T],
        each: impl Fn(usize, &T) -> R + Sync,
    ) -> Result<Vec<R>, Cancelled> {
        let cancelled = self.cancelled;
        let mut results = Vec::with_capacity(items.len());
        let size = items.len().div_ceil(BATCHES).max(PER_THREAD * rayon::current_num_threads());
        for batch in items.chunks(size) {
            let first = results.len();
            let one = |(k, item): (usize, &T)| (!cancelled()).then(|| each(first + k, item));
            let some: Option<Vec<R>> = batch.par_iter().enumerate().map(one).collect();
            results.extend(some.ok_or(Cancelled)?);
            self.done(results.len() as f64 / items.len() as f64)?;
        }
        Ok(results)
    }
}

/// How often somebody who waits for work of others asks whether to end.
const WAITED: Duration = Duration::from_millis(20);

/// Does work that cannot be asked to end, by a library say, on a thread of its own. Once it is cancelled it is left to
/// itself. `None` where it panicked.
///
/// # Errors
/// It was `cancelled`.
pub fn apart<T: Send + 'static>(
    cancelled: &(dyn Fn() -> bool + Sync),
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<Option<T>, Cancelled> {
    let (sender, receiver) = mpsc::channel();
    let work = move || {
        // Nobody may be left to receive it.
        sender.send(work()).ok();
    };
    let thread = std::thread::Builder::new().name("apart".to_owned()).spawn(work);
    if thread.is_err() {
        return Ok(None);
    }
    loop {
        match receiver.recv_timeout(WAITED) {
            Ok(result) => return Ok(Some(result)),
            Err(mpsc::RecvTimeoutError::Disconnected) => return Ok(None),
            Err(mpsc::RecvTimeoutError::Timeout) if cancelled() => return Err(Cancelled),
            Err(mpsc::RecvTimeoutError::Timeout) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn parts_of_the_work_are_told_as_shares_of_the_whole() {
        let mut told = Vec::new();
        let mut report = |share| told.push(share);
        let mut watch = Watch::new(&|| false, &mut report);
        let mut second = watch.part(0.5, 1.0);
        second.done(0.5).unwrap();
        let doubled = second.part(0.5, 1.0).map(&[1, 2, 3], |index, item| index + 2 * item).unwrap();
        assert_eq!(doubled, [2, 5, 8]);
        assert_eq!(told[0], 0.75);
        assert!(told.is_sorted() && told.last() == Some(&1.0), "{told:?}");
    }

    #[test]
    fn work_apart_is_waited_for_unless_it_is_cancelled() {
        assert_eq!(apart(&|| false, || 7), Ok(Some(7)));
        assert_eq!(apart(&|| false, || -> u32 { panic!("as libraries may") }), Ok(None));
        let (gate, closed) = mpsc::channel::<()>();
        let asked = AtomicUsize::new(0);
        let ended = apart(&|| asked.fetch_add(1, Ordering::Relaxed) > 1, move || closed.recv().is_ok());
        assert_eq!(ended, Err(Cancelled), "and it has not come to its end");
        drop(gate);
    }

    #[test]
    fn no_item_is_begun_after_the_end_was_asked_for() {
        let (asked, begun) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let cancelled = || asked.fetch_add(1, Ordering::Relaxed) >= 100;
        let mut report = |_| {};
        let items = vec![(); 10_000];
        let result =
            Watch::new(&cancelled, &mut report).map(&items, |_, ()| begun.fetch_add(1, Ordering::Relaxed));
        assert_eq!(result, Err(Cancelled));
        assert!(begun.into_inner() <= 100);
    }
}
