//! A small house, on an evening and by day: seven rooms around a sunken living room, and a terrace.
//!
//! Plan, x to the east, z to the south, metres; the living room lies 0.36 lower than the rest.
//!
//! ```text
//!      0          3.2 3.32       6.92 7.04    9.24 9.36     11.6
//!    0 +-----------+ +------------+ +----------+ +-----------+
//!      |  study    | |  bedroom   | | bathroom | | entrance  |
//!      |           | |            | |          | | hall      |
//!  3.2 +------d----+ +--d---------+ +--d-------+ |           |
//! 3.32 |  gallery                                =           |
//!  4.4 |- - - - - - - - - - -         +----------+-----------+
//!  4.6 +----------------+                      +-------------+
//!      |  living room    steps    dining       =  kitchen    |
//!      |  (sunken)      |         room         |             |
//!  8.4 +----------------+----------------------+-------------+
//!      0               5.2                 8.48 8.6         11.6
//! ```

mod bath;
mod bedroom;
mod entrance;
mod furniture;
mod garden;
mod kitchen;
mod lamps;
mod living;
mod palette;
mod plan;
mod plants;
mod shell;
mod study;
mod terrace;
mod textiles;

use super::writer::Model;

/// With its lamps on, the night before its windows.
pub(crate) fn evening() -> Model {
    let mut m = Model::new(("m", 1.0), 0.32);
    m.view("Living room", [5.0, 1.5, 3.75], [1.9, 0.05, 7.6], 62.0);
    views(&mut m);
    m.view("Entrance", [9.85, 1.6, 0.25], [10.5, 1.0, 3.6], 70.0);
    m.view("Bedroom", [3.98, 1.55, 3.08], [6.3, 0.65, 1.1], 64.0);
    m.view("Bathroom", [7.7, 1.6, 3.08], [8.3, 0.85, 0.5], 72.0);
    m.view("Study", [2.4, 1.6, 3.08], [0.9, 0.8, 0.5], 66.0);
    m.view("Across the house", [0.42, 1.45, 7.2], [7.0, 0.6, 5.0], 60.0);
    plan::shell(&mut m, false);
    living_rooms(&mut m);
    entrance::hall(&mut m);
    bedroom::bedroom(&mut m);
    study::study(&mut m);
    bath::bathroom(&mut m);
    terrace::terrace(&mut m);
    m
}

/// With a garden around it, on a clear day in March; the small rooms are still empty.
pub(crate) fn by_day() -> Model {
    let mut m = Model::new(("m", 1.0), 0.7);
    m.by_day(DAYLIGHT);
    m.view("Living room", [0.45, 1.35, 4.0], [4.6, 0.15, 8.2], 66.0);
    views(&mut m);
    m.view("From the garden", [2.6, 1.6, 14.5], [3.6, 0.9, 8.4], 60.0);
    plan::shell(&mut m, true);
    living_rooms(&mut m);
    garden::garden(&mut m);
    m
}

/// Berlin, at the equinox, half past one.
const DAYLIGHT: &str = "latitude = 52.52\nlongitude = 13.405\nzone = 1\ndate = \"2026-03-20\"\n\
                        time = \"13:30\"\nsky = \"clear\"\nground = 0.2";

fn living_rooms(m: &mut Model) {
    living::living_room(m);
    living::gallery(m);
    kitchen::dining_room(m);
    kitchen::kitchen(m);
}

fn views(m: &mut Model) {
    m.view("Gallery", [8.35, 1.6, 4.05], [1.5, 0.75, 5.0], 62.0);
    m.view("Dining table", [5.35, 1.55, 3.6], [7.3, 0.75, 7.0], 62.0);
    m.view("Kitchen", [8.3, 1.6, 5.55], [11.3, 1.05, 7.05], 62.0);
}
