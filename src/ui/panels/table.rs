//! The table of patches under the view: those that stand out first, by any column.

use super::list::{Cell, LINE, head, line};
use super::{Commands, Model};
use crate::display::{NO_VALUE, luminance};
use crate::scene::illuminance;
use crate::ui::command::Command;
use crate::ui::state::Quantity;
use crate::ui::{theme, units};
use egui::{Align, Layout, RichText, ScrollArea};
use std::sync::Arc;

/// Lines of the table.
const LINES: usize = 100;
/// Width of the column of patch numbers, points.
const PATCH: f32 = 58.0;
/// Width of a column of numbers, points.
const NUMBER: f32 = 61.0;

/// What a column holds.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
enum Column {
    Area,
    #[default]
    Aspect,
    Illuminance,
    Luminance,
    Escape,
    Closure,
    Reciprocity,
    Residual,
    Unshot,
}

impl Column {
    const ALL: [Self; 9] = [
        Self::Area,
        Self::Aspect,
        Self::Illuminance,
        Self::Luminance,
        Self::Escape,
        Self::Closure,
        Self::Reciprocity,
        Self::Residual,
        Self::Unshot,
    ];

    fn title(self) -> &'static str {
        match self {
            Self::Area => "area m²",
            Self::Aspect => "aspect",
            Self::Illuminance => "lx",
            Self::Luminance => "cd/m²",
            Self::Escape => "esc. %",
            Self::Closure => "sum %",
            Self::Reciprocity => "recip. %",
            Self::Residual => "resid.",
            Self::Unshot => "unshot",
        }
    }

    fn tip(self) -> &'static str {
        match self {
            Self::Area => "Area, m²",
            Self::Aspect => Quantity::Aspect.explanation(),
            Self::Illuminance => "Illuminance, lx",
            Self::Luminance => "Luminance, cd/m²",
            Self::Escape => Quantity::Escape.explanation(),
            Self::Closure => Quantity::Closure.explanation(),
            Self::Reciprocity => Quantity::Reciprocity.explanation(),
            Self::Residual => Quantity::Residual.explanation(),
            Self::Unshot => Quantity::Unshot.explanation(),
        }
    }

    /// The value of a patch; `None` where it is not known yet.
    fn value(self, model: &Model<'_>, patch: usize) -> Option<f64> {
        let map = |quantity| {
            let value = *model.microscope.maps()?.of(quantity).get(patch)?;
            (value > NO_VALUE).then_some(f64::from(value))
        };
        match self {
            Self::Area => Some(model.mesh?.patches.get(patch)?.area),
            Self::Aspect => model.aspect.get(patch).map(|&a| f64::from(a)),
            Self::Illuminance => model.light.irradiance.get(patch).map(|h| illuminance(h.map(f64::from))),
            Self::Luminance => model.light.radiosity.get(patch).map(|b| luminance(*b)),
            Self::Escape => map(Quantity::Escape),
            Self::Closure => map(Quantity::Closure),
            Self::Reciprocity => map(Quantity::Reciprocity),
            Self::Residual => map(Quantity::Residual),
            Self::Unshot => map(Quantity::Unshot),
        }
    }
}

/// By which column is sorted, and the largest magnitude first or last.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Sorting {
    by: Column,
    falling: bool,
}

/// Shows the table. A click on a line goes to the patch and looks into it.
pub(in crate::ui) fn show(ui: &mut egui::Ui, model: &Model<'_>, out: &mut Commands) {
    let id = ui.scope_id().with("sorting");
    let mut sorting: Sorting =
        ui.data(|d| d.get_temp(id)).unwrap_or(Sorting { by: Column::default(), falling: true });
    let count = model.mesh.map_or(0, |mesh| mesh.patches.len());
    ui.horizontal(|ui| {
        ui.label(RichText::new("PATCHES").size(11.5).color(theme::TEXT));
        let which = if sorting.falling { "largest" } else { "smallest" };
        let text = format!("{} of {}, {which} first", LINES.min(count), units::count(count));
        ui.label(RichText::new(text).small().color(theme::TEXT_WEAK));
        ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
            if ui.small_button("Close").on_hover_text("Hide this table (J)").clicked() {
                out.push(Command::ToggleTable);
            }
        });
    });
    let name_width = (ui.available_width() - PATCH - NUMBER * Column::ALL.len() as f32 - 10.0).max(60.0);
    ScrollArea::horizontal().show(ui, |ui| {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 0.0;
            ui.add_space(PATCH + name_width);
            for column in Column::ALL {
                let sorted = (sorting.by == column).then_some(sorting.falling);
                if head(ui, NUMBER, column.title(), sorted).on_hover_text(column.tip()).clicked() {
                    let falling = sorting.by != column || !sorting.falling;
                    sorting = Sorting { by: column, falling };
                }
            }
        });
        let patches = sorted(ui, model, sorting);
        ui.spacing_mut().item_spacing.y = 0.0;
        ScrollArea::vertical().auto_shrink(false).show_rows(ui, LINE, patches.len(), |ui, range| {
            for &patch in &patches[range] {
                table_line(ui, model, patch, name_width, sorting.by, out);
            }
        });
    });
    ui.data_mut(|d| d.insert_temp(id, sorting));
}

fn table_line(
    ui: &mut egui::Ui,
    model: &Model<'_>,
    patch: u32,
    name_width: f32,
    by: Column,
    out: &mut Commands,
) {
    let names = model.mesh.zip(model.scene).and_then(|(mesh, scene)| {
        let own = mesh.patches.get(patch as usize)?;
        let object = scene.objects.get(mesh.regions.get(own.region as usize)?.object as usize)?;
        Some((object.as_str(), scene.materials.get(own.material as usize)?.name.as_str()))
    });
    let (object, material) = names.unwrap_or_default();
    let mut cells = vec![
        Cell::number(PATCH, units::count(patch as usize)),
        Cell::name(name_width, format!("{object}, {material}")).weak(),
    ];
    cells.extend(Column::ALL.map(|column| {
        let value = column.value(model, patch as usize);
        let told = match column {
            Column::Illuminance | Column::Luminance => units::light,
            _ => units::digits,
        };
        let cell = Cell::number(NUMBER, value.map_or_else(|| "-".to_owned(), told));
        if column == by { cell } else { cell.weak() }
    }));
    let shown = line(ui, &format!("Patch {patch}"), model.inspected == Some(patch), &cells);
    if shown.on_hover_text(format!("{object}, {material}: go there and look into it")).clicked() {
        out.push(Command::JumpToPatch(patch));
    }
}

/// Sorting, mesh, light and answers of the microscope that a list was made of.
type Key = (Column, bool, u64, u64);

/// The list as it was, or made anew where something has changed.
fn sorted(ui: &egui::Ui, model: &Model<'_>, sorting: Sorting) -> Arc<Vec<u32>> {
    let id = ui.scope_id().with("sorted");
    let key: Key = (sorting.by, sorting.falling, model.light_version, model.microscope.version);
    if let Some((known, list)) = ui.data(|d| d.get_temp::<(Key, Arc<Vec<u32>>)>(id))
        && known == key
    {
        return list;
    }
    let count = model.mesh.map_or(0, |mesh| mesh.patches.len());
    let list = Arc::new(first(count, sorting.falling, |patch| sorting.by.value(model, patch)));
    ui.data_mut(|d| d.insert_temp(id, (key, Arc::clone(&list))));
    list
}

/// The first [`LINES`] of `count` patches by the magnitude of their values; those without one last.
fn first(count: usize, falling: bool, value: impl Fn(usize) -> Option<f64>) -> Vec<u32> {
    let rank = |patch: usize| {
        let size = value(patch).map(f64::abs).filter(|size| size.is_finite());
        size.map_or(f64::INFINITY, |size| if falling { -size } else { size })
    };
    let mut all: Vec<(f64, u32)> = (0..count).map(|patch| (rank(patch), patch as u32)).collect();
    let order = |a: &(f64, u32), b: &(f64, u32)| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1));
    if all.len() > LINES {
        all.select_nth_unstable_by(LINES, order);
        all.truncate(LINES);
    }
    all.sort_unstable_by(order);
    all.into_iter().map(|(_, patch)| patch).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_come_first_whatever_their_sign() {
        let values = [Some(1.0), Some(-7.0), None, Some(3.0), Some(f64::NAN)];
        assert_eq!(first(5, true, |p| values[p]), [1, 3, 0, 2, 4]);
        assert_eq!(first(5, false, |p| values[p]), [0, 3, 1, 2, 4]);
    }

    #[test]
    fn of_many_only_the_first_are_kept_in_order() {
        let value = |p: usize| Some(((p * 7919) % 50_021) as f64);
        let list = first(50_000, true, value);
        assert_eq!(list.len(), LINES);
        let values: Vec<f64> = list.iter().filter_map(|&p| value(p as usize)).collect();
        assert!(values.is_sorted_by(|a, b| a >= b));
        let larger = (0..50_000).filter_map(value).filter(|&v| v > values[LINES - 1]).count();
        assert_eq!(larger, LINES - 1);
    }
}
