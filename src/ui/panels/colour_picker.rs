//! Choosing a colour inside a popup: hue and saturation as strips, by mouse and by keyboard.
//!
//! egui's own colour button opens a popup of its own, and opening one closes the popup that the button is in.

use crate::ui::colour;
use crate::ui::theme;
use egui::accesskit::Action;
use egui::{Color32, EventFilter, Key, Rect, Response, RichText, Sense, Stroke, Ui, WidgetInfo, pos2, vec2};

/// Colours along a strip.
const STEPS: usize = 36;
/// What grey takes on with a hue.
const SHOWN_SATURATION: f32 = 0.5;
/// What an arrow key adds, as a share of the strip.
const KEY_STEP: f32 = 0.01;

/// A hue and a saturation, and the linear colour that they were last made into. Grey has no hue, so that the
/// colour alone would forget the hue once the saturation is at zero.
#[derive(Clone, Copy)]
struct Chosen {
    hue: f32,
    saturation: f32,
    made: [f64; 3],
}

/// Shows strips for hue and saturation of a linear colour. Answers with another colour of the same largest
/// band once one is chosen. `of` is what is coloured, for names that are read aloud.
pub(super) fn show(ui: &mut Ui, of: &str, linear: [f64; 3]) -> Option<[f64; 3]> {
    let id = ui.scope_id().with("chosen colour");
    let (peak, bright) = colour::split(linear);
    let [hue, saturation, _] = colour::hsv_of(bright);
    let kept = ui.data(|d| d.get_temp::<Chosen>(id));
    let mut chosen = kept
        .filter(|kept| (0..3).all(|b| (colour::split(kept.made).1[b] - bright[b]).abs() < 1e-3))
        .unwrap_or(Chosen { hue, saturation, made: linear });
    let (mut hue, mut saturation) = (chosen.hue, chosen.saturation);
    let hues = strip(
        ui,
        "Hue",
        &format!("Hue of {of}"),
        &mut hue,
        |h| [h, 1.0, 1.0],
        |h| format!("{:.0}°", 360.0 * h),
    );
    if hues && saturation < 0.01 {
        // Grey shows no hue: whoever chooses one wants to see it.
        saturation = SHOWN_SATURATION;
    }
    let at = hue;
    let saturations = strip(
        ui,
        "Saturation",
        &format!("Saturation of {of}"),
        &mut saturation,
        |s| [at, s, 1.0],
        |s| format!("{:.0} %", 100.0 * s),
    );
    let is_changed = hues || saturations;
    if is_changed {
        let made = colour::linear_of_hsv([hue, saturation, 1.0]).map(|c| c * peak);
        chosen = Chosen { hue, saturation, made };
    }
    ui.data_mut(|d| d.insert_temp(id, chosen));
    is_changed.then_some(chosen.made)
}

/// A strip of colours with a mark at `value`, 0 to 1, and the value in words. Whether it was changed.
fn strip(
    ui: &mut Ui,
    label: &str,
    name: &str,
    value: &mut f32,
    hsv: impl Fn(f32) -> [f32; 3],
    told: impl Fn(f32) -> String,
) -> bool {
    let before = *value;
    ui.horizontal(|ui| {
        ui.scope(|ui| {
            ui.set_min_width(74.0);
            ui.label(label);
        });
        let (rect, response) = ui.allocate_exact_size(vec2(118.0, 16.0), Sense::click_and_drag());
        if let Some(pointer) = response.interact_pointer_pos() {
            *value = ((pointer.x - rect.left()) / rect.width()).clamp(0.0, 1.0);
        }
        *value = (*value + KEY_STEP * steps_by_key(ui, &response)).clamp(0.0, 1.0);
        response.widget_info(|| WidgetInfo::slider(ui.is_enabled(), f64::from(*value), name));
        paint(ui, rect, &response, *value, hsv);
        ui.label(RichText::new(told(*value)).color(theme::TEXT_WEAK));
    });
    *value != before
}

/// Steps that the arrow keys and assistive technology ask for.
fn steps_by_key(ui: &Ui, response: &Response) -> f32 {
    let has_focus = response.has_focus();
    if has_focus {
        // The arrows move the mark and not the focus.
        let filter = EventFilter { horizontal_arrows: true, ..Default::default() };
        ui.memory_mut(|m| m.set_focus_lock_filter(response.id, filter));
    }
    ui.input(|input| {
        let pressed = |key| if has_focus { input.num_presses(key) as f32 } else { 0.0 };
        let asked = |action| input.num_accesskit_action_requests(response.id, action) as f32;
        pressed(Key::ArrowRight) - pressed(Key::ArrowLeft) + asked(Action::Increment)
            - asked(Action::Decrement)
    })
}

fn paint(ui: &Ui, rect: Rect, response: &Response, value: f32, hsv: impl Fn(f32) -> [f32; 3]) {
    let mut mesh = egui::Mesh::default();
    for step in 0..=STEPS {
        let share = step as f32 / STEPS as f32;
        let [r, g, b] = colour::to_bytes(colour::linear_of_hsv(hsv(share)));
        let x = egui::lerp(rect.x_range(), share);
        let here = mesh.vertices.len() as u32;
        for y in [rect.top(), rect.bottom()] {
            mesh.colored_vertex(pos2(x, y), Color32::from_rgb(r, g, b));
        }
        if step > 0 {
            mesh.add_triangle(here - 2, here - 1, here);
            mesh.add_triangle(here - 1, here, here + 1);
        }
    }
    ui.painter().add(mesh);
    let visuals = ui.style().interact(response);
    ui.painter().rect_stroke(rect, 2.0, visuals.bg_stroke, egui::StrokeKind::Outside);
    if response.has_focus() {
        ui.painter().rect_stroke(rect.expand(1.0), 3.0, (1.5, theme::ACCENT), egui::StrokeKind::Outside);
    }
    let x = egui::lerp(rect.x_range(), value);
    let mark = Rect::from_center_size(pos2(x, rect.center().y), vec2(5.0, rect.height() + 4.0));
    ui.painter().rect(
        mark,
        2.0,
        Color32::WHITE,
        Stroke::new(1.0, Color32::from_gray(20)),
        egui::StrokeKind::Outside,
    );
}
