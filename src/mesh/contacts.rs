//! Lines along which surfaces stand on others or cut through them: light may jump there, so patches end there.

use super::pieces::{Cut, Grid, extent, span};
use super::regions::{Outline, Welder};
use crate::geometry::{Aabb, Bvh, polygon};
use crate::watch::Cancelled;
use glam::{DVec2, DVec3};
use std::collections::{HashMap, HashSet};

/// What stands on a cell matters where it is at least so wide, over the root of the cell's area.
const WORTH: f64 = 0.35;
/// Shorter edges than this of it are not followed.
const SHORTEST: f64 = 0.05;
/// A cell is cut along so many lines at most, the longest: a hedge on a lawn is not traced leaf by leaf.
const MOST_LINES: usize = 48;

/// Finds where the outlines of a scene touch and cross each other.
pub(super) struct Contacts<'a> {
    outlines: &'a [Outline],
    /// Over the bounds of the outlines, each the diagonal of its box.
    boxes: Bvh,
    /// All edges, and a tree over them as triangles without area.
    segments: Vec<Segment>,
    edges: Bvh,
    /// Lengths below this count as none, metres.
    tolerance: f64,
}

/// A line along which something stands on a region or cuts through it, in the region's plane coordinates.
pub(super) struct Contact {
    pub(super) ends: [DVec2; 2],
    /// Extent of all lines that it is joined to, end to end: the width of what stands there.
    width: f64,
}

struct Segment {
    owner: usize,
    ends: [DVec3; 2],
}

impl<'a> Contacts<'a> {
    /// Fails where it was `cancelled`.
    pub(super) fn new(
        outlines: &'a [Outline],
        scene_size: f64,
        cancelled: &dyn Fn() -> bool,
    ) -> Result<Self, Cancelled> {
        let of = |(owner, outline): (usize, &Outline)| -> Vec<Segment> {
            let segment = |edge: &[DVec2; 2]| Segment { owner, ends: edge.map(|c| outline.world(c)) };
            outline.edges.iter().map(segment).collect()
        };
        let segments: Vec<Segment> = outlines.iter().enumerate().flat_map(of).collect();
        let flat: Vec<[DVec3; 3]> = segments.iter().map(|s| [s.ends[0], s.ends[1], s.ends[1]]).collect();
        let edges = Bvh::build_unless(&flat, cancelled)?;
        let flat: Vec<[DVec3; 3]> =
            outlines.iter().map(|o| [o.bounds.min, o.bounds.max, o.bounds.max]).collect();
        let boxes = Bvh::build_unless(&flat, cancelled)?;
        Ok(Self { outlines, boxes, segments, edges, tolerance: 1e-6 * scene_size })
    }

    /// Lines in the plane of an outline that matter to cells of edge `shortest` or longer.
    pub(super) fn on(&self, index: usize, outline: &Outline, shortest: f64) -> Vec<Contact> {
        // Ends that meet are one, and so are lines between the same ends.
        let mut welder = Welder::new(self.tolerance);
        let (mut found, mut known) = (Vec::new(), HashSet::new());
        for [a, b] in self.standing_on(index, outline).chain(self.crossing(index, outline)) {
            let is_long = a.distance(b) >= SHORTEST * shortest;
            if is_long
                && a.min(b).cmplt(outline.max - self.tolerance).all()
                && a.max(b).cmpgt(outline.min + self.tolerance).all()
            {
                let mut key = [a, b].map(|end| welder.index(end.extend(0.0)));
                key.sort_unstable();
                if known.insert(key) {
                    found.push((key, [a, b]));
                }
            }
        }
        let width = widths(&welder.points, found.iter().map(|line| line.0));
        let contacts = found.into_iter().map(|([end, _], ends)| Contact { ends, width: width[end as usize] });
        contacts.filter(|contact| contact.width >= WORTH * shortest).collect()
    }

    /// Whether both have holes: leaves that stick in each other throw no edge of a shadow there.
    fn are_leaves(&self, one: usize, other: usize) -> bool {
        self.outlines[one].has_holes && self.outlines[other].has_holes
    }

    /// Edges of other outlines that lie in the plane of this one.
    fn standing_on(&self, index: usize, outline: &Outline) -> impl Iterator<Item = [DVec2; 2]> {
        let mut near = Vec::new();
        self.edges.touching(&outline.bounds.grown(self.tolerance), |s| near.push(s));
        near.sort_unstable();
        near.into_iter().filter_map(move |s| {
            let segment = &self.segments[s as usize];
            let [a, b] = segment.ends.map(|end| outline.frame.local(end - outline.origin));
            let lies_in_plane = a.z.abs() <= self.tolerance && b.z.abs() <= self.tolerance;
            let counts = segment.owner != index && !self.are_leaves(segment.owner, index);
            (counts && lies_in_plane).then(|| [a.truncate(), b.truncate()])
        })
    }

    /// Lines along which other outlines cut through the plane of this one.
    fn crossing(&self, index: usize, outline: &Outline) -> impl Iterator<Item = [DVec2; 2]> {
        let mut near = Vec::new();
        self.boxes.touching(&outline.bounds.grown(self.tolerance), |other| near.push(other as usize));
        near.sort_unstable();
        near.into_iter()
            .filter(move |&other| other != index && !self.are_leaves(other, index))
            .flat_map(move |other| crossing(&self.outlines[other], outline, self.tolerance))
    }
}

/// Where an outline cuts through the plane of another, in that plane's coordinates; none where it does not reach
/// farther than `tolerance` to both sides.
fn crossing(outline: &Outline, through: &Outline, tolerance: f64) -> Vec<[DVec2; 2]> {
    let local = |corner: DVec2| through.frame.local(outline.world(corner) - through.origin);
    let (mut low, mut high) = (0.0_f64, 0.0_f64);
    let mut points = Vec::new();
    for edge in &outline.edges {
        let [a, b] = edge.map(local);
        (low, high) = (low.min(a.z), high.max(a.z));
        if (a.z > 0.0) != (b.z > 0.0) {
            points.push((a + (b - a) * (a.z / (a.z - b.z))).truncate());
        }
    }
    if low > -tolerance || high < tolerance {
        return Vec::new();
    }
    // Every other stretch between them lies within the outline.
    let along = through.frame.normal.cross(outline.frame.normal);
    let along = through.frame.local(along).truncate();
    points.sort_by(|p, q| along.dot(*p).total_cmp(&along.dot(*q)));
    points.chunks_exact(2).map(|ends| [ends[0], ends[1]]).collect()
}

/// For each point the extent of all `lines` between points, by their indices, that lead to it.
fn widths(points: &[DVec3], lines: impl Iterator<Item = [u32; 2]>) -> Vec<f64> {
    let mut leader: Vec<u32> = (0..points.len() as u32).collect();
    let root = |leader: &mut [u32], mut k: u32| {
        while leader[k as usize] != k {
            leader[k as usize] = leader[leader[k as usize] as usize];
            k = leader[k as usize];
        }
        k
    };
    for [a, b] in lines {
        let (a, b) = (root(&mut leader, a), root(&mut leader, b));
        leader[a.max(b) as usize] = a.min(b);
    }
    let leads: Vec<u32> = (0..points.len() as u32).map(|k| root(&mut leader, k)).collect();
    let mut bounds = vec![Aabb::EMPTY; points.len()];
    for (&point, &k) in points.iter().zip(&leads) {
        bounds[k as usize].include(point);
    }
    leads.iter().map(|&k| bounds[k as usize].size().max_element()).collect()
}

/// Cuts along the `contacts` that matter to a cut; only these are left in the list.
pub(super) fn split(cuts: Vec<Cut>, grid: &Grid, contacts: &mut Vec<Contact>) -> Vec<Cut> {
    let mut by_cell: HashMap<u32, Vec<usize>> = HashMap::new();
    for (k, contact) in contacts.iter().enumerate() {
        let (min, max) = extent(&contact.ends);
        for j in span(min.y, max.y, grid.min.y, grid.cell.y, grid.cells[1]) {
            for i in span(min.x, max.x, grid.min.x, grid.cell.x, grid.cells[0]) {
                by_cell.entry(i + j * grid.cells[0]).or_default().push(k);
            }
        }
    }
    let mut matters = vec![false; contacts.len()];
    let mut result = Vec::new();
    for cut in cuts {
        // A line this near to the border of a piece is not worth a split: it would leave a sliver.
        let slack = 0.02 * cut.extent.min_element();
        let edge = (cut.extent.x * cut.extent.y).sqrt();
        let (min, max) = extent(&cut.corners);
        let matters_here = |k: &&usize| {
            let Contact { ends: [p, q], width } = contacts[**k];
            let is_near = p.min(q).cmple(max + slack).all() && p.max(q).cmpge(min - slack).all();
            is_near && width >= WORTH * edge && p.distance(q) >= SHORTEST * edge
        };
        let mut lines: Vec<usize> =
            by_cell.get(&cut.cell).into_iter().flatten().filter(matters_here).copied().collect();
        if lines.len() > MOST_LINES {
            let length = |k: usize| contacts[k].ends[0].distance(contacts[k].ends[1]);
            lines.sort_by(|&a, &b| length(b).total_cmp(&length(a)).then(a.cmp(&b)));
            lines.truncate(MOST_LINES);
        }
        let mut pending = vec![cut];
        for k in lines {
            let [p, q] = contacts[k].ends;
            matters[k] = true;
            let mut next = Vec::new();
            for cut in pending {
                let normal = (q - p).perp().normalize_or_zero();
                let offset = -normal.dot(p);
                let heights = cut.corners.iter().map(|&c| normal.dot(c) + offset);
                let (low, high) =
                    heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
                if low > -slack || high < slack || !crosses(&cut.corners, p, q, slack) {
                    next.push(cut);
                    continue;
                }
                for (bit, sign) in [(1_u64, 1.0), (2, -1.0)] {
                    let mut corners = Vec::new();
                    polygon::clip_2d(&cut.corners, normal * sign, offset * sign, &mut corners);
                    if corners.len() >= 3 && polygon::area_2d(&corners) > slack * slack {
                        let sides = cut.sides ^ (bit + 4 * k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
                        next.push(Cut { corners, sides, ..cut.clone() });
                    }
                }
            }
            pending = next;
            if pending.is_empty() {
                break;
            }
        }
        result.extend(pending);
    }
    let mut matters = matters.into_iter();
    contacts.retain(|_| matters.next().unwrap_or(false));
    result
}

/// Whether the segment from `p` to `q` runs through the inside of a convex polygon for more than `slack`.
fn crosses(corners: &[DVec2], p: DVec2, q: DVec2, slack: f64) -> bool {
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    let n = corners.len();
    for i in 0..n {
        let (a, b) = (corners[i], corners[(i + 1) % n]);
        let inward = (b - a).perp();
        let (fp, fq) = (inward.dot(p - a), inward.dot(q - a));
        if fp < 0.0 && fq < 0.0 {
            return false;
        }
        if fp < 0.0 {
            from = from.max(fp / (fp - fq));
        } else if fq < 0.0 {
            to = to.min(fp / (fp - fq));
        }
    }
    (to - from) * (q - p).length() > slack
}

#[cfg(test)]
mod tests {
    use crate::mesh::{MeshSettings, PatchTarget, build};
    use crate::scene::from_text;
    use glam::{DVec2, DVec3};

    #[test]
    fn a_small_surface_is_cut_where_something_small_stands_on_it() {
        // A plate of 10 cm under a peg of 4 cm, in a mesh of patches of 30 cm.
        let obj = "o plate\nv 0 1 0\nv 0.1 1 0\nv 0.1 1 0.1\nv 0 1 0.1\nf 4 3 2 1\n\
                   o peg\nv 0.01 1 0.02\nv 0.05 1 0.02\nv 0.05 1 0.06\nv 0.01 1 0.06\n\
                   v 0.01 1.2 0.02\nv 0.05 1.2 0.02\nv 0.05 1.2 0.06\nv 0.01 1.2 0.06\n\
                   f 5 9 10 6\nf 6 10 11 7\nf 7 11 12 8\nf 8 12 9 5\nf 12 11 10 9\n\
                   o floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 16 15 14 13\n";
        let scene = from_text("peg", obj, "", None).unwrap();
        let settings = MeshSettings { target: PatchTarget::Size(0.3), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).unwrap();
        let (low, high) = (DVec2::new(0.01, 0.02), DVec2::new(0.05, 0.06));
        let mut covered = 0.0;
        for patch in mesh.patches.iter().filter(|p| p.normal.y > 0.9 && (p.centre.y - 1.0).abs() < 1e-6) {
            let corners = mesh.pieces_of(patch).flat_map(|piece| mesh.polygon(piece, patch.side));
            let (mut inside, mut outside) = (false, false);
            for corner in corners.map(|c| DVec2::new(c.x, c.z)) {
                inside |= corner.cmpgt(low + 1e-6).all() && corner.cmplt(high - 1e-6).all();
                outside |= corner.cmplt(low - 1e-6).any() || corner.cmpgt(high + 1e-6).any();
            }
            assert!(!inside, "no corner lies under the peg");
            if !outside {
                covered += patch.area;
            }
        }
        assert!((covered - 0.04 * 0.04).abs() < 1e-9, "{covered} m² lie under the peg");
    }

    #[test]
    fn a_lamp_is_cut_where_what_holds_it_begins() {
        // A tile of 30 cm that shines down, on a post of 12 cm without a top.
        let obj = "mtllib post.mtl\nusemtl paint\no floor\nv -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\nf 4 3 2 1\n\
                   o post\nv 0.02 0 0.02\nv 0.14 0 0.02\nv 0.14 0 0.14\nv 0.02 0 0.14\n\
                   v 0.02 1 0.02\nv 0.14 1 0.02\nv 0.14 1 0.14\nv 0.02 1 0.14\n\
                   f 5 9 10 6\nf 6 10 11 7\nf 7 11 12 8\nf 8 12 9 5\n\
                   usemtl glow\no lamp\nv -0.15 1 -0.15\nv 0.15 1 -0.15\nv 0.15 1 0.15\nv -0.15 1 0.15\n\
                   f 13 14 15 16\n";
        let mtl = "newmtl paint\nKd 0.5 0.5 0.5\nnewmtl glow\nKd 0 0 0\nKe 1 1 1\n";
        let scene = from_text("post", obj, mtl, None).unwrap();
        let settings = MeshSettings { target: PatchTarget::Size(0.3), ..MeshSettings::default() };
        let mesh = build(&scene, &settings).unwrap();
        let lamps = || mesh.patches.iter().filter(|p| p.luminaire.is_some());
        let holder = |c: DVec3| (c.x - 0.08).abs().max((c.z - 0.08).abs()) < 0.06;
        let inside: f64 = lamps().filter(|p| holder(p.centre)).map(|p| p.area).sum();
        assert!((inside - 0.12 * 0.12).abs() < 1e-9, "{inside} m² of the lamp are in the post");
        let whole: f64 = lamps().map(|p| p.area).sum();
        assert!((whole - 0.09).abs() < 1e-9, "{whole}");
    }
}
