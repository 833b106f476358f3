//! The plan of a room: what stands at the height of its work plane, illuminance over the grid as colours, numbers and
//! lines of equal illuminance.

use crate::display::ColourMap;
use crate::export::WorkPlaneReport;
use crate::scene::{Scene, UpAxis};
use glam::{DVec2, DVec3};
use std::fmt::Write as _;

/// Width of a plan, pixels.
const WIDTH: f64 = 640.0;
/// No plan is higher, pixels.
const HIGHEST: f64 = 760.0;
/// A metre is no longer, pixels.
const LARGEST: f64 = 110.0;
/// Around the room so much is shown, metres.
const MARGIN: f64 = 0.4;
/// Lines of equal illuminance are drawn at some of these, lx.
const LEVELS: [f64; 17] = [
    1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 150.0, 200.0, 300.0, 500.0, 750.0, 1000.0, 1500.0, 2000.0,
    5000.0, 10_000.0,
];
/// So many of them at most.
const MOST_LEVELS: usize = 6;
/// With more points than this along a side numbers would not be read.
const MOST_NUMBERS: usize = 24;

/// A work plane with what arrives at its points.
#[derive(Clone, Debug)]
pub struct LitPlane {
    /// Its numbers.
    pub report: WorkPlaneReport,
    /// Places in the scene, metres, with their illuminance, lx; none is empty.
    pub points: Vec<(DVec3, f64)>,
}

/// Level coordinates as a plan has them: x to the right, and down.
fn on_paper(place: DVec3, up: UpAxis) -> DVec2 {
    match up {
        UpAxis::Y => DVec2::new(place.x, place.z),
        UpAxis::Z => DVec2::new(place.x, -place.y),
    }
}

/// Where things are drawn.
struct Sheet {
    low: DVec2,
    high: DVec2,
    scale: f64,
}

impl Sheet {
    fn of(places: &[DVec2], step: DVec2) -> Self {
        let (low, high) =
            places.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(low, high), &place| {
                (low.min(place), high.max(place))
            });
        // The border without points is half a metre wide.
        let around = 0.5 * step + 0.5 + MARGIN;
        let (low, high) = (low - around, high + around);
        let size = high - low;
        Self { low, high, scale: (WIDTH / size.x).min(HIGHEST / size.y).min(LARGEST) }
    }

    fn at(&self, place: DVec2) -> DVec2 {
        (place - self.low) * self.scale
    }

    fn holds(&self, place: DVec2) -> bool {
        place.cmpge(self.low).all() && place.cmple(self.high).all()
    }
}

/// The plan as SVG.
pub(super) fn svg(plane: &LitPlane, scene: &Scene) -> String {
    let places: Vec<DVec2> = plane.points.iter().map(|(place, _)| on_paper(*place, scene.up)).collect();
    let step = DVec2::from(plane.report.spacing_m);
    let sheet = Sheet::of(&places, step);
    let size = (sheet.high - sheet.low) * sheet.scale;
    let mut out = String::new();
    let _ = write!(
        out,
        "<svg class=\"plan\" width=\"{0:.0}\" height=\"{1:.0}\" viewBox=\"0 0 {0:.0} {1:.0}\" role=\"img\" aria-label=\"Plan of {2}\">",
        size.x,
        size.y,
        super::escaped(&plane.report.name)
    );
    let lux: Vec<f64> = plane.points.iter().map(|(_, lux)| *lux).collect();
    colours(&mut out, &sheet, &places, &lux, step, plane.report.illuminance_lx.maximum);
    section(&mut out, &sheet, scene, plane.points[0].0);
    lamps(&mut out, &sheet, scene, plane.points[0].0);
    isolux(&mut out, &sheet, &places, &lux, step);
    let columns = (sheet.high.x - sheet.low.x) / step.x;
    if columns <= MOST_NUMBERS as f64 {
        numbers(&mut out, &sheet, &places, &lux, step);
    }
    ruler(&mut out, &sheet, size);
    out += "</svg>";
    out
}

fn colours(out: &mut String, sheet: &Sheet, places: &[DVec2], lux: &[f64], step: DVec2, most: f64) {
    for (place, lux) in places.iter().zip(lux) {
        let corner = sheet.at(*place - 0.5 * step);
        let [r, g, b] = ColourMap::Viridis.srgb(lux / most.max(f64::MIN_POSITIVE)).map(|x| (255.0 * x) as u8);
        let size = step * sheet.scale;
        let _ = write!(
            out,
            "<rect x=\"{:.1}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"#{r:02x}{g:02x}{b:02x}\"/>",
            corner.x,
            corner.y,
            size.x + 0.3,
            size.y + 0.3
        );
    }
}

/// What stands at the height of the plane.
fn section(out: &mut String, sheet: &Sheet, scene: &Scene, on_plane: DVec3) {
    let up = scene.up.vector();
    let level = on_plane.dot(up);
    let mut path = String::new();
    for surface in &scene.surfaces {
        let outline = scene.polygon(surface);
        let mut cuts: Vec<DVec2> = Vec::new();
        for k in 0..outline.len() {
            let [a, b] = [outline[k], outline[(k + 1) % outline.len()]];
            let [below, above] = [a.dot(up) - level, b.dot(up) - level];
            if (below < 0.0) != (above < 0.0) {
                cuts.push(on_paper(a.lerp(b, below / (below - above)), scene.up));
            }
        }
        // Along the line of the section inside and outside take turns.
        let along = cuts.first().zip(cuts.last()).map_or(DVec2::X, |(first, last)| *last - *first);
        cuts.sort_by(|a, b| a.dot(along).total_cmp(&b.dot(along)));
        for pair in cuts.chunks_exact(2).filter(|pair| sheet.holds(pair[0]) || sheet.holds(pair[1])) {
            let [a, b] = [sheet.at(pair[0]), sheet.at(pair[1])];
            let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", a.x, a.y, b.x, b.y);
        }
    }
    let _ = write!(out, "<path class=\"wall\" d=\"{path}\"/>");
}

/// Lamps over the plane.
fn lamps(out: &mut String, sheet: &Sheet, scene: &Scene, on_plane: DVec3) {
    let up = scene.up.vector();
    let is_above = |place: DVec3| place.dot(up) > on_plane.dot(up);
    let mut path = String::new();
    for surface in scene.surfaces.iter().filter(|surface| surface.luminaire.is_some()) {
        let outline = scene.polygon(surface);
        let shown: Vec<DVec2> = outline.iter().map(|&place| on_paper(place, scene.up)).collect();
        if outline.iter().all(|&place| is_above(place)) && shown.iter().all(|&place| sheet.holds(place)) {
            for (k, place) in shown.iter().enumerate() {
                let place = sheet.at(*place);
                let _ = write!(path, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, place.x, place.y);
            }
            path.push('Z');
        }
    }
    let _ = write!(out, "<path class=\"lamp\" d=\"{path}\"/>");
    for source in scene.photometric_sources() {
        let place = on_paper(source.place.centre, scene.up);
        if is_above(source.place.centre) && sheet.holds(place) {
            let place = sheet.at(place);
            let _ =
                write!(out, "<circle class=\"lamp\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"5\"/>", place.x, place.y);
        }
    }
}

/// The levels between the least and the most illuminance at which lines are drawn.
fn levels(lux: &[f64]) -> Vec<f64> {
    let least = lux.iter().copied().fold(f64::INFINITY, f64::min);
    let most = lux.iter().copied().fold(0.0, f64::max);
    let within: Vec<f64> = LEVELS.into_iter().filter(|level| (least..most).contains(level)).collect();
    within[within.len().saturating_sub(MOST_LEVELS)..].to_vec()
}

/// Lines of equal illuminance by marching squares, linear between neighbouring points.
fn isolux(out: &mut String, sheet: &Sheet, places: &[DVec2], lux: &[f64], step: DVec2) {
    let origin = places[0];
    let key = |place: DVec2| {
        let cell = ((place - origin) / step).round();
        (cell.x as i64, cell.y as i64)
    };
    let by_cell: std::collections::HashMap<(i64, i64), usize> =
        places.iter().enumerate().map(|(k, place)| (key(*place), k)).collect();
    for level in levels(lux) {
        let mut path = String::new();
        let mut label: Option<DVec2> = None;
        for place in places {
            let (x, y) = key(*place);
            let square =
                [(x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)].map(|cell| by_cell.get(&cell).copied());
            let [Some(a), Some(b), Some(c), Some(d)] = square else { continue };
            let ring = [a, b, c, d];
            let mut cuts = Vec::new();
            for k in 0..4 {
                let (one, other) = (ring[k], ring[(k + 1) % 4]);
                if (lux[one] < level) != (lux[other] < level) {
                    let share = (level - lux[one]) / (lux[other] - lux[one]);
                    cuts.push(places[one].lerp(places[other], share));
                }
            }
            for pair in cuts.chunks_exact(2) {
                let [from, to] = [sheet.at(pair[0]), sheet.at(pair[1])];
                let _ = write!(path, "M{:.1} {:.1}L{:.1} {:.1}", from.x, from.y, to.x, to.y);
                label.get_or_insert(0.5 * (from + to));
            }
        }
        let _ = write!(out, "<path class=\"isolux\" d=\"{path}\"/>");
        if let Some(place) = label {
            let _ =
                write!(out, "<text class=\"level\" x=\"{:.1}\" y=\"{:.1}\">{level}</text>", place.x, place.y);
        }
    }
}

fn numbers(out: &mut String, sheet: &Sheet, places: &[DVec2], lux: &[f64], step: DVec2) {
    let size = (0.3 * step.min_element() * sheet.scale).clamp(6.0, 13.0);
    for (place, lux) in places.iter().zip(lux) {
        let place = sheet.at(*place);
        let _ = write!(
            out,
            "<text class=\"lux\" font-size=\"{size:.1}\" x=\"{:.1}\" y=\"{:.1}\">{}</text>",
            place.x,
            place.y + 0.35 * size,
            super::significant(*lux)
        );
    }
}

/// A metre, to measure by.
fn ruler(out: &mut String, sheet: &Sheet, size: DVec2) {
    let (x, y) = (8.0, size.y - 8.0);
    let end = x + sheet.scale;
    let _ = write!(
        out,
        "<path class=\"ruler\" d=\"M{x} {:.1}V{y:.1}H{end:.1}V{:.1}\"/><text class=\"metre\" x=\"{:.1}\" y=\"{:.1}\">1 m</text>",
        y - 5.0,
        y - 5.0,
        end + 5.0,
        y
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_run_where_the_illuminance_says() {
        // It falls by 100 lx a metre from 250 at x = 0: 200 is at 0.5, 150 at 1, 100 at 1.5.
        let places: Vec<DVec2> = (0..9).map(|k| DVec2::new(f64::from(k % 3), f64::from(k / 3))).collect();
        let lux: Vec<f64> = places.iter().map(|place| 250.0 - 100.0 * place.x).collect();
        assert_eq!(levels(&lux), [50.0, 100.0, 150.0, 200.0]);
        let sheet = Sheet { low: DVec2::ZERO, high: DVec2::splat(2.0), scale: 10.0 };
        let mut out = String::new();
        isolux(&mut out, &sheet, &places, &lux, DVec2::ONE);
        assert!(out.contains("M5.0 0.0L5.0 10.0") && out.contains("M15.0 0.0L15.0 10.0"), "{out}");
        assert!(out.contains(">200</text>"), "{out}");
    }

    #[test]
    fn a_section_shows_what_stands_at_the_height_of_the_plane() {
        // A wall of 2 m and a step of 0.2 m.
        let text = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4\nv 0 0 1\nv 2 0 1\nv 2 .2 1\nv 0 .2 1\nf 5 6 7 8\n";
        let scene = crate::scene::from_text("t", text, "", None).expect("a scene");
        let sheet = Sheet { low: DVec2::splat(-1.0), high: DVec2::splat(3.0), scale: 10.0 };
        let mut out = String::new();
        section(&mut out, &sheet, &scene, DVec3::new(1.0, 0.8, 0.5));
        assert_eq!(out.matches('M').count(), 1, "{out}");
        assert!(out.contains("M10.0 10.0L30.0 10.0") || out.contains("M30.0 10.0L10.0 10.0"), "{out}");
    }
}
