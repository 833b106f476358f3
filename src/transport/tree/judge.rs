//! Which nodes stand for their patches in a row.
//!
//! A node N stands for its patches as if all of them were seen by the same share: sum_j F_ij x_j over them becomes
//! F_iN, the sum of their form factors, times the mean of x. What that changes is known where x is: most of what patches
//! send is direct light reflected once, and that is there before the rows, luminaire by luminaire. So each node is judged
//! by its actual error for each luminaire alone, and those nodes are taken that make the sum over all rows of the squared
//! error plus a price per entry least: one price for all rows, found from some of them, such that the error of the
//! whole is as asked.

use super::bounce;
use super::nodes::Tree;
use crate::mesh::{Patch, PatchMesh};
use crate::watch::{Cancelled, Watch};

/// Fields of what patches send that luminaires are judged by: where there are more, some share one.
pub(super) const LAMPS: usize = 10;
/// What surfaces pass on is known but roughly beforehand. What it may differ by is smooth: over the extent of the scene it
/// varies like its coordinates, and from side to side like the directions that they face.
const SMOOTH: usize = 6;
pub(super) const FIELDS: usize = LAMPS + SMOOTH;
/// How much of it differs over a tenth of the extent of the scene, and from one direction to another.
const GRADIENT: f64 = 0.3;
const TURN: f64 = 0.2;
/// Rooms are this part of the extent of a scene at most, about.
const ROOM: f64 = 0.25;
/// Mean reflectance at most, in what is expected to be passed on.
const BRIGHTEST: f64 = 0.8;

/// What is known of what patches send before the rows are.
#[derive(Clone, Copy, Debug)]
pub struct Sent<'a> {
    /// Direct irradiance at unit exitance, `[(patch * lamps + lamp) * bands + band]`.
    pub direct: &'a [f32],
    /// Luminaires.
    pub lamps: usize,
    /// 1 or 3.
    pub bands: usize,
    /// Receivers nearer than this to a patch are to hold it by itself, metres; empty where none is.
    pub reach: &'a [f32],
}

type Field = [f32; FIELDS];

/// Judges nodes. What patches send counts relative to the mean irradiance of each luminaire alone, with a
/// reflectance of one, as materials may be given another at any time.
#[derive(Clone, Debug)]
pub(super) struct Judge {
    /// Means of each node.
    means: Vec<[f32; FIELDS]>,
    /// The most that any patch of a node sends for any luminaire; infinite where lamps are among others.
    most: Vec<f32>,
    reach: Vec<f32>,
    mean_area: f64,
    /// What an entry costs, as squared error of a patch of mean area.
    pub(super) price: f64,
}

/// A row as nodes, rising, with their form factors.
pub(super) type Entries = Vec<(u32, f32)>;

/// What has been found of a node.
struct Found {
    factor: f64,
    sums: Field,
    cost: f64,
    square: f64,
    /// Of that what nodes of several materials have.
    mixed: f64,
    errors: Field,
    /// Nodes that hold it must not stand for their patches.
    alone: bool,
}

/// Working memory of one thread.
#[derive(Clone, Debug, Default)]
pub struct NodeScratch {
    /// What is seen, by place: place, patch, form factor.
    seen: Vec<(u32, u32, f64)>,
}

/// What the nodes of a row were chosen from and come to.
pub(super) struct Chosen {
    pub(super) entries: Entries,
    /// What the nodes change about the irradiance of the patch for the luminaire for which that is most, squared.
    pub(super) square: f64,
}

impl Judge {
    /// Learns what patches send.
    ///
    /// # Errors
    /// The watch ended it.
    pub(super) fn new(
        mesh: &PatchMesh,
        tree: &Tree,
        sent: Sent<'_>,
        watch: &mut Watch<'_>,
    ) -> Result<Self, Cancelled> {
        let n = mesh.patches.len();
        let area: f64 = mesh.patches.iter().map(|p| p.area).sum::<f64>().max(f64::MIN_POSITIVE);
        let rho = mesh.patches.iter().map(|p| p.area * p.reflectance.iter().sum::<f64>() / 3.0).sum::<f64>();
        let rho = (rho / area).clamp(0.0, BRIGHTEST);
        // 1. Direct light relative to the mean of all light, per lamp.
        let known = sent.direct.len() == n * sent.lamps * sent.bands && sent.bands > 0;
        let direct = |i: usize, lamp: usize| -> f64 {
            let at = (i * sent.lamps + lamp) * sent.bands;
            sent.direct[at..at + sent.bands].iter().map(|&d| f64::from(d)).sum::<f64>() / sent.bands as f64
        };
        let lamps = if known { sent.lamps } else { 0 };
        let mut lit: Vec<(f64, usize)> = (0..lamps)
            .map(|lamp| {
                let sum: f64 = mesh.patches.iter().enumerate().map(|(i, p)| p.area * direct(i, lamp)).sum();
                (sum / area / (1.0 - rho), lamp)
            })
            .filter(|(mean, _)| *mean > 0.0 && mean.is_finite())
            .collect();
        lit.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut values = vec![[0.0_f64; FIELDS]; n];
        for (k, &(mean, lamp)) in lit.iter().enumerate() {
            let field = if k < LAMPS { k } else { least_shared(mesh, &values, &|i| direct(i, lamp)) };
            for (i, value) in values.iter_mut().enumerate() {
                value[field] += direct(i, lamp) / mean;
            }
        }
        // 2. What is passed on, roughly, and textures, which scale all.
        let reflected: Vec<[f64; LAMPS]> = values
            .iter()
            .zip(&mesh.patches)
            .map(|(value, p)| {
                let rho = p.reflectance.iter().sum::<f64>() / 3.0;
                std::array::from_fn(|f| rho * value[f])
            })
            .collect();
        let passed_on = bounce::passed_on(mesh, tree, &reflected, watch)?;
        let extent = crate::geometry::Aabb::around(mesh.patches.iter().map(|p| p.centre)).size().length();
        let room = (ROOM * extent).max(f64::MIN_POSITIVE);
        for ((value, p), passed_on) in values.iter_mut().zip(&mesh.patches).zip(&passed_on) {
            let texture = p.texture_average.iter().sum::<f64>() / 3.0;
            for (value, passed_on) in value.iter_mut().zip(passed_on) {
                // Once reflected, and again and again.
                *value = texture * (*value + passed_on / (1.0 - rho));
            }
            let place = GRADIENT * rho * texture / room * p.centre;
            let turn = TURN * rho * texture * p.normal;
            for axis in 0..3 {
                value[LAMPS + axis] = place[axis];
                value[LAMPS + 3 + axis] = turn[axis];
            }
        }
        // 3. Means and extremes of the nodes.
        let mut means = vec![[0.0_f32; FIELDS]; tree.len()];
        for field in 0..FIELDS {
            let column: Vec<f64> = values.iter().map(|value| value[field]).collect();
            for (mean, of_node) in means.iter_mut().zip(tree.means(&column)) {
                mean[field] = of_node as f32;
            }
        }
        let mut most = vec![0.0_f32; tree.len()];
        for node in (0..tree.len() as u32).rev() {
            most[node as usize] = match (tree.halves(node), tree.single(node)) {
                (Some([a, b]), _) => {
                    let whole = most[a as usize].max(most[b as usize]);
                    let lamp = |half: u32| {
                        mesh.patches[tree.patches(half)[0] as usize].luminaire.is_some()
                            || most[half as usize].is_infinite()
                    };
                    if !tree.is_uniform(node) && (lamp(a) || lamp(b)) { f32::INFINITY } else { whole }
                }
                (None, Some(patch)) => {
                    values[patch as usize][..LAMPS].iter().fold(0.0, |a: f32, &b| a.max(b as f32))
                }
                (None, None) => 0.0,
            };
        }
        let mean_area = area / n.max(1) as f64;
        Ok(Self { means, most, reach: sent.reach.to_vec(), mean_area, price: 0.0 })
    }

    /// The nodes that stand for the patches seen from patch `i`, at this price per entry.
    ///
    /// `seen` holds each patch seen with its form factor.
    pub(super) fn choose(
        &self,
        mesh: &PatchMesh,
        tree: &Tree,
        (i, price): (u32, f64),
        seen: impl Iterator<Item = (u32, f64)>,
        scratch: &mut NodeScratch,
    ) -> Chosen {
        scratch.seen.clear();
        scratch.seen.extend(seen.map(|(j, value)| (tree.place(j), j, value)));
        scratch.seen.sort_unstable_by_key(|seen| seen.0);
        let receiver = &mesh.patches[i as usize];
        let walk =
            Walk { judge: self, mesh, tree, i, receiver, price, weight: receiver.area / self.mean_area };
        let mut entries = Vec::new();
        let Some(found) =
            (tree.len() > 0 && !scratch.seen.is_empty()).then(|| walk.visit(0, &scratch.seen, &mut entries))
        else {
            return Chosen { entries, square: 0.0 };
        };
        Chosen { entries, square: square_of(&found.errors) + found.mixed }
    }
}

/// The square of an error: of the luminaire for which it is largest, and of what is passed on.
fn square_of(errors: &Field) -> f64 {
    let lamps = errors[..LAMPS].iter().fold(0.0_f32, |a, e| a.max(e * e));
    f64::from(lamps + errors[LAMPS..].iter().map(|e| e * e).sum::<f32>())
}

/// The field whose lamps share the least area with one more lamp.
fn least_shared(mesh: &PatchMesh, values: &[[f64; FIELDS]], light: &dyn Fn(usize) -> f64) -> usize {
    let mut shared = [0.0; LAMPS];
    for ((i, p), value) in mesh.patches.iter().enumerate().zip(values) {
        let own = light(i) * p.area;
        shared.iter_mut().zip(value).for_each(|(sum, v)| *sum += own * v.min(1.0));
    }
    (1..LAMPS).fold(0, |best, field| if shared[field] < shared[best] { field } else { best })
}

struct Walk<'a> {
    judge: &'a Judge,
    mesh: &'a PatchMesh,
    tree: &'a Tree,
    i: u32,
    receiver: &'a Patch,
    price: f64,
    weight: f64,
}

impl Walk<'_> {
    /// The cheapest choice of nodes below and with `node`, for what is `seen` in it; adds them to `entries`.
    fn visit(&self, node: u32, seen: &[(u32, u32, f64)], entries: &mut Entries) -> Found {
        let Some([a, b]) = self.tree.halves(node) else { return self.leaf(node, seen, entries) };
        let start = entries.len();
        let border = self.tree.places(b).start;
        let at = seen.partition_point(|seen| seen.0 < border);
        let (low, high) = seen.split_at(at);
        let mut found = match (low.is_empty(), high.is_empty()) {
            (false, true) => self.visit(a, low, entries),
            (true, _) => self.visit(b, high, entries),
            (false, false) => {
                let (a, b) = (self.visit(a, low, entries), self.visit(b, high, entries));
                Found {
                    factor: a.factor + b.factor,
                    sums: std::array::from_fn(|f| a.sums[f] + b.sums[f]),
                    cost: a.cost + b.cost,
                    square: a.square + b.square,
                    mixed: a.mixed + b.mixed,
                    errors: std::array::from_fn(|f| a.errors[f] + b.errors[f]),
                    alone: a.alone || b.alone,
                }
            }
        };
        // A node that holds the receiver would let it light itself.
        found.alone |= self.tree.places(node).contains(&self.tree.place(self.i));
        if found.alone {
            return found;
        }
        let (square, errors) = self.error(node, &found);
        let cost = self.weight * square + self.price;
        if cost <= found.cost {
            entries.truncate(start);
            entries.push((node, found.factor as f32));
            (found.cost, found.square, found.errors) = (cost, square, errors);
            found.mixed = if self.tree.is_uniform(node) { 0.0 } else { square };
        }
        found
    }

    /// Squared error of a node that stands for its patches: of the luminaire for which it is largest; and its errors.
    fn error(&self, node: u32, found: &Found) -> (f64, Field) {
        if !self.tree.is_uniform(node) {
            // Reflectances of its materials may become anything.
            let most = found.factor * f64::from(self.judge.most[node as usize]);
            return (most * most, [0.0; FIELDS]);
        }
        let mean = &self.judge.means[node as usize];
        let factor = found.factor as f32;
        let errors: Field = std::array::from_fn(|f| found.sums[f] - factor * mean[f]);
        (square_of(&errors), errors)
    }

    fn leaf(&self, node: u32, seen: &[(u32, u32, f64)], entries: &mut Entries) -> Found {
        let mean = &self.judge.means[node as usize];
        let factor: f64 = seen.iter().map(|seen| seen.2).sum();
        let alone = seen.iter().any(|&(_, j, _)| {
            self.judge.reach.get(j as usize).is_some_and(|&reach| {
                reach > 0.0
                    && self.mesh.patches[j as usize].centre.distance(self.receiver.centre) < f64::from(reach)
            })
        });
        entries.push((node, factor as f32));
        let sums = std::array::from_fn(|f| factor as f32 * mean[f]);
        Found { factor, sums, cost: self.price, square: 0.0, mixed: 0.0, errors: [0.0; FIELDS], alone }
    }
}
