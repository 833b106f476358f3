//! The part of a model that is looked at, and the length that tolerances are shares of.
//!
//! Models come with markers at the origin of a survey grid, logos and forgotten furniture kilometres
//! away from the building. Such stray parts stay in the light, but nothing else may follow them: one
//! millionth of 5,000 km is more than a room.

use super::finding::{Finding, FindingKind, MOST_PLACES, Places, Severity, line_list};
use super::names;
use super::types::Scene;
use crate::geometry::{Aabb, polygon};
use glam::DVec3;

/// A part nearer than this is never stray, metres: sites are that large.
const NEIGHBOURHOOD: f64 = 1000.0;
/// Nor is one that is nearer than so many times the reach of the main part.
const APART: f64 = 8.0;
/// A face longer than this, metres, and than so many times the rest of the model has a corner that is wrong: ground around a
/// house is smaller.
const LONGEST: f64 = 1e5;
const LONGER: f64 = 1e3;
/// The share of the area that the main part is grown from; two equal halves each pass.
const CORE: f64 = 0.4;
/// Up to this diagonal tolerances are shares of it, metres.
const BUILDING: f64 = 100.0;
/// Beyond that they are shares of so many times the size of the finest faces...
const FINE_TO_WHOLE: f64 = 500.0;
/// ... which are those in this share of all, by their size.
const FINEST: f64 = 0.1;
/// A model whose main part is so many times as far from the origin as it is large loses digits there.
const FAR: f64 = 100.0;
/// Origins are moved by whole multiples of this, metres, so that small edits of a model move none.
const ORIGIN_STEP: f64 = 1000.0;

/// Where a model is, and at which scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent {
    /// The box around the main part, metres.
    pub main: Aabb,
    /// The length that tolerances are shares of, metres; above zero where anything has a size. The
    /// diagonal of the main part, or less on a large site.
    pub scale: f64,
    /// Indices of the polygons that do not belong to the main part, in rising order.
    pub stray: Vec<u32>,
}

/// What is asked of a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) struct Footprint {
    pub(super) bounds: Aabb,
    /// Square metres.
    pub(super) area: f64,
    /// Whether it shines.
    pub(super) emits: bool,
}

impl Footprint {
    pub(super) fn of(outline: &[DVec3], emits: bool) -> Self {
        let area = polygon::area_vector(outline).length();
        Self {
            bounds: Aabb::around(outline.iter().copied()),
            area: if area.is_finite() { area } else { 0.0 },
            emits,
        }
    }
}

impl Extent {
    /// Of these polygons. Takes a few sorts where the model is larger than a site, else one pass.
    pub(super) fn of(polygons: &[Footprint]) -> Self {
        if let Some(extent) = Self::without_broken(polygons) {
            return extent;
        }
        let all = polygons.iter().fold(Aabb::EMPTY, |sum, polygon| sum.union(polygon.bounds));
        let mut extent = Self { main: all, scale: all.diagonal(), stray: Vec::new() };
        if all.diagonal() > NEIGHBOURHOOD {
            let (main, stray) = main_part(polygons, |polygon| polygon.area);
            let lamps = (0_u32..).zip(polygons).filter(|(_, polygon)| polygon.emits);
            let shines_far_away = |(index, _): (u32, &Footprint)| stray.binary_search(&index).is_ok();
            let (main, stray) = if lamps.clone().count() > 0 && lamps.clone().all(shines_far_away) {
                // What shines is what somebody wants to look at, however small it is beside the rest.
                main_part(polygons, |polygon| if polygon.emits { polygon.area } else { 0.0 })
            } else {
                (main, stray)
            };
            (extent.main, extent.scale, extent.stray) = (main, main.diagonal(), stray);
        }
        if extent.scale > BUILDING {
            extent.scale = extent.scale.min(extent.fine_scale(polygons).max(BUILDING));
        }
        extent
    }

    /// The extent of all but faces with a corner that is wrong, which are stray; `None` where there are none.
    fn without_broken(polygons: &[Footprint]) -> Option<Self> {
        let is_long = |polygon: &Footprint| polygon.bounds.diagonal() > LONGEST;
        if !polygons.iter().any(is_long) {
            return None;
        }
        let (long, rest): (Vec<u32>, Vec<u32>) =
            (0..polygons.len() as u32).partition(|&index| is_long(&polygons[index as usize]));
        let kept: Vec<Footprint> = rest.iter().map(|&index| polygons[index as usize]).collect();
        let mut extent = Self::of(&kept);
        let most = LONGER * extent.main.diagonal();
        let is_broken = |&index: &u32| polygons[index as usize].bounds.diagonal() > most;
        if kept.is_empty() || !long.iter().all(is_broken) {
            return None;
        }
        extent.stray = extent.stray.iter().map(|&index| rest[index as usize]).chain(long).collect();
        extent.stray.sort_unstable();
        Some(extent)
    }

    /// The scale of a large site by its finest faces: a house in 2 km of terrain keeps its millimetres.
    fn fine_scale(&self, polygons: &[Footprint]) -> f64 {
        let mut sizes: Vec<f64> = polygons.iter().map(|polygon| polygon.bounds.diagonal()).collect();
        if sizes.is_empty() {
            return 0.0;
        }
        let place = (FINEST * sizes.len() as f64) as usize;
        let (_, size, _) = sizes.select_nth_unstable_by(place, f64::total_cmp);
        FINE_TO_WHOLE * *size
    }

    /// What to subtract from all positions, metres, so that those of the main part keep their digits:
    /// zero for all models but those that are far from their origin.
    pub(super) fn origin(&self) -> DVec3 {
        let centre = self.main.centre();
        let far = (FAR * self.main.diagonal()).max(ORIGIN_STEP);
        if centre.abs().max_element() < far {
            return DVec3::ZERO;
        }
        (centre / ORIGIN_STEP).round() * ORIGIN_STEP
    }

    /// Whether a box belongs to the main part.
    pub fn holds(&self, bounds: &Aabb) -> bool {
        self.stray.is_empty() || self.main.grown(1e-9 * self.scale).meets(bounds)
    }
}

/// The box of the part that most of the weight is in, and the polygons outside of it: from the middle
/// outwards until the next polygon is far away.
fn main_part(polygons: &[Footprint], weight: impl Fn(&Footprint) -> f64) -> (Aabb, Vec<u32>) {
    let total: f64 = polygons.iter().map(&weight).sum();
    let median = DVec3::from_array([0, 1, 2].map(|axis| median(polygons, axis, &weight)));
    // A median of each coordinate may lie where nothing is.
    let nearest = |middle: DVec3| {
        let order = |p: &&Footprint| apart(&p.bounds, middle);
        polygons.iter().filter(|p| weight(p) > 0.0).min_by(|a, b| order(a).total_cmp(&order(b)))
    };
    let middle = nearest(median).map_or(median, |polygon| polygon.bounds.centre());
    let mut order: Vec<(f64, u32)> =
        (0_u32..).zip(polygons).map(|(index, p)| (apart(&p.bounds, middle), index)).collect();
    order.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (mut main, mut reach, mut gathered) = (Aabb::EMPTY, 0.0_f64, 0.0);
    let mut count = 0;
    for &(near, index) in &order {
        if gathered >= CORE * total && near - reach > (APART * reach).max(NEIGHBOURHOOD) {
            break;
        }
        let polygon = &polygons[index as usize];
        main = main.union(polygon.bounds);
        reach = reach.max((polygon.bounds.max - middle).max(middle - polygon.bounds.min).max_element());
        gathered += weight(polygon);
        count += 1;
    }
    let mut stray: Vec<u32> = order[count..].iter().map(|&(_, index)| index).collect();
    stray.sort_unstable();
    (main, stray)
}

/// The largest of the distances along the axes between a box and a point, metres; zero inside.
fn apart(bounds: &Aabb, point: DVec3) -> f64 {
    (bounds.min - point).max(point - bounds.max).max_element().max(0.0)
}

/// The coordinate of a polygon's middle on either side of which half of the weight is.
fn median(polygons: &[Footprint], axis: usize, weight: &impl Fn(&Footprint) -> f64) -> f64 {
    let mut all: Vec<(f64, f64)> =
        polygons.iter().map(|p| (p.bounds.centre()[axis], weight(p))).filter(|p| p.1 > 0.0).collect();
    all.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * all.iter().map(|p| p.1).sum::<f64>();
    let mut sum = 0.0;
    let middle = all.iter().find(|(_, weight)| {
        sum += weight;
        sum >= half
    });
    middle.map_or(0.0, |p| p.0)
}

/// Names what is far away from everything else, one finding for each object.
pub(super) fn report(scene: &Scene, extent: &Extent, findings: &mut Vec<Finding>) {
    let mut objects: Vec<u32> = Vec::new();
    let mut of_object: std::collections::HashMap<u32, Vec<u32>> = std::collections::HashMap::new();
    for &index in &extent.stray {
        let object = scene.surfaces[index as usize].object;
        of_object.entry(object).or_insert_with(|| {
            objects.push(object);
            Vec::new()
        });
        of_object.entry(object).or_default().push(index);
    }
    let kept = "it stays in the light; views and tolerances follow the rest of the model";
    const NAMED: usize = 3;
    for object in objects.iter().take(NAMED) {
        let faces = &of_object[object];
        let bounds = faces.iter().fold(Aabb::EMPTY, |sum, &face| {
            sum.union(Aabb::around(scene.polygon(&scene.surfaces[face as usize])))
        });
        let gap = (bounds.min - extent.main.max).max(extent.main.min - bounds.max).max(DVec3::ZERO);
        let lines: Vec<u32> = faces.iter().filter_map(|&face| scene.surfaces[face as usize].line).collect();
        let name = scene.objects.get(*object as usize).map_or("", String::as_str);
        let which = format!(
            "'{}' ({}{})",
            names::short(name),
            if faces.len() == 1 { "1 face".to_owned() } else { format!("{} faces", faces.len()) },
            line_list(&lines, faces.len())
        );
        let message = if gap == DVec3::ZERO {
            let reach = (bounds.max - extent.main.max).max(extent.main.min - bounds.min).max_element();
            format!(
                "{which} reaches {} beyond the rest of the model: a corner of it is likely wrong; mend or delete it",
                kilometres(reach)
            )
        } else {
            format!(
                "{which} stands {} away from the rest of the model; delete or move it if it was forgotten there",
                kilometres(gap.length())
            )
        };
        findings.push(
            Finding::new(FindingKind::Stray, Severity::Warning, message).counted(faces.len()).with(kept).at(
                Places {
                    lines: lines.into_iter().take(MOST_PLACES).collect(),
                    ..Places::of_faces(faces.iter().copied())
                },
            ),
        );
    }
    if objects.len() > NAMED {
        let rest: Vec<u32> = objects[NAMED..].iter().flat_map(|object| of_object[object].clone()).collect();
        let message = format!(
            "{} more objects stand kilometres away from the rest of the model",
            objects.len() - NAMED
        );
        findings.push(
            Finding::new(FindingKind::Stray, Severity::Warning, message)
                .counted(rest.len())
                .with(kept)
                .at(Places::of_faces(rest)),
        );
    }
}

fn kilometres(metres: f64) -> String {
    let km = metres / 1000.0;
    if km < 10.0 { format!("{km:.1} km") } else { format!("{} km", names::grouped(km.round() as i64)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(at: [f64; 3], size: f64) -> Footprint {
        let at = DVec3::from(at);
        Footprint::of(
            &[at, at + DVec3::X * size, at + DVec3::new(size, 0.0, size), at + DVec3::Z * size],
            false,
        )
    }

    fn lamp(at: [f64; 3], size: f64) -> Footprint {
        Footprint { emits: true, ..square(at, size) }
    }

    /// A floor, furniture and a lamp, all within 10 m of `at`.
    fn house(at: [f64; 3]) -> Vec<Footprint> {
        let [x, y, z] = at;
        let mut all = vec![square(at, 10.0), square([x, y + 3.0, z], 10.0), lamp([x + 4.0, y + 2.9, z], 0.5)];
        all.extend((0..40).map(|k| square([x + f64::from(k % 7), y + 0.7, z + f64::from(k / 7)], 0.4)));
        all
    }

    #[test]
    fn a_marker_a_logo_and_a_chair_kilometres_away_are_stray() {
        let far = [
            ("a marker at the origin of the grid", vec![square([0.0; 3], 0.2)]),
            (
                "a chair of 400 facets",
                (0..400).map(|k| square([515_000.0, 0.002 * f64::from(k), 0.0], 0.02)).collect(),
            ),
            (
                "four posts around",
                vec![
                    square([500_000.0, 0.0, 5_400_000.0], 0.1),
                    square([520_000.0, 0.0, 5_400_000.0], 0.1),
                    square([512_000.0, 0.0, 5_390_000.0], 0.1),
                    square([512_000.0, 0.0, 5_410_000.0], 0.1),
                ],
            ),
        ];
        for (what, strays) in far {
            let mut all = house([512_000.0, 30.0, 5_400_000.0]);
            let count = all.len();
            all.extend(&strays);
            let extent = Extent::of(&all);
            assert_eq!(extent.stray, (count as u32..all.len() as u32).collect::<Vec<_>>(), "{what}");
            assert!(
                extent.main.diagonal() < 15.0 && extent.scale == extent.main.diagonal(),
                "{what}: {extent:?}"
            );
            assert_eq!(extent.origin(), DVec3::new(512_000.0, 0.0, 5_400_000.0), "{what}");
        }
    }

    #[test]
    fn what_shines_is_the_main_part_even_beside_a_larger_one() {
        let mut all = house([0.0; 3]);
        // Terrain of another survey, with more area than the house.
        all.push(square([90_000.0, 0.0, 0.0], 500.0));
        let extent = Extent::of(&all);
        assert_eq!(extent.stray, [all.len() as u32 - 1]);
        assert!(extent.main.diagonal() < 15.0);
    }

    #[test]
    fn a_face_with_one_corner_far_away_is_stray_and_ground_is_not() {
        let corner = Aabb { min: DVec3::new(-1e7, 0.0, 0.0), max: DVec3::new(3.0, 2.0, 1.0) };
        let broken = Footprint { bounds: corner, area: 1e7, emits: false };
        let mut all = house([0.0; 3]);
        all.insert(2, broken);
        let extent = Extent::of(&all);
        assert_eq!(extent.stray, [2]);
        assert!(extent.main.diagonal() < 15.0 && extent.scale == extent.main.diagonal(), "{extent:?}");
        assert_eq!(extent.origin(), DVec3::ZERO);
        // 200 km of ground around a town of 2 km.
        let town: Vec<Footprint> = (0..20).flat_map(|k| house([f64::from(k) * 100.0, 0.0, 0.0])).collect();
        let ground = [town, vec![square([0.0; 3], 2e5)]].concat();
        assert_eq!(Extent::of(&ground).stray, [0_u32; 0]);
    }

    #[test]
    fn sites_have_no_stray_part() {
        let two = [house([0.0; 3]), house([300.0, 0.0, 0.0])].concat();
        let street: Vec<Footprint> = (0..60).flat_map(|k| house([f64::from(k) * 80.0, 0.0, 0.0])).collect();
        let terrain = [house([900.0, 0.0, 1000.0]), vec![square([0.0; 3], 2000.0)]].concat();
        // A lamp 3 km up is stray; a sky of 2 km around the house is not.
        let sky = [house([900.0, 0.0, 900.0]), vec![square([0.0, 800.0, 0.0], 2000.0)]].concat();
        // In millimetres without a word of it.
        let millimetres: Vec<Footprint> = house([0.0; 3])
            .iter()
            .map(|p| Footprint {
                bounds: Aabb { min: p.bounds.min * 1000.0, max: p.bounds.max * 1000.0 },
                area: p.area * 1e6,
                ..*p
            })
            .collect();
        for (what, site) in [
            ("two", two),
            ("street", street),
            ("terrain", terrain),
            ("sky", sky),
            ("millimetres", millimetres),
        ] {
            let extent = Extent::of(&site);
            assert_eq!(extent.stray, [0_u32; 0], "{what}");
            assert_eq!(extent.origin(), DVec3::ZERO, "{what}");
        }
    }

    #[test]
    fn tolerances_follow_the_house_and_not_the_terrain() {
        let terrain = [house([900.0, 0.0, 1000.0]), vec![square([0.0; 3], 2000.0)]].concat();
        let extent = Extent::of(&terrain);
        assert!(extent.main.diagonal() > 2800.0);
        assert!(extent.scale <= 300.0, "a millionth of it is less than a millimetre: {}", extent.scale);
        // Of a model in millimetres, read as metres, everything grows alike.
        let grown: Vec<Footprint> = (0..200)
            .map(|k| square([f64::from(k % 20) * 300.0, f64::from(k / 20) * 300.0, 0.0], 250.0))
            .collect();
        let extent = Extent::of(&grown);
        assert_eq!(extent.scale, extent.main.diagonal());
    }

    #[test]
    fn nothing_and_nonsense_are_survived() {
        assert_eq!(Extent::of(&[]).scale, 0.0);
        let flat = Footprint { area: 0.0, ..square([0.0; 3], 1e4) };
        assert!(Extent::of(&[flat, Footprint { bounds: flat.bounds, ..flat }]).stray.is_empty());
    }
}
