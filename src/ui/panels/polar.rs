//! The distribution of a lamp that shines by its photometry: a polar diagram, and its flux in two ways.

use crate::photometry::{Distribution, MainPlane};
use crate::scene::PhotometricLight;
use crate::ui::{theme, units};
use egui::{Align2, Color32, FontId, Pos2, RichText, Sense, Shape, Stroke, Vec2, vec2};

/// Height of the diagram and radius of its outer ring, points.
const HEIGHT: f32 = 176.0;
const RADIUS: f32 = 76.0;
/// Curves have a point every so many degrees.
const STEP: f64 = 2.0;
/// The curve of C90-C270; that of C0-C180 has the accent.
const ACROSS: Color32 = Color32::from_rgb(128, 178, 226);

/// Shows the photometry of a lamp of this name.
pub(super) fn show(ui: &mut egui::Ui, name: &str, light: &PhotometricLight) {
    let photometry = &light.photometry;
    ui.separator();
    let title = photometry.description.name();
    let title = if title.is_empty() { photometry.format.name() } else { title.to_owned() };
    ui.add(egui::Label::new(RichText::new(title)).truncate()).on_hover_text(format!(
        "{}: {}",
        photometry.format.name(),
        photometry.description.lines().join(", ")
    ));
    diagram(ui, name, &photometry.distribution);
    let check = photometry.flux_check();
    let lumens = |lumens: f64| format!("{} lm", units::digits(lumens));
    theme::row(ui, "Flux of its intensities", lumens(check.integrated));
    let of = if check.of_lamps { "Flux of its lamps, by the file" } else { "Flux stated by the file" };
    theme::row(ui, of, check.stated.map_or_else(|| "none".to_owned(), lumens));
    if light.places.len() > 1 {
        theme::row(ui, "Luminaires", units::count(light.places.len()));
    }
    if let Some(warning) = check.warning {
        ui.label(RichText::new(warning).color(theme::WARNING));
    }
}

/// Intensity against the angle from the nadir, which is at the bottom, in both main planes.
fn diagram(ui: &mut egui::Ui, name: &str, distribution: &Distribution) {
    let (place, response) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    response.widget_info(|| {
        egui::WidgetInfo::labeled(egui::accesskit::Role::Image, true, format!("Distribution of {name}"))
    });
    let painter = ui.painter_at(place);
    painter.rect_filled(place, 2.0, ui.visuals().extreme_bg_color);
    let curves = [(MainPlane::C90C270, ACROSS), (MainPlane::C0C180, theme::ACCENT)]
        .map(|(plane, colour)| (distribution.polar_curve(plane, STEP), colour));
    let most = distribution.maximum().candela.max(f64::MIN_POSITIVE);
    let shines_up = curves.iter().flat_map(|curve| &curve.0).any(|p| p[0].abs() > 90.5 && p[1] > 1e-3 * most);
    // What shines down alone has the room of a half circle.
    let (centre, radius) = if shines_up {
        (place.center(), RADIUS)
    } else {
        (Pos2::new(place.center().x, place.top() + 22.0), HEIGHT - 44.0)
    };
    let at = |degrees: f64, share: f64| -> Pos2 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        centre + Vec2::new((share * sin) as f32, (share * cos) as f32) * radius
    };
    let grid = Stroke::new(1.0, theme::GRID);
    let limit = if shines_up { 180.0 } else { 90.0 };
    for ring in [1.0 / 3.0, 2.0 / 3.0, 1.0] {
        let points = (-36..=36).map(|k| at(f64::from(k) / 36.0 * limit, ring)).collect();
        painter.add(Shape::line(points, grid));
    }
    for ray in (-6..=6).map(|k| f64::from(k) * 30.0).filter(|ray| ray.abs() <= limit) {
        painter.line_segment([centre, at(ray, 1.0)], grid);
    }
    for (curve, colour) in &curves {
        let points = curve.iter().filter(|p| p[0].abs() <= limit).map(|p| at(p[0], p[1] / most)).collect();
        painter.add(Shape::line(points, Stroke::new(1.5, *colour)));
    }
    let font = FontId::proportional(10.0);
    let text = |at: Pos2, align: Align2, text: String, colour: Color32| {
        painter.text(at, align, text, font.clone(), colour);
    };
    text(at(0.0, 1.0), Align2::CENTER_TOP, format!("{} cd", units::digits(most)), theme::TEXT_WEAK);
    let (left, right) = (place.left_top() + vec2(5.0, 3.0), place.right_top() + vec2(-5.0, 3.0));
    text(left, Align2::LEFT_TOP, "C0 right, C180 left".to_owned(), theme::ACCENT);
    text(right, Align2::RIGHT_TOP, "C90 right, C270 left".to_owned(), ACROSS);
}
