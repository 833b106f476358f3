/// From here on, an interrupt from the terminal or a request to terminate removes files that are
/// being written before it ends the process, at whatever it is working.
#[cfg(unix)]
pub(super) fn leave_nothing_half_written() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    use signal_hook::low_level::emulate_default_handler;

    // Where handlers or threads are refused, signals end the process as they always did.
    let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) else { return };
    let watch = move || {
        if let Some(signal) = signals.forever().next() {
            crate::export::atomic::abandon(|| {
                super::text::complain("interrupted; nothing was left half-written");
                // Ends the process by the signal itself, so that a calling shell sees it, and runs
                // no destructors under threads that are still at work.
                let _ = emulate_default_handler(signal);
                std::process::abort();
            });
        }
    };
    let _ = std::thread::Builder::new().name("signals".into()).spawn(watch);
}

/// Elsewhere the system ends the process.
#[cfg(not(unix))]
pub(super) fn leave_nothing_half_written() {}
