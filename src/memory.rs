//! The memory that this process can have.

use sysinfo::{ProcessRefreshKind, ProcessesToUpdate, System};

/// More memory is needed than there is.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "it needs about {} of memory and this process can have {}; close other programs, or raise its limit (ulimit -v, \
     that of a container)",
    told(*needed),
    told(*available)
)]
pub struct Shortage {
    /// Bytes needed, about.
    pub needed: f64,
    /// Bytes that there are.
    pub available: f64,
}

/// Bytes in words.
pub fn told(bytes: f64) -> String {
    if bytes < 1e10 { format!("{:.0} MB", bytes / 1e6) } else { format!("{:.0} GB", bytes / 1e9) }
}

/// Whether there are so many bytes: an allocation that fails would end the process without a word.
///
/// # Errors
/// There are not.
pub fn check(needed: f64) -> Result<(), Shortage> {
    match available_bytes() {
        Some(available) if needed > available => Err(Shortage { needed, available }),
        _ => Ok(()),
    }
}

/// Memory that this process can have without swapping, bytes: what is free in the system, within the limit of
/// its control group and that of its address space (`ulimit -v`). `None` where the system does not say.
pub fn available_bytes() -> Option<f64> {
    let mut system = System::new().ok()?;
    system.refresh_memory();
    let mut limits: Vec<u64> = Some(system.available_memory()).filter(|&free| free > 0).into_iter().collect();
    if let Ok(own) = sysinfo::get_current_pid() {
        let what = ProcessRefreshKind::nothing().with_memory().without_tasks();
        system.refresh_processes_specifics(ProcessesToUpdate::Some(&[own]), false, what);
        if let Some(process) = system.process(own) {
            // What files take of a group's memory is given up for others.
            let group = process.cgroup_limits().map(|g| g.total_memory.saturating_sub(g.rss));
            let space = address_space().map(|most| most.saturating_sub(process.virtual_memory()));
            limits.extend(group.into_iter().chain(space));
        }
    }
    limits.into_iter().min().map(|least| least as f64)
}

/// The most bytes that the process may address, where that is limited.
#[cfg(target_os = "linux")]
fn address_space() -> Option<u64> {
    rustix::process::getrlimit(rustix::process::Resource::As).current
}

/// Other systems know no such limit, or do not keep to it.
#[cfg(not(target_os = "linux"))]
fn address_space() -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_system_tells_what_is_free() {
        let free = available_bytes().expect("this system tells");
        assert!((1e7..1e14).contains(&free), "{free} bytes");
    }

    #[test]
    fn what_no_machine_has_is_refused_in_a_sentence() {
        assert_eq!(check(1e6), Ok(()));
        let told = check(1e18).expect_err("a billion gigabytes").to_string();
        assert!(
            told.starts_with("it needs about 1000000000 GB of memory and this process can have"),
            "{told}"
        );
    }
}
