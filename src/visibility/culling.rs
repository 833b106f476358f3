//! Which regions a receiving point may see at all, without a loss: a tree of boxes is walked, and
//! whatever lies below the horizon or wholly in the shadow of one large surface is left out.

use glam::DVec3;

/// A tree of boxes over regions, and the large convex surfaces that may hide them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Culling {
    nodes: Vec<Node>,
    order: Vec<u32>,
    blockers: Vec<Blocker>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    middle: DVec3,
    half: DVec3,
    /// Leaf: its range in `order`. Inner: `count` is 0 and `first` the right child.
    first: u32,
    count: u32,
}

#[derive(Clone, Debug)]
struct Blocker {
    corners: Vec<DVec3>,
    middle: DVec3,
    normal: DVec3,
    area: f64,
}

/// Half-spaces whose common part is the shadow of a blocker as seen from a point: `n·x >= c`.
#[derive(Clone, Debug, Default)]
struct Shadow {
    planes: Vec<(DVec3, f64)>,
}

const LEAF: usize = 4;
/// The largest blockers of a point, no more: each costs a test a box.
const SHADOWS: usize = 12;

impl Culling {
    /// `boxes` are middles and half sizes, one a region.
    pub(crate) fn new(boxes: &[(DVec3, DVec3)], blockers: &[Vec<DVec3>]) -> Self {
        let mut culling = Self { order: (0..boxes.len() as u32).collect(), ..Self::default() };
        let mut order = std::mem::take(&mut culling.order);
        if !order.is_empty() {
            culling.split(boxes, &mut order, 0);
        }
        culling.order = order;
        culling.blockers = blockers
            .iter()
            .map(|corners| {
                let area_vector = crate::geometry::polygon::area_vector(corners);
                Blocker {
                    corners: corners.clone(),
                    middle: corners.iter().sum::<DVec3>() / corners.len() as f64,
                    normal: area_vector.normalize_or_zero(),
                    area: area_vector.length(),
                }
            })
            .collect();
        culling
    }

    fn split(&mut self, boxes: &[(DVec3, DVec3)], order: &mut [u32], offset: usize) {
        let mut bounds = crate::geometry::Aabb::EMPTY;
        let mut middles = crate::geometry::Aabb::EMPTY;
        for &i in order.iter() {
            let (middle, half) = boxes[i as usize];
            bounds.include(middle - half);
            bounds.include(middle + half);
            middles.include(middle);
        }
        let index = self.nodes.len();
        self.nodes.push(Node {
            middle: bounds.centre(),
            half: 0.5 * bounds.size(),
            first: offset as u32,
            count: order.len() as u32,
        });
        if order.len() <= LEAF {
            return;
        }
        let axis = middles.size().max_position();
        let half = order.len() / 2;
        order.select_nth_unstable_by(half, |&a, &b| {
            boxes[a as usize].0[axis].total_cmp(&boxes[b as usize].0[axis]).then(a.cmp(&b))
        });
        let (left, right) = order.split_at_mut(half);
        self.split(boxes, left, offset);
        self.nodes[index].first = self.nodes.len() as u32;
        self.nodes[index].count = 0;
        self.split(boxes, right, offset + half);
    }

    /// Fills `found` with the regions that may be seen from `point` above its horizon.
    ///
    /// Heights below `contact` count as none; what lies less than `thickness` behind a surface may lie on
    /// its back, and is not hidden by it.
    pub(crate) fn candidates(
        &self,
        point: DVec3,
        normal: DVec3,
        [contact, thickness]: [f64; 2],
        found: &mut Vec<u32>,
    ) {
        let shadows = self.shadows(point, normal, contact, thickness);
        self.walk(found, |node| {
            let middle = node.middle - point;
            normal.dot(middle) + normal.abs().dot(node.half) <= contact
                || shadows.iter().any(|shadow| shadow.holds(middle, node.half))
        });
    }

    /// Fills `found` with the regions of the nodes that are not left out.
    fn walk(&self, found: &mut Vec<u32>, is_left_out: impl Fn(&Node) -> bool) {
        found.clear();
        if self.nodes.is_empty() {
            return;
        }
        let mut stack = vec![0_u32];
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if is_left_out(node) {
                continue;
            }
            if node.count == 0 {
                stack.push(node.first);
                stack.push(index + 1);
            } else {
                found.extend(&self.order[node.first as usize..(node.first + node.count) as usize]);
            }
        }
        // In the order of the regions, whatever the tree.
        found.sort_unstable();
    }

    /// Fills `found` with the regions that may have a part where all of these `n·x >= c`, whatever hides them.
    pub(crate) fn within(&self, planes: &[(DVec3, f64)], found: &mut Vec<u32>) {
        self.walk(found, |node| {
            planes
                .iter()
                .any(|(normal, offset)| normal.dot(node.middle) + normal.abs().dot(node.half) < *offset)
        });
    }

    /// The shadows of the blockers that cover most of the view.
    fn shadows(&self, point: DVec3, normal: DVec3, contact: f64, thickness: f64) -> Vec<Shadow> {
        let mut ranked: Vec<(f64, usize)> = Vec::new();
        for (index, blocker) in self.blockers.iter().enumerate() {
            let to = blocker.middle - point;
            let distance2 = to.length_squared();
            let facing = blocker.normal.dot(to).abs();
            let covered = blocker.area * facing / (distance2 * distance2.sqrt()).max(f64::MIN_POSITIVE);
            let above = blocker.corners.iter().any(|c| normal.dot(*c - point) > contact);
            if facing > thickness && covered > 0.02 && above {
                ranked.push((covered, index));
            }
        }
        let order = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
        if ranked.len() > SHADOWS {
            ranked.select_nth_unstable_by(SHADOWS, order);
            ranked.truncate(SHADOWS);
        }
        ranked.sort_unstable_by(order);
        ranked.into_iter().map(|(_, index)| self.blockers[index].shadow(point, thickness)).collect()
    }
}

impl Blocker {
    /// The pyramid through the corners with its top at `point`, behind the blocker. Coordinates are
    /// relative to `point`.
    fn shadow(&self, point: DVec3, thickness: f64) -> Shadow {
        let height = self.normal.dot(self.middle - point);
        let sign = height.signum();
        let mut planes = Vec::with_capacity(self.corners.len() + 1);
        // Strictly behind, and not on its back.
        planes.push((self.normal * sign, height.abs() + thickness));
        for i in 0..self.corners.len() {
            let (a, b) = (self.corners[i] - point, self.corners[(i + 1) % self.corners.len()] - point);
            planes.push((a.cross(b) * sign, 0.0));
        }
        Shadow { planes }
    }
}

impl Shadow {
    /// Whether a box lies wholly inside.
    fn holds(&self, middle: DVec3, half: DVec3) -> bool {
        self.planes.iter().all(|(normal, offset)| normal.dot(middle) - normal.abs().dot(half) >= *offset)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_behind_a_wall_is_left_out_and_one_beside_it_is_not() {
        let wall = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 1.0));
        let half = DVec3::splat(0.1);
        let boxes: Vec<(DVec3, DVec3)> = [
            DVec3::new(0.0, 0.0, 0.5),  // before the wall
            DVec3::new(0.0, 0.0, 3.0),  // behind it
            DVec3::new(6.0, 0.0, 3.0),  // beside its shadow
            DVec3::new(3.0, 0.0, 3.0),  // on the shadow's border
            DVec3::new(0.0, 0.0, -1.0), // below the horizon
        ]
        .map(|middle| (middle, half))
        .to_vec();
        for winding in [wall.to_vec(), wall.iter().rev().copied().collect()] {
            let culling = Culling::new(&boxes, &[winding]);
            let mut found = Vec::new();
            culling.candidates(DVec3::ZERO, DVec3::Z, [1e-9; 2], &mut found);
            // A leaf is taken whole, so ask for each box alone too.
            let alone: Vec<usize> = (0..boxes.len())
                .filter(|&i| {
                    let single = Culling::new(&boxes[i..=i], &[culling.blockers[0].corners.clone()]);
                    single.candidates(DVec3::ZERO, DVec3::Z, [1e-9; 2], &mut found);
                    !found.is_empty()
                })
                .collect();
            assert_eq!(alone, [0, 2, 3]);
        }
    }
}
