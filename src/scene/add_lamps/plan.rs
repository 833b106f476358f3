//! A model seen as columns: where there is a floor with room to stand above it.

use crate::geometry::{Aabb, Bvh, Ray};
use crate::scene::Scene;
use crate::scene::types::UpAxis;
use glam::{DVec2, DVec3};
use rayon::prelude::*;
use std::ops::Range;

/// Edge of a column, metres.
const CELL: f64 = 0.25;
/// The most columns; larger models get wider ones.
const MOST_CELLS: f64 = 30_000.0;
/// Free height above the floor of a room, metres.
const HEADROOM: f64 = 1.8;
/// Height of a storey, metres: a model that is lower is a small one.
const STOREY: f64 = 2.3;
/// Free height from which on a column is looked at, metres: above a cupboard the room goes on.
const GAP: f64 = 0.35;
/// Under the sky, floors that differ by no more than this belong together, metres; other steps are walls.
const STEP: f64 = 1.0;
/// Walls are looked for so far below the ceiling, metres: above doors, and above most furniture.
const BELOW_CEILING: f64 = 0.25;
/// Faces nearer to each other than this are one, metres.
const SAME: f64 = 0.002;

/// What is above a floor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// A ceiling.
    Roofed,
    /// A ceiling; but floor and ceiling face away from the space, as those of a solid body do.
    InsideOut,
    /// The sky.
    Open,
}

/// A free part of a column, above a floor or a piece of furniture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Space {
    /// The column.
    pub(super) cell: u32,
    /// Height of the floor along the up axis, metres.
    pub(super) floor: f64,
    /// Height of the ceiling; infinite under the sky.
    pub(super) ceiling: f64,
    pub(super) kind: Kind,
}

/// All columns of a model.
pub(super) struct Plan {
    triangles: Vec<[DVec3; 3]>,
    pub(super) bvh: Bvh,
    pub(super) up: DVec3,
    /// The two level axes.
    pub(super) axes: [DVec3; 2],
    /// Edge of a column, metres.
    pub(super) cell: f64,
    /// Free height above a floor, metres.
    pub(super) headroom: f64,
    /// 1 for a building; less for a model that is smaller than a room.
    pub(super) scale: f64,
    /// Level coordinates of the first corner.
    corner: DVec2,
    /// Columns along both axes.
    counts: [usize; 2],
    pub(super) spaces: Vec<Space>,
    /// Spaces beside each, with nothing between; at most four.
    pub(super) links: Vec<Vec<u32>>,
}

/// Heights at which a column meets faces, and whether they face up and down there.
struct Layer {
    height: f64,
    up: bool,
    down: bool,
}

impl Plan {
    /// `None` where the model has no level extent.
    pub(super) fn of(scene: &Scene) -> Option<Self> {
        // What is far away from the rest is no place for a lamp, and would make the columns kilometres wide.
        let triangles = scene.main_triangles(&scene.extent());
        let bvh = Bvh::build(&triangles);
        let bounds = bvh.bounds();
        let up = scene.up.vector();
        let axes = match scene.up {
            UpAxis::Y => [DVec3::X, DVec3::Z],
            UpAxis::Z => [DVec3::X, DVec3::Y],
        };
        let size = bounds.size();
        let level = DVec2::new(size.dot(axes[0]), size.dot(axes[1]));
        if !(level.min_element() > 0.0 && size.is_finite()) {
            return None;
        }
        let height = size.dot(up);
        // What is flat has no height that would say how large a person is in it.
        let tall = if height > 0.02 * level.length() { height } else { 0.3 * level.length() };
        let scale = (tall / STOREY).min(1.0);
        let area = level.x * level.y;
        let cell = (CELL * scale).max((area / MOST_CELLS).sqrt());
        let counts = [level.x, level.y].map(|length| ((length / cell).ceil() as usize).max(1));
        let corner = DVec2::new(bounds.min.dot(axes[0]), bounds.min.dot(axes[1]));
        let mut plan = Self {
            triangles,
            bvh,
            up,
            axes,
            cell,
            headroom: HEADROOM * scale,
            scale,
            corner,
            counts,
            spaces: Vec::new(),
            links: Vec::new(),
        };
        let columns: Vec<Vec<Space>> = (0..counts[0] * counts[1])
            .into_par_iter()
            .map(|cell| plan.column(cell, plan.level(cell)))
            .collect();
        let mut ranges = Vec::with_capacity(columns.len());
        for column in columns {
            let start = plan.spaces.len() as u32;
            plan.spaces.extend(column);
            ranges.push(start..plan.spaces.len() as u32);
        }
        plan.links = plan.linked(&ranges);
        Some(plan)
    }

    /// Level coordinates of the middle of a column, a hair beside it: edges of a model like round numbers.
    pub(super) fn level(&self, cell: usize) -> DVec2 {
        let at = DVec2::new((cell % self.counts[0]) as f64, (cell / self.counts[0]) as f64);
        self.corner + (at + DVec2::new(0.500_31, 0.499_57)) * self.cell
    }

    /// The point of a column at this height.
    pub(super) fn at(&self, cell: usize, height: f64) -> DVec3 {
        self.point(self.level(cell), height)
    }

    /// The point of these level coordinates at this height.
    pub(super) fn point(&self, level: DVec2, height: f64) -> DVec3 {
        self.axes[0] * level.x + self.axes[1] * level.y + self.up * height
    }

    /// The column that holds these level coordinates.
    pub(super) fn cell_at(&self, level: DVec2) -> Option<usize> {
        let at = ((level - self.corner) / self.cell).floor();
        // Casting saturates.
        let [x, y] = [at.x as usize, at.y as usize];
        (at.min_element() >= 0.0 && x < self.counts[0] && y < self.counts[1]).then(|| y * self.counts[0] + x)
    }

    /// The spaces at a place of a column, from above.
    pub(super) fn column(&self, cell: usize, at: DVec2) -> Vec<Space> {
        let flat = |p: DVec3| DVec2::new(p.dot(self.axes[0]), p.dot(self.axes[1]));
        let bounds = self.bvh.bounds();
        let line = Aabb::around([bounds.min, bounds.max].map(|end| self.point(at, end.dot(self.up))));
        let mut met: Vec<(f64, bool)> = Vec::new();
        self.bvh.touching(&line, |id| {
            let corners = self.triangles[id as usize];
            let [a, b, c] = corners.map(flat);
            let (ab, ac, ap) = (b - a, c - a, at - a);
            let twice = ab.perp_dot(ac);
            // A wall stands beside the line, never in it.
            if twice == 0.0 {
                return;
            }
            let (u, v) = (ap.perp_dot(ac) / twice, ab.perp_dot(ap) / twice);
            if u >= 0.0 && v >= 0.0 && u + v <= 1.0 {
                let [h, hb, hc] = corners.map(|p| p.dot(self.up));
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
                met.push((h + u * (hb - h) + v * (hc - h), normal.dot(self.up) > 0.0));
            }
        });
        met.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut layers: Vec<Layer> = Vec::new();
        for (height, up) in met {
            match layers.last_mut() {
                Some(last) if last.height - height < SAME * self.scale => {
                    (last.up, last.down) = (last.up || up, last.down || !up);
                }
                _ => layers.push(Layer { height, up, down: !up }),
            }
        }
        let open = layers.first().map(|top| Space {
            cell: cell as u32,
            floor: top.height,
            ceiling: f64::INFINITY,
            kind: Kind::Open,
        });
        let between = layers.windows(2).filter(|pair| pair[0].height - pair[1].height >= GAP * self.scale);
        let roofed = between.map(|pair| Space {
            cell: cell as u32,
            floor: pair[1].height,
            ceiling: pair[0].height,
            kind: if pair[1].up || pair[0].down { Kind::Roofed } else { Kind::InsideOut },
        });
        open.into_iter().chain(roofed).collect()
    }

    fn linked(&self, ranges: &[Range<u32>]) -> Vec<Vec<u32>> {
        let ahead: Vec<Vec<u32>> = self
            .spaces
            .par_iter()
            .map(|space| {
                let (x, y) = (space.cell as usize % self.counts[0], space.cell as usize / self.counts[0]);
                let beside = [(x + 1, y), (x, y + 1)];
                let beside = beside.into_iter().filter(|&(x, y)| x < self.counts[0] && y < self.counts[1]);
                beside
                    .filter_map(|(x, y)| {
                        let range = ranges[y * self.counts[0] + x].clone();
                        range.into_iter().find(|&other| self.are_joined(space, &self.spaces[other as usize]))
                    })
                    .collect()
            })
            .collect();
        let mut links = vec![Vec::new(); self.spaces.len()];
        for (space, others) in ahead.into_iter().enumerate() {
            for other in others {
                links[space].push(other);
                links[other as usize].push(space as u32);
            }
        }
        links
    }

    /// Whether nothing stands between two spaces of neighbouring columns.
    fn are_joined(&self, a: &Space, b: &Space) -> bool {
        let (low, high) = (a.floor.max(b.floor), a.ceiling.min(b.ceiling));
        let overlap = high - low;
        let is_step = a.kind == Kind::Open && (a.floor - b.floor).abs() > STEP * self.scale;
        if a.kind != b.kind || is_step || overlap < 0.7 * GAP * self.scale {
            return false;
        }
        let height = match high.is_finite() {
            true => high - (BELOW_CEILING * self.scale).min(0.2 * overlap),
            false => low + 0.7 * self.headroom,
        };
        let (from, to) = (self.at(a.cell as usize, height), self.at(b.cell as usize, height));
        !self.bvh.occluded(&Ray { origin: from, direction: to - from }, 0.0, 1.0)
    }
}
