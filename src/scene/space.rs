//! What somebody would find who walks through a model: its floors, and how much room is above them.

use super::extent::Extent;
use super::types::Scene;
use super::views::triangles;
use crate::geometry::{Aabb, Bvh, Ray};
use glam::DVec3;

/// A face is level where its normal is this near to upright (the cosine of 8 degrees).
const LEVEL: f64 = 0.99;
/// Places at which the room above floors is measured.
const SOUNDINGS: usize = 400;

/// A point on a level face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Floor {
    pub(super) place: DVec3,
    /// Metres to what is above; `None` under the open sky.
    pub(super) headroom: Option<f64>,
}

/// The main part of a model, made ready for lines of sight.
pub(super) struct Space {
    bvh: Bvh,
    triangles: Vec<[DVec3; 3]>,
    /// Index of the surface that each triangle is a part of.
    owners: Vec<u32>,
    pub(super) main: Aabb,
    /// Lengths below this are nothing, metres.
    slack: f64,
}

impl Space {
    pub(super) fn of(scene: &Scene, extent: &Extent) -> Self {
        let (mut list, mut owners) = triangles(&scene.positions, &scene.surfaces);
        if !extent.stray.is_empty() {
            let is_main = |owner: &u32| extent.stray.binary_search(owner).is_err();
            let mut of_triangle = owners.iter();
            list.retain(|_| of_triangle.next().is_none_or(is_main));
            owners.retain(is_main);
        }
        Self {
            bvh: Bvh::build(&list),
            triangles: list,
            owners,
            main: extent.main,
            slack: 1e-6 * extent.scale,
        }
    }

    /// How far one sees from here; `None` into the void. The direction is of unit length.
    pub(super) fn distance(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        self.seen(origin, direction).map(|(distance, _)| distance)
    }

    /// How far one sees from here, and the surface that is seen.
    pub(super) fn seen(&self, origin: DVec3, direction: DVec3) -> Option<(f64, u32)> {
        let hit = self.bvh.nearest(&Ray { origin, direction }, 0.0, f64::INFINITY)?;
        Some((hit.distance, self.owners[hit.triangle as usize]))
    }

    /// About `count` points on level faces, spread evenly over the area and then over the number of faces,
    /// so that neither a large terrain nor a finely cut lamp takes them all.
    pub(super) fn floors(&self, up: DVec3, count: usize) -> Vec<Floor> {
        let level: Vec<(u32, f64)> = (0_u32..)
            .zip(&self.triangles)
            .filter_map(|(index, [a, b, c])| {
                let cross = (*b - *a).cross(*c - *a);
                let area = 0.5 * cross.length();
                (area > 0.0 && cross.dot(up).abs() > LEVEL * 2.0 * area).then_some((index, area))
            })
            .collect();
        let by_area = spread(&level, count.div_ceil(2), |(_, area)| area);
        let by_face = spread(&level, count / 2, |_| 1.0);
        by_area.chain(by_face).map(|(index, s, t)| self.floor(index, s, t, up)).collect()
    }

    fn floor(&self, triangle: u32, s: f64, t: f64, up: DVec3) -> Floor {
        let [a, b, c] = self.triangles[triangle as usize];
        let (s, t) = if s + t > 1.0 { (1.0 - s, 1.0 - t) } else { (s, t) };
        let place = a + (b - a) * s + (c - a) * t;
        self.floor_at(place, up)
    }

    fn floor_at(&self, place: DVec3, up: DVec3) -> Floor {
        let above = self.distance(place + up * self.slack, up);
        Floor { place, headroom: above.map(|room| room + self.slack) }
    }

    /// The floor below a place.
    pub(super) fn floor_below(&self, place: DVec3, up: DVec3) -> Option<Floor> {
        let down = self.distance(place - up * self.slack, -up)? + self.slack;
        Some(self.floor_at(place - up * down, up))
    }

    /// The height of the rooms, metres: half of the space between floors and what is above them is no
    /// higher. `None` where next to nothing is above any floor.
    pub(super) fn headroom(&self, up: DVec3) -> Option<f64> {
        // Slabs and furniture hold little space, so that rooms outweigh them.
        let floors = self.floors(up, SOUNDINGS);
        let area = &floors[..floors.len().div_ceil(2)];
        let mut heights: Vec<f64> = area.iter().filter_map(|floor| floor.headroom).collect();
        if 8 * heights.len() < area.len() || heights.is_empty() {
            return None;
        }
        heights.sort_unstable_by(f64::total_cmp);
        let half = 0.5 * heights.iter().sum::<f64>();
        let mut sum = 0.0;
        let middle = heights.iter().find(|height| {
            sum += **height;
            sum >= half
        });
        middle.copied().filter(|height| *height > 0.0)
    }
}

/// `count` places on triangles, evenly spread by `weight`: the triangle and two barycentric weights, whose
/// sum may exceed one.
fn spread(
    triangles: &[(u32, f64)],
    count: usize,
    weight: impl Fn((u32, f64)) -> f64,
) -> impl Iterator<Item = (u32, f64, f64)> {
    let total: f64 = triangles.iter().map(|&triangle| weight(triangle)).sum();
    let mut all = triangles.iter();
    let (mut sum, mut at) = (0.0, None);
    (0..if total > 0.0 { count } else { 0 })
        .filter_map(|k| {
            let wanted = (k as f64 + 0.5) / count as f64 * total;
            while sum < wanted {
                let Some(&next) = all.next() else { break };
                (sum, at) = (sum + weight(next), Some(next.0));
            }
            // The R2 sequence (Roberts 2018): no two samples of a large face are close together.
            let step = |ratio: f64| (0.5 + ratio * (k + 1) as f64).fract();
            at.map(|triangle| (triangle, step(0.754_877_666_246_692_8), step(0.569_840_290_998_053_3)))
        })
        .collect::<Vec<_>>()
        .into_iter()
}

#[cfg(test)]
mod tests {
    use super::super::from_text;
    use super::*;

    const ROOM: &str = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 5\nv 4 0 5\nv 4 3 5\nv 0 3 5\n\
        f 1 2 3 4\nf 1 5 6 2\nf 4 3 7 8\nf 1 4 8 5\nf 2 6 7 3\nf 5 8 7 6\n";

    fn space(obj: &str) -> Space {
        let scene = from_text("t", obj, "", Some("unit = \"m\"\nup = \"y\"")).unwrap();
        Space::of(&scene, &scene.extent())
    }

    #[test]
    fn the_height_of_a_room_is_found_in_spite_of_its_slab_and_its_table() {
        let level = |n: usize, y: f64, low: f64, high: f64| {
            format!(
                "v {low} {y} {low}\nv {high} {y} {low}\nv {high} {y} {high}\nv {low} {y} {high}\nf {} {} {} {}\n",
                n,
                n + 1,
                n + 2,
                n + 3
            )
        };
        let furnished = format!("{ROOM}{}{}", level(9, -0.3, 0.0, 4.0), level(13, 0.75, 1.0, 2.0));
        let height = |obj: &str, up: DVec3| space(obj).headroom(up).expect("a room");
        assert!((height(&furnished, DVec3::Y) - 3.0).abs() < 1e-9);
        assert!((height(ROOM, DVec3::X) - 4.0).abs() < 1e-9, "lying on its side");
        let open = "v 0 0 0\nv 4 0 0\nv 4 0 5\nv 0 0 5\nf 1 4 3 2\n";
        assert_eq!(space(open).headroom(DVec3::Y), None);
    }

    #[test]
    fn samples_lie_on_their_faces_and_all_over_them() {
        let found = space(ROOM).floors(DVec3::Y, 200);
        assert_eq!(found.len(), 200);
        assert!(found.iter().all(|floor| floor.place.y == 0.0 || floor.place.y == 3.0));
        for quarter in [[1.0, 1.0], [3.0, 1.0], [1.0, 4.0], [3.0, 4.0]] {
            let near = |floor: &&Floor| {
                (floor.place.x - quarter[0]).abs() < 1.0 && (floor.place.z - quarter[1]).abs() < 1.25
            };
            assert!(found.iter().filter(near).count() > 20, "{quarter:?}");
        }
    }
}
