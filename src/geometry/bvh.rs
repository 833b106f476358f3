use super::Aabb;
use crate::watch::Cancelled;
use glam::DVec3;

/// A half-line. `direction` need not be of unit length: distances are in its multiples.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Where it goes; must not be zero.
    pub direction: DVec3,
}

/// The nearest crossing of a ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Index of the triangle in the list that the hierarchy was built from.
    pub triangle: u32,
    /// Multiple of the ray's direction.
    pub distance: f64,
    /// Barycentric weight of the triangle's second corner.
    pub u: f64,
    /// Barycentric weight of the triangle's third corner.
    pub v: f64,
}

/// A bounding volume hierarchy over triangles (binned surface area heuristic).
#[derive(Clone, Debug, Default)]
pub struct Bvh {
    nodes: Vec<Node>,
    /// Triangles in leaf order: first corner and the two edges from it.
    triangles: Vec<[DVec3; 3]>,
    /// For each triangle in leaf order its index in the builder's list.
    order: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    bounds: Aabb,
    /// Leaf: index of the first triangle. Inner: index of the right child (the left one follows).
    first: u32,
    /// Triangles in the leaf; zero for an inner node.
    count: u32,
}

const LEAF_SIZE: usize = 4;
const BINS: usize = 16;
/// Nodes of more triangles than this ask first whether to end.
const BETWEEN_LOOKS: usize = 4096;
/// Deep enough for any tree that [`Bvh::build`] makes: below this depth it splits in the middle.
const MAX_DEPTH: usize = 60;

impl Bvh {
    /// Builds the hierarchy. Triangles without area are kept and never hit.
    pub fn build(triangles: &[[DVec3; 3]]) -> Self {
        Self::build_unless(triangles, &|| false).unwrap_or_default()
    }

    /// As [`Self::build`]; asks every few thousand triangles whether to end.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn build_unless(triangles: &[[DVec3; 3]], cancelled: &dyn Fn() -> bool) -> Result<Self, Cancelled> {
        let mut order: Vec<u32> = (0..triangles.len() as u32).collect();
        let bounds: Vec<Aabb> = triangles.iter().map(|t| Aabb::around(*t)).collect();
        let mut bvh = Self::default();
        if !triangles.is_empty() {
            bvh.split(&bounds, &mut order, (0, 0), cancelled)?;
        }
        bvh.triangles = order
            .iter()
            .map(|&i| {
                let [a, b, c] = triangles[i as usize];
                [a, b - a, c - a]
            })
            .collect();
        bvh.order = order;
        Ok(bvh)
    }

    fn split(
        &mut self,
        bounds: &[Aabb],
        order: &mut [u32],
        (offset, depth): (usize, usize),
        cancelled: &dyn Fn() -> bool,
    ) -> Result<(), Cancelled> {
        if order.len() > BETWEEN_LOOKS && cancelled() {
            return Err(Cancelled);
        }
        let node_bounds = order.iter().fold(Aabb::EMPTY, |sum, &i| sum.union(bounds[i as usize]));
        let index = self.nodes.len();
        self.nodes.push(Node { bounds: node_bounds, first: offset as u32, count: order.len() as u32 });
        if order.len() <= LEAF_SIZE {
            return Ok(());
        }
        let centres = Aabb::around(order.iter().map(|&i| bounds[i as usize].centre()));
        let middle = (depth < MAX_DEPTH / 2)
            .then(|| partition_by_bins(bounds, order, &centres))
            .flatten()
            .unwrap_or_else(|| {
                let axis = centres.size().max_position();
                let middle = order.len() / 2;
                order.select_nth_unstable_by(middle, |&a, &b| {
                    let (a_centre, b_centre) = (bounds[a as usize].centre(), bounds[b as usize].centre());
                    a_centre[axis].total_cmp(&b_centre[axis]).then(a.cmp(&b))
                });
                middle
            });
        let (left, right) = order.split_at_mut(middle);
        self.split(bounds, left, (offset, depth + 1), cancelled)?;
        let right_index = self.nodes.len() as u32;
        self.split(bounds, right, (offset + middle, depth + 1), cancelled)?;
        self.nodes[index].first = right_index;
        self.nodes[index].count = 0;
        Ok(())
    }

    /// The box around everything.
    pub fn bounds(&self) -> Aabb {
        self.nodes.first().map_or(Aabb::EMPTY, |node| node.bounds)
    }

    /// The nearest triangle that the ray meets with `min < distance < max`.
    pub fn nearest(&self, ray: &Ray, min: f64, max: f64) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, min, max, |hit| {
            best = Some(hit);
            Some(hit.distance)
        });
        best
    }

    /// As [`Bvh::nearest`], of the triangles that `accept` takes by their index.
    pub fn nearest_where(
        &self,
        ray: &Ray,
        min: f64,
        mut max: f64,
        accept: impl Fn(u32) -> bool,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        self.walk(ray, min, max, |hit| {
            if accept(hit.triangle) {
                best = Some(hit);
                max = hit.distance;
            }
            Some(max)
        });
        best
    }

    /// Whether anything stands on the ray with `min < distance < max`.
    pub fn occluded(&self, ray: &Ray, min: f64, max: f64) -> bool {
        let mut blocked = false;
        self.walk(ray, min, max, |_| {
            blocked = true;
            None
        });
        blocked
    }

    /// As [`Bvh::occluded`], by the triangles that `accept` takes by their index.
    pub fn occluded_where(&self, ray: &Ray, min: f64, max: f64, accept: impl Fn(u32) -> bool) -> bool {
        let mut blocked = false;
        self.walk(ray, min, max, |hit| {
            blocked = accept(hit.triangle);
            (!blocked).then_some(max)
        });
        blocked
    }

    /// Calls `found` with the index of each triangle whose box meets `bounds`, in no order that means
    /// anything but always the same.
    pub fn touching(&self, bounds: &Aabb, mut found: impl FnMut(u32)) {
        let mut stack = Vec::with_capacity(MAX_DEPTH);
        stack.extend((!self.nodes.is_empty()).then_some(0_u32));
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !node.bounds.meets(bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, index + 1]);
                continue;
            }
            let leaf = node.first as usize..(node.first + node.count) as usize;
            for (&[a, ab, ac], &id) in self.triangles[leaf.clone()].iter().zip(&self.order[leaf]) {
                if Aabb::around([a, a + ab, a + ac]).meets(bounds) {
                    found(id);
                }
            }
        }
    }

    /// Calls `found` with the index of each triangle whose leaf is reached by going into the boxes that `enter`
    /// takes, always in the same order.
    pub fn select(&self, enter: impl Fn(&Aabb) -> bool, mut found: impl FnMut(u32)) {
        let mut stack = Vec::with_capacity(MAX_DEPTH);
        stack.extend((!self.nodes.is_empty()).then_some(0_u32));
        while let Some(index) = stack.pop() {
            let node = &self.nodes[index as usize];
            if !enter(&node.bounds) {
                continue;
            }
            if node.count == 0 {
                stack.extend([node.first, index + 1]);
            } else {
                let leaf = node.first as usize..(node.first + node.count) as usize;
                self.order[leaf].iter().for_each(|&id| found(id));
            }
        }
    }

    /// Calls `found` for all triangles that the ray meets with `min < distance < max`, in no order.
    pub fn each(&self, ray: &Ray, min: f64, max: f64, mut found: impl FnMut(Hit)) {
        self.walk(ray, min, max, |hit| {
            found(hit);
            Some(max)
        });
    }

    /// Calls `found` for each nearer and nearer hit; it returns the new limit, or `None` to stop.
    fn walk(&self, ray: &Ray, min: f64, mut max: f64, mut found: impl FnMut(Hit) -> Option<f64>) {
        if self.nodes.is_empty() {
            return;
        }
        let inverse = ray.direction.recip();
        let mut stack = [0_u32; MAX_DEPTH + 64];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let index = stack[height];
            let node = &self.nodes[index as usize];
            if node.entry(ray.origin, inverse, min, max).is_none() {
                continue;
            }
            if node.count == 0 {
                let (left, right) = (index + 1, node.first);
                let left_entry = self.nodes[left as usize].entry(ray.origin, inverse, min, max);
                let right_entry = self.nodes[right as usize].entry(ray.origin, inverse, min, max);
                match (left_entry, right_entry) {
                    (Some(l), Some(r)) => {
                        let (near, far) = if l <= r { (left, right) } else { (right, left) };
                        stack[height] = far;
                        stack[height + 1] = near;
                        height += 2;
                    }
                    (Some(_), None) => {
                        stack[height] = left;
                        height += 1;
                    }
                    (None, Some(_)) => {
                        stack[height] = right;
                        height += 1;
                    }
                    (None, None) => {}
                }
                continue;
            }
            let leaf = node.first as usize..(node.first + node.count) as usize;
            for (triangle, &id) in self.triangles[leaf.clone()].iter().zip(&self.order[leaf]) {
                if let Some((distance, u, v)) = crossing(ray, triangle)
                    && distance > min
                    && distance < max
                {
                    match found(Hit { triangle: id, distance, u, v }) {
                        Some(limit) => max = limit,
                        None => return,
                    }
                }
            }
        }
    }
}

impl Node {
    /// Distance at which the ray enters the box, if it does so within the limits.
    fn entry(&self, origin: DVec3, inverse: DVec3, min: f64, max: f64) -> Option<f64> {
        let a = (self.bounds.min - origin) * inverse;
        let b = (self.bounds.max - origin) * inverse;
        // 0 * infinity: the ray runs in a face of the box, or between two; that axis has no say.
        let is_free = (a + b).is_nan_mask();
        let near = DVec3::select(is_free, DVec3::NEG_INFINITY, a.min(b)).max_element().max(min);
        let far = DVec3::select(is_free, DVec3::INFINITY, a.max(b)).min_element().min(max);
        // A part in 1e12 of slack: boxes of flat triangles have no thickness.
        (near <= far * (1.0 + 1e-12) + 1e-300).then_some(near)
    }
}

/// Möller & Trumbore 1997: distance and barycentric weights.
fn crossing(ray: &Ray, &[corner, edge1, edge2]: &[DVec3; 3]) -> Option<(f64, f64, f64)> {
    let p = ray.direction.cross(edge2);
    let determinant = edge1.dot(p);
    if determinant == 0.0 {
        return None;
    }
    let inverse = 1.0 / determinant;
    let s = ray.origin - corner;
    let u = s.dot(p) * inverse;
    if !(-1e-12..=1.0 + 1e-12).contains(&u) {
        return None;
    }
    let q = s.cross(edge1);
    let v = ray.direction.dot(q) * inverse;
    if v < -1e-12 || u + v > 1.0 + 1e-12 {
        return None;
    }
    let distance = edge2.dot(q) * inverse;
    distance.is_finite().then_some((distance, u, v))
}

/// Reorders `order` at the cheapest of the bin borders; `None` where no border separates.
fn partition_by_bins(bounds: &[Aabb], order: &mut [u32], centres: &Aabb) -> Option<usize> {
    let size = centres.size();
    let axis = size.max_position();
    if size[axis] <= 0.0 {
        return None;
    }
    let scale = BINS as f64 / size[axis];
    let bin_of = |i: u32| {
        let along = (bounds[i as usize].centre()[axis] - centres.min[axis]) * scale;
        (along as usize).min(BINS - 1)
    };
    let mut bins = [(Aabb::EMPTY, 0_usize); BINS];
    for &i in order.iter() {
        let bin = &mut bins[bin_of(i)];
        bin.0 = bin.0.union(bounds[i as usize]);
        bin.1 += 1;
    }
    let mut right_cost = [0.0; BINS];
    let mut sum = (Aabb::EMPTY, 0);
    for k in (1..BINS).rev() {
        sum = (sum.0.union(bins[k].0), sum.1 + bins[k].1);
        right_cost[k] = sum.0.half_area() * sum.1 as f64;
    }
    let mut best = (f64::INFINITY, 0);
    let mut sum = (Aabb::EMPTY, 0);
    for k in 1..BINS {
        sum = (sum.0.union(bins[k - 1].0), sum.1 + bins[k - 1].1);
        let cost = sum.0.half_area() * sum.1 as f64 + right_cost[k];
        if sum.1 > 0 && sum.1 < order.len() && cost < best.0 {
            best = (cost, k);
        }
    }
    if best.1 == 0 {
        return None;
    }
    // Stable, so that the tree depends on the input alone.
    order.sort_by_key(|&i| bin_of(i) >= best.1);
    Some(order.partition_point(|&i| bin_of(i) < best.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pseudo-random numbers in 0..1 (a Weyl sequence with a mixed state): tests need no crate.
    fn numbers(count: usize) -> Vec<f64> {
        let mut state = 1_u64;
        (0..count)
            .map(|_| {
                state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
                (state >> 11) as f64 / (1_u64 << 53) as f64
            })
            .collect()
    }

    #[test]
    fn the_nearest_hit_is_that_of_the_brute_force_search() {
        let r = numbers(9 * 500);
        let triangles: Vec<[DVec3; 3]> = r
            .chunks_exact(9)
            .map(|c| {
                let a = DVec3::new(c[0], c[1], c[2]);
                [a, a + 0.2 * DVec3::new(c[3], c[4], c[5]), a + 0.2 * DVec3::new(c[6], c[7], c[8])]
            })
            .collect();
        let bvh = Bvh::build(&triangles);
        let mut hits = 0;
        for c in numbers(6 * 2000).chunks_exact(6) {
            let ray = Ray {
                origin: DVec3::new(c[0], c[1], c[2]),
                direction: DVec3::new(c[3] - 0.5, c[4] - 0.5, c[5] - 0.5),
            };
            let brute = triangles
                .iter()
                .filter_map(|&[a, b, c]| crossing(&ray, &[a, b - a, c - a]))
                .map(|(t, ..)| t)
                .filter(|&t| t > 0.0)
                .min_by(f64::total_cmp);
            let found = bvh.nearest(&ray, 0.0, f64::INFINITY).map(|hit| hit.distance);
            assert_eq!(found, brute);
            assert_eq!(bvh.occluded(&ray, 0.0, f64::INFINITY), brute.is_some());
            hits += usize::from(brute.is_some());
        }
        assert!(hits > 100, "the test must hit something: {hits}");
    }

    #[test]
    fn the_boxes_that_meet_one_are_those_of_the_brute_force_search() {
        let triangles: Vec<[DVec3; 3]> = numbers(9 * 300)
            .chunks_exact(9)
            .map(|c| {
                let a = DVec3::new(c[0], c[1], c[2]);
                [a, a + 0.1 * DVec3::new(c[3], c[4], c[5]), a + 0.1 * DVec3::new(c[6], c[7], c[8])]
            })
            .collect();
        let bvh = Bvh::build(&triangles);
        let mut met = 0;
        for c in numbers(6 * 100).chunks_exact(6) {
            let corner = DVec3::new(c[0], c[1], c[2]);
            let bounds = Aabb::around([corner, corner + 0.2 * DVec3::new(c[3], c[4], c[5])]);
            let (mut found, mut brute) = (Vec::new(), Vec::new());
            bvh.touching(&bounds, |i| found.push(i));
            brute.extend((0..300_u32).filter(|&i| Aabb::around(triangles[i as usize]).meets(&bounds)));
            found.sort_unstable();
            assert_eq!(found, brute);
            met += brute.len();
        }
        assert!(met > 50, "{met}");
    }

    #[test]
    fn axis_parallel_rays_hit_axis_parallel_squares() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y];
        let bvh = Bvh::build(&[square]);
        let ray = Ray { origin: DVec3::new(0.5, 0.25, 3.0), direction: DVec3::NEG_Z };
        assert_eq!(bvh.nearest(&ray, 0.0, f64::INFINITY).map(|h| h.distance), Some(3.0));
        assert!(bvh.nearest(&ray, 0.0, 2.9).is_none());
        assert!(Bvh::build(&[]).nearest(&ray, 0.0, 9.0).is_none());
    }

    #[test]
    fn axis_parallel_rays_do_not_slip_through_the_seams_of_a_grid() {
        let corner = |i: u32| DVec3::new(f64::from(i % 9), f64::from(i / 9), 0.0);
        let squares = (0..64).map(|i| corner(i % 8 + 9 * (i / 8)));
        let triangles: Vec<[DVec3; 3]> = squares
            .flat_map(|p| {
                let (q, r, s) = (p + DVec3::X, p + DVec3::X + DVec3::Y, p + DVec3::Y);
                [[p, q, r], [p, r, s]]
            })
            .collect();
        let bvh = Bvh::build(&triangles);
        for i in 0..81 {
            let ray = Ray { origin: corner(i) + DVec3::Z, direction: DVec3::NEG_Z };
            assert_eq!(bvh.nearest(&ray, 0.0, 9.0).map(|hit| hit.distance), Some(1.0), "{}", corner(i));
        }
    }
}
