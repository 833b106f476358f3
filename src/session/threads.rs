//! The threads that solve: their own, and behind everything that answers to the user.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// As many threads as the process computes with, apart from those that the window draws with, and
/// below them in rank: where processors are scarce, a frame comes first and the solve takes the rest.
///
/// # Errors
/// The system gives no threads.
pub(super) fn solving() -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new()
        .num_threads(rayon::current_num_threads())
        .thread_name(|index| format!("solver {index}"))
        .start_handler(|_| stand_back())
        .build()
}

/// Lowers the rank of the calling thread, for good.
#[cfg(target_os = "linux")]
pub(super) fn stand_back() {
    /// Of the steps from 0 to 19; ten leave about a tenth of a contested processor.
    const STEPS: i32 = 10;
    // On Linux a thread has a rank of its own, under its own number. Where lowering it is refused,
    // the solve goes on as before.
    let thread = rustix::thread::gettid();
    // A process that stands further back already is not brought forward.
    if rustix::process::getpriority_process(Some(thread)).is_ok_and(|steps| steps < STEPS) {
        let _ = rustix::process::setpriority_process(Some(thread), STEPS);
    }
}

/// Elsewhere the threads keep the rank that they have.
#[cfg(not(target_os = "linux"))]
pub(super) fn stand_back() {}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    /// Field 19 of the line that Linux keeps for a thread: its rank (proc(5)).
    fn nice() -> i32 {
        let line = std::fs::read_to_string("/proc/thread-self/stat").expect("Linux tells");
        let after_name = line.rsplit_once(')').expect("the name stands in brackets").1;
        after_name.split_whitespace().nth(16).expect("enough fields").parse().expect("a number")
    }

    #[test]
    fn solving_threads_stand_behind_the_one_that_started_them() {
        let own = nice();
        let pool = solving().expect("threads");
        let theirs = pool.broadcast(|_| nice());
        assert_eq!(theirs.len(), rayon::current_num_threads());
        assert!(theirs.iter().all(|&n| n >= own.clamp(10, 19)), "{theirs:?} against {own}");
        assert_eq!(nice(), own, "the window's own thread keeps its rank");
    }
}
