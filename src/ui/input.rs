//! Keys and the mouse: what they ask for.

use super::camera_control::{Motion, Wish};
use super::command::{Command, SaveKind};
use super::doctor::Ask;
use super::panels::{Commands, Model};
use super::state::{Quantity, ShadingMode};
use crate::solve::Stage;
use egui::{Context, Key, Modifiers};

/// Steps of the exposure keys, stops.
const EXPOSURE_STEP: f64 = 0.5;

/// Keeps the Tab key from egui's focus, for the panels to fold, unless the keyboard is among the
/// widgets already; F6 takes it there.
#[derive(Default)]
pub(super) struct TabKey {
    pressed: bool,
}

impl egui::Plugin for TabKey {
    fn debug_name(&self) -> &'static str {
        "tab key"
    }

    fn input_hook(&mut self, ctx: &Context, input: &mut egui::RawInput) {
        if ctx.memory(|m| m.focused()).is_some() {
            return;
        }
        input.events.retain_mut(|event| match event {
            egui::Event::Key { key: Key::Tab, pressed, modifiers, .. } if modifiers.is_none() => {
                self.pressed |= *pressed;
                false
            }
            egui::Event::Key { key, .. } if *key == Key::F6 => {
                *key = Key::Tab;
                true
            }
            _ => true,
        });
    }
}

/// Whether Tab was pressed for the panels since the last look.
pub(super) fn take_tab(ctx: &Context) -> bool {
    ctx.with_plugin(|tab: &mut TabKey| std::mem::take(&mut tab.pressed)).unwrap_or(false)
}

/// Whether keys belong to the scene and not to a widget.
pub(super) fn keys_are_free(ctx: &Context) -> bool {
    !ctx.egui_wants_keyboard_input()
        && ctx.memory(|m| m.focused()).is_none()
        && !egui::Popup::is_any_open(ctx)
}

/// Where the held keys want to go.
pub(super) fn wish(ctx: &Context) -> Wish {
    if !keys_are_free(ctx) {
        return Wish::default();
    }
    ctx.input(|i| {
        if i.modifiers.command || i.modifiers.alt {
            return Wish::default();
        }
        let axis = |plus: [Key; 2], minus: [Key; 2]| {
            let down = |keys: [Key; 2]| f64::from(u8::from(keys.iter().any(|&k| i.key_down(k))));
            down(plus) - down(minus)
        };
        Wish {
            ahead: axis([Key::W, Key::ArrowUp], [Key::S, Key::ArrowDown]),
            right: axis([Key::D, Key::ArrowRight], [Key::A, Key::ArrowLeft]),
            up: axis([Key::E, Key::PageUp], [Key::Q, Key::PageDown]),
            run: i.modifiers.shift,
        }
    })
}

/// What the keys pressed in this frame ask for.
pub(super) fn commands(ctx: &Context, model: &Model<'_>, help_open: bool, out: &mut Commands) {
    let shortcut = |modifiers: Modifiers, key: Key| ctx.input_mut(|i| i.consume_key(modifiers, key));
    let redo = Modifiers::COMMAND | Modifiers::SHIFT;
    // The longer combination first: the shorter one matches it too.
    for (modifiers, key, command) in [
        (redo, Key::Z, Command::Redo),
        (Modifiers::COMMAND, Key::Z, Command::Undo),
        (Modifiers::COMMAND, Key::Y, Command::Redo),
        (Modifiers::COMMAND, Key::O, Command::OpenDialog),
        (Modifiers::COMMAND, Key::Q, Command::Quit),
        (Modifiers::NONE, Key::F1, Command::ToggleHelp),
        (Modifiers::NONE, Key::F5, Command::Reload),
        (Modifiers::SHIFT, Key::F12, Command::QuickSave(SaveKind::Hdr)),
        (Modifiers::NONE, Key::F12, Command::QuickSave(SaveKind::Screenshot)),
    ] {
        if shortcut(modifiers, key) {
            out.push(command);
        }
    }
    if !keys_are_free(ctx) {
        return;
    }
    let pressed = |key: Key| ctx.input(|i| i.key_pressed(key) && !i.modifiers.command && !i.modifiers.alt);
    if pressed(Key::Escape) {
        out.push(match model.tour {
            _ if help_open => Command::ToggleHelp,
            Some(_) => Command::ToggleTour,
            None => Command::Inspect(None),
        });
    }
    for (key, command) in [
        (Key::C, Command::ToggleSplit),
        (Key::T, Command::ToggleTour),
        (Key::Home, Command::Home),
        (Key::B, Command::StoreView),
        (Key::OpenBracket, Command::StepView(-1)),
        (Key::CloseBracket, Command::StepView(1)),
        (Key::R, Command::ToggleRow),
        (Key::J, Command::ToggleTable),
        (Key::K, Command::Doctor(Ask::Toggle)),
        (Key::Backspace, Command::PickBack),
        (
            Key::F,
            Command::SetMotion(if model.visit.motion == Motion::Walk { Motion::Fly } else { Motion::Walk }),
        ),
    ] {
        if pressed(key) {
            out.push(command);
        }
    }
    // Hours of form factors without any light are not begun by a slip of a finger.
    if pressed(Key::P) && model.snapshot.stage != Stage::Unlit {
        out.extend(super::panels::solver::pause(model.snapshot).2);
    }
    lamp_keys(&pressed, model, out);
    display_keys(&pressed, model, out);
}

fn lamp_keys(pressed: &impl Fn(Key) -> bool, model: &Model<'_>, out: &mut Commands) {
    let numbers =
        [Key::Num1, Key::Num2, Key::Num3, Key::Num4, Key::Num5, Key::Num6, Key::Num7, Key::Num8, Key::Num9];
    for (lamp, key) in numbers.into_iter().enumerate() {
        if pressed(key) {
            out.push(Command::ToggleLamp(lamp));
        }
    }
    if pressed(Key::Num0) {
        let any_on = model.edits.lighting.lamps.iter().any(|lamp| lamp.on);
        out.push(Command::AllLamps(!any_on));
    }
}

fn display_keys(pressed: &impl Fn(Key) -> bool, model: &Model<'_>, out: &mut Commands) {
    let now = model.edits.display;
    let mut new = now;
    if pressed(Key::M) {
        new.wireframe = !now.wireframe;
    }
    if pressed(Key::G) {
        new.shading = if now.shading == ShadingMode::Flat { ShadingMode::Smooth } else { ShadingMode::Flat };
    }
    if pressed(Key::L) {
        let lux = now.quantity == Quantity::Illuminance;
        new = new.showing(if lux { Quantity::Picture } else { Quantity::Illuminance });
    }
    let brighter = f64::from(u8::from(pressed(Key::Plus) || pressed(Key::Equals)))
        - f64::from(u8::from(pressed(Key::Minus)));
    if now.auto_exposure {
        new.compensation = (now.compensation + brighter * EXPOSURE_STEP).clamp(-4.0, 4.0);
    } else {
        new.ev = (now.ev - brighter * EXPOSURE_STEP).clamp(-6.0, 18.0);
    }
    if new != now {
        out.push(Command::SetDisplay(new));
    }
}
