//! Rooms, the openings between them, windows and doors.

use super::palette::{CEILING, DARK_FRAME, JOINERY, NIGHT_GLASS, PLASTER, WINDOW_GLASS};
use crate::scene::builtin::shapes::{Faces, Hole, rectangle};
use crate::scene::builtin::writer::{Model, Paint};
use glam::{DVec3, dvec3};

/// Which way a wall's normal points, without its sign.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Across {
    /// A wall that runs along z.
    X,
    /// A wall that runs along x.
    Z,
}

/// What is between the bars of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Filled {
    /// Nothing: one sees through.
    Nothing,
    /// Panes that are black against the night; the window ends there.
    Night,
    /// Panes of glass.
    Glass,
}

/// A hole through a wall, in the coordinates of the house.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Opening {
    /// The wall's direction.
    pub(crate) across: Across,
    /// From where to where along the wall, metres.
    pub(crate) along: [f64; 2],
    /// The two faces of the wall, ascending; equal where two rooms are one.
    pub(crate) through: [f64; 2],
    /// Sill and head, metres.
    pub(crate) height: [f64; 2],
    /// What its sides and head are made of.
    pub(crate) lining: &'static Paint,
    /// What its sill or threshold is made of.
    pub(crate) sill: &'static Paint,
}

/// A room with a flat floor: clear extents and what its walls are painted with.
pub(crate) struct Room {
    /// Names its objects.
    pub(crate) name: &'static str,
    /// From where to where, metres.
    pub(crate) x: [f64; 2],
    /// From where to where, metres.
    pub(crate) z: [f64; 2],
    /// Paint of the west (-x), east, north (-z) and south wall.
    pub(crate) walls: [&'static Paint; 4],
    /// The floor; `None` where floor and ceiling are made elsewhere.
    pub(crate) floor: Option<&'static Paint>,
}

/// A rug with a border, flush with the floor of a room; metres.
pub(crate) struct Rug {
    /// The room's name.
    pub(crate) room: &'static str,
    /// From where to where.
    pub(crate) x: [f64; 2],
    /// From where to where.
    pub(crate) z: [f64; 2],
    /// Width of the border.
    pub(crate) border: f64,
    /// Inside the border.
    pub(crate) field: &'static Paint,
    /// The border.
    pub(crate) edge: &'static Paint,
}

/// The floor of a room, or of a part of one, at height `y` around the rugs that lie on it.
pub(crate) fn floor(
    m: &mut Model,
    room: &str,
    ([x0, x1], [z0, z1]): ([f64; 2], [f64; 2]),
    y: f64,
    paint: &Paint,
    rugs: &[Rug],
) {
    let rugs: Vec<&Rug> = rugs
        .iter()
        .filter(|r| r.room == room && r.x[0] > x0 && r.x[1] < x1 && r.z[0] > z0 && r.z[1] < z1)
        .collect();
    let holes: Vec<Hole> =
        rugs.iter().map(|r| [r.x[0] - x0, r.x[1] - x0, z1 - r.z[1], z1 - r.z[0]]).collect();
    m.object(&format!("{room}_floor")).paint(paint);
    m.panel(dvec3(x0, y, z1), (DVec3::X, x1 - x0), (-DVec3::Z, z1 - z0), &holes);
    rugs.iter().for_each(|r| r.build(m, y));
}

impl Rug {
    /// Corners of the cut that it fills in a floor at height `y`.
    pub(crate) fn cut(&self, y: f64) -> Vec<DVec3> {
        rectangle([self.x[0], self.z[0]], [self.x[1], self.z[1]], y).to_vec()
    }

    /// Border and field at height `y`.
    pub(crate) fn build(&self, m: &mut Model, y: f64) {
        let r = self;
        m.object("rugs");
        let (w, d, b) = (r.x[1] - r.x[0], r.z[1] - r.z[0], r.border);
        m.paint(r.edge).panel(
            dvec3(r.x[0], y, r.z[1]),
            (DVec3::X, w),
            (-DVec3::Z, d),
            &[[b, w - b, b, d - b]],
        );
        m.paint(r.field);
        m.quad(dvec3(r.x[0] + b, y, r.z[1] - b), DVec3::X * (w - 2.0 * b), -DVec3::Z * (d - 2.0 * b));
    }
}

/// Clear height of all rooms over their entrance level, metres.
pub(crate) const HEIGHT: f64 = 2.6;

impl Room {
    /// Walls with their openings, ceiling and floor.
    pub(crate) fn build(&self, m: &mut Model, openings: &[Opening], rugs: &[Rug]) {
        let ([x0, x1], [z0, z1]) = (self.x, self.z);
        m.object(&format!("{}_walls", self.name));
        let sides = [
            (Across::X, x0, dvec3(x0, 0.0, z1), -DVec3::Z),
            (Across::X, x1, dvec3(x1, 0.0, z0), DVec3::Z),
            (Across::Z, z0, dvec3(x0, 0.0, z0), DVec3::X),
            (Across::Z, z1, dvec3(x1, 0.0, z1), -DVec3::X),
        ];
        for ((across, at, origin, along), paint) in sides.into_iter().zip(self.walls) {
            let range = if across == Across::X { self.z } else { self.x };
            let holes: Vec<Hole> = openings
                .iter()
                .filter(|o| o.across == across && o.through.iter().any(|t| (t - at).abs() < 1e-6))
                .filter(|o| o.along[0] >= range[0] - 1e-6 && o.along[1] <= range[1] + 1e-6)
                .map(|o| {
                    let (start, sign) = (origin.dot(along.abs()), along.dot(along.abs()));
                    let ends = o.along.map(|a| (a - start) * sign);
                    [ends[0].min(ends[1]), ends[0].max(ends[1]), o.height[0], o.height[1]]
                })
                .collect();
            m.paint(paint).wall(origin, along, range[1] - range[0], HEIGHT, &holes);
        }
        if let Some(paint) = self.floor {
            m.object(&format!("{}_ceiling", self.name)).paint(&CEILING);
            m.quad(dvec3(x0, HEIGHT, z0), DVec3::X * (x1 - x0), DVec3::Z * (z1 - z0));
            floor(m, self.name, (self.x, self.z), 0.0, paint, rugs);
        }
    }
}

impl Opening {
    /// A door or passage through an inner wall, from the floor up.
    pub(crate) fn door(
        across: Across,
        along: [f64; 2],
        through: [f64; 2],
        head: f64,
        floor: &'static Paint,
    ) -> Self {
        Self { across, along, through, height: [0.0, head], lining: &JOINERY, sill: floor }
    }

    /// A window in an outer wall whose inner face is at `inner` and whose outer one at `outer`.
    pub(crate) const fn window(
        across: Across,
        along: [f64; 2],
        inner: f64,
        outer: f64,
        height: [f64; 2],
    ) -> Self {
        let through = [inner.min(outer), inner.max(outer)];
        Self { across, along, through, height, lining: &PLASTER, sill: &JOINERY }
    }

    /// Runs `build` in coordinates with x along the wall from the opening's start, y up from
    /// zero, and z through the wall from `through[0]`. The turn keeps the handedness.
    fn in_wall(&self, m: &mut Model, build: impl FnOnce(&mut Model, f64, f64)) {
        let (width, depth) = (self.along[1] - self.along[0], self.through[1] - self.through[0]);
        match self.across {
            Across::Z => m.place([self.along[0], 0.0, self.through[0]], 0.0, |m| build(m, width, depth)),
            // Turned by a quarter: local x runs along -z, local z along x.
            Across::X => m.place([self.through[0], 0.0, self.along[1]], 90.0, |m| build(m, width, depth)),
        }
    }

    /// The faces inside the wall's thickness: sides, head and sill.
    pub(crate) fn reveal(&self, m: &mut Model) {
        self.lining(m, [0.0, self.through[1] - self.through[0]]);
    }

    /// The part of the reveal between two depths, metres from `through[0]`.
    fn lining(&self, m: &mut Model, [from, to]: [f64; 2]) {
        let [sill, head] = self.height;
        let rise = DVec3::Y * (head - sill);
        m.object("reveals");
        self.in_wall(m, |m, width, _| {
            let (across, into) = (DVec3::X * width, DVec3::Z * (to - from));
            m.paint(self.lining);
            m.quad(dvec3(0.0, sill, to), -into, rise);
            m.quad(dvec3(width, sill, from), into, rise);
            m.quad(dvec3(0.0, head, from), across, into);
            m.paint(self.sill);
            m.quad(dvec3(0.0, sill, to), across, -into);
        });
    }

    /// A window: the reveal, and in its middle a frame with upright mullions between `panes` panes
    /// and a crossbar at `transom` where given; `inside` is its face towards the room.
    pub(crate) fn frame(
        &self,
        m: &mut Model,
        panes: usize,
        transom: Option<f64>,
        inside: Faces,
        filled: Filled,
    ) {
        let dark = filled == Filled::Night;
        let (bar, half) = (0.05, 0.03);
        let [sill, head] = self.height;
        let depth = self.through[1] - self.through[0];
        let (z0, z1) = (0.5 * depth - half, 0.5 * depth + half);
        match (dark, inside == Faces::BACK) {
            (false, _) => self.reveal(m),
            (true, true) => self.lining(m, [0.0, z0]),
            (true, false) => self.lining(m, [z1, depth]),
        }
        let flat = if dark { inside } else { Faces::FRONT.and(Faces::BACK) };
        self.in_wall(m, |m, width, _| {
            let (low, high) = (sill + bar, head - bar);
            m.object("window_frames").paint(&DARK_FRAME);
            m.block([0.0, sill, z0], [width, low, z1], flat.and(Faces::TOP));
            m.block([0.0, high, z0], [width, head, z1], flat.and(Faces::BOTTOM));
            m.block([0.0, low, z0], [bar, high, z1], flat.and(Faces::RIGHT));
            m.block([width - bar, low, z0], [width, high, z1], flat.and(Faces::LEFT));
            let pane = (width - 2.0 * bar) / panes as f64;
            for k in 0..panes {
                let x = bar + pane * k as f64;
                let (left, right) = (
                    if k == 0 { x } else { x + 0.5 * bar },
                    if k + 1 == panes { x + pane } else { x + pane - 0.5 * bar },
                );
                m.object("window_frames").paint(&DARK_FRAME);
                if k > 0 {
                    m.block(
                        [x - 0.5 * bar, low, z0],
                        [x + 0.5 * bar, high, z1],
                        flat.and(Faces::LEFT).and(Faces::RIGHT),
                    );
                }
                let mut bays = vec![[low, high]];
                if let Some(y) = transom {
                    let level = flat.and(Faces::TOP).and(Faces::BOTTOM);
                    m.block([left, y, z0], [right, y + 0.6 * bar, z1], level);
                    bays = vec![[low, y], [y + 0.6 * bar, high]];
                }
                if filled == Filled::Glass {
                    m.object("window_panes").paint(&WINDOW_GLASS);
                    for [y0, y1] in bays {
                        let (width, height) = (DVec3::X * (right - left), DVec3::Y * (y1 - y0));
                        m.quad(dvec3(left, y0, 0.5 * (z0 + z1)), width, height);
                    }
                } else if dark {
                    m.object("window_panes").paint(&NIGHT_GLASS);
                    for [y0, y1] in bays {
                        // Set back as far as the frame is deep.
                        m.block([left, y0, z1], [right, y1, z0], inside);
                    }
                }
            }
        });
    }
}

/// A door leaf, hinged at the origin and lying along +x when closed, 4 cm thick towards -z, with
/// a handle on either side.
pub(crate) fn leaf(m: &mut Model, width: f64, height: f64, paint: &Paint) {
    m.object("doors").paint(paint);
    m.block([0.0, 0.006, -0.04], [width, height, 0.0], Faces::ALL);
    m.paint(&super::palette::STEEL);
    let x = width - 0.09;
    m.block([x - 0.1, 1.0, 0.04], [x + 0.02, 1.02, 0.06], Faces::ALL);
    m.block([x, 1.0, 0.0], [x + 0.02, 1.02, 0.04], Faces::AROUND);
    m.block([x - 0.1, 1.0, -0.1], [x + 0.02, 1.02, -0.08], Faces::ALL);
    m.block([x, 1.0, -0.08], [x + 0.02, 1.02, -0.04], Faces::AROUND);
}
