//! Laws that hold in every closed scene, whatever stands in it.

use super::scenes::{cluttered_room, cube, l_shaped_room, room_with_blocks, rooms_in_a_row};
use super::{Assembled, Case, CaseError, Group, Model, Way};
use crate::mesh::PatchTarget;
use std::sync::Arc;

const FURNACE: &str = "white furnace: E = 1 - rho gives B = 1";
const POWER: &str = "uniform rho: sum A B = sum A E / (1 - rho)";
const CLOSURE: &str = "closure: a closed scene's rows sum to 1";
const BALANCE: &str = "emitted = absorbed";

/// The scenes of this group: name, maker, patches.
type Scenes = [(&'static str, fn() -> Model, usize); 5];

fn scenes() -> Scenes {
    [
        ("cube", cube, 150),
        ("room with two blocks", || room_with_blocks(0.5), 500),
        ("L-shaped room", || l_shaped_room(0.5), 400),
        ("three rooms with doors", || rooms_in_a_row(3, 0.5), 500),
        ("six boxes cut through each other", || cluttered_room(6, 5), 500),
    ]
}

fn assemble(make: fn() -> Model, patches: usize, way: Way) -> Result<Assembled, CaseError> {
    let settings = way.settings(PatchTarget::Count(patches));
    // The laws hold at any resolution.
    let settings = crate::solve::SolveSettings { resolution: settings.resolution.map(|r| r / 4), ..settings };
    Assembled::new(Arc::new(make().read(None)?), &settings)
}

/// The value that is furthest from one.
fn worst(values: impl Iterator<Item = f64>) -> f64 {
    values
        .fold(1.0, |worst, v| if (v - 1.0).abs() > (worst - 1.0_f64).abs() || v.is_nan() { v } else { worst })
}

pub(super) fn cases() -> Vec<Case> {
    let mut cases: Vec<Case> = Vec::new();
    for (name, make, patches) in scenes() {
        cases.push(
            Case::new(Group::ClosedScenes, format!("{name}: the worst row sum"), CLOSURE, 1.0, move |way| {
                let made = assemble(make, patches, way)?;
                Ok(worst(made.seeing().into_iter().map(|i| made.transport.row_sum(i))))
            })
            .all_methods(1e-6)
            .because("rows are scaled to their sums to 1e-7"),
        );
        cases.push(
            Case::new(
                Group::ClosedScenes,
                format!("{name}: the worst B of a furnace"),
                FURNACE,
                1.0,
                move |way| {
                    let made = assemble(make, patches, way)?;
                    // Reflectances from 0 to 0.98 by the patch.
                    let rho = |i: usize| 0.98 * (0.618_033_988_749_895 * i as f64).fract();
                    let b = made.radiosity(&made.grey_system(|i| (rho(i), 1.0 - rho(i))), 1e-7)?;
                    Ok(worst(made.seeing().into_iter().map(|i| b[i])))
                },
            )
            .all_methods(1e-3)
            .because("what a furnace is held to"),
        );
        cases.push(
            Case::new(Group::ClosedScenes, format!("{name}: power"), BALANCE, 1.0, move |way| {
                super::open_scenes::balance(&assemble(make, patches, way)?)
            })
            .all_methods(1e-6)
            .because("swept until the error bound is 1e-8"),
        );
    }
    for rho in [0.5, 0.9, 0.99, 0.999, 0.9999] {
        cases.push(
            Case::new(
                Group::ClosedScenes,
                format!("three rooms with doors, rho {rho}"),
                POWER,
                1.0,
                move |way| {
                    let made = assemble(|| rooms_in_a_row(3, 0.5), 500, way)?;
                    let exitance = |i: usize| if made.patches()[i].luminaire.is_some() { 20.0 } else { 0.0 };
                    let b = made.radiosity(&made.grey_system(|i| (rho, exitance(i))), 1e-8)?;
                    let seeing = made.seeing();
                    Ok(made.mean(&seeing, |i| b[i]) * (1.0 - rho) / made.mean(&seeing, exitance))
                },
            )
            .lines(1e-5)
            .because("row sums are known to 1e-7, and near rho 1 that is multiplied; swept to 1e-8"),
        );
    }
    cases
}
