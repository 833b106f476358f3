//! What a request recomputed, in words for the status bar.

use super::units;
use crate::session::Recompute;

/// As in "materials: 0 rows, 3 sweeps, 40 ms".
pub(super) fn words(done: &Recompute, scene: &str) -> String {
    let what = if done.scene {
        format!("opened {scene}")
    } else if done.lamps {
        "placed lamps".to_owned()
    } else if done.daylight && !done.mesh {
        "daylight".to_owned()
    } else if done.mesh {
        "settings".to_owned()
    } else if done.rows > 0 {
        // Nothing but what was left of a solve that had been stopped.
        "resumed".to_owned()
    } else {
        "materials".to_owned()
    };
    let kept = if done.kept_rows { " (geometry unchanged, rows kept)" } else { "" };
    // A line is never broken before the unit.
    let time = if done.seconds < 1.0 {
        format!("{:.0}\u{a0}ms", done.seconds * 1e3)
    } else {
        format!("{:.1}\u{a0}s", done.seconds)
    };
    if done.unlit {
        return format!("{what}: no lamps, so nothing was solved, {time}");
    }
    let rows = units::count(done.rows);
    format!("{what}: {rows} rows{kept}, {} sweeps, {time}", done.sweeps)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_kind_of_change_has_its_words() {
        let done = Recompute { sweeps: 3, seconds: 0.04, ..Recompute::default() };
        assert_eq!(words(&done, "room"), "materials: 0 rows, 3 sweeps, 40\u{a0}ms");
        let opened = Recompute { scene: true, mesh: true, rows: 1700, seconds: 1.0, ..done };
        assert_eq!(words(&opened, "room"), "opened room: 1,700 rows, 3 sweeps, 1.0\u{a0}s");
        let kept = Recompute { rows: 0, kept_rows: true, ..opened };
        assert!(words(&kept, "room").contains(": 0 rows (geometry unchanged, rows kept), 3 sweeps"));
        let unlit = Recompute { unlit: true, ..opened };
        assert_eq!(words(&unlit, "room"), "opened room: no lamps, so nothing was solved, 1.0\u{a0}s");
        assert!(words(&Recompute { mesh: true, ..done }, "room").starts_with("settings: "));
        assert!(words(&Recompute { mesh: true, lamps: true, ..done }, "room").starts_with("placed lamps: "));
        assert!(words(&Recompute { rows: 9, ..done }, "room").starts_with("resumed: 9 rows"));
    }
}
