//! Looking into patches: rows on the scene, the hemicube, neighbours, the table.

use crate::support::{Counting, click, click_at, place_of, press, solved, wait_until, window};
use egui::accesskit::Role;
use egui::{Key, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use lumenwalk::display::NO_VALUE;
use lumenwalk::ui::{App, Quantity};

/// A patch of the brick wall that the start view sees in the open.
fn wall_patch() -> u32 {
    let snapshot = solved();
    let (mesh, scene) = (snapshot.mesh().cloned().expect("meshed"), snapshot.scene().cloned().expect("read"));
    let far = |p: &&lumenwalk::mesh::Patch| scene.materials[p.material as usize].name == "plaster";
    let wanted = glam::dvec3(4.0, 1.6, 1.2);
    let best = mesh
        .patches
        .iter()
        .filter(far)
        .min_by(|a, b| a.centre.distance(wanted).total_cmp(&b.centre.distance(wanted)))
        .expect("plaster");
    mesh.patches.iter().position(|p| std::ptr::eq(p, best)).expect("of the mesh") as u32
}

/// A window with a patch of the wall looked into, its row there.
fn looking(drawn: bool) -> (Harness<'static, App>, u32) {
    let mut harness = window(&Counting::showing(solved()), drawn);
    let patch = wall_patch();
    let at = place_of(&harness, patch);
    click_at(&mut harness, at, Modifiers::COMMAND | Modifiers::CTRL);
    assert_eq!(harness.state().inspected(), Some(patch));
    wait_until(&mut harness, "the hemicube", |h| {
        h.query_by_label(&format!("Hemicube of patch {patch}")).is_some()
    });
    harness.run_steps(4);
    (harness, patch)
}

fn quantity(harness: &Harness<'_, App>) -> Quantity {
    harness.state().edits().display.quantity
}

#[test]
fn the_row_on_the_scene_is_the_row_of_the_matrix() {
    let (mut harness, patch) = looking(false);
    let snapshot = solved();
    let (mesh, factors) =
        (snapshot.mesh().cloned().expect("meshed"), snapshot.transport().cloned().expect("F"));
    click(&mut harness, "Row on the scene");
    assert_eq!(quantity(&harness), Quantity::RowDensity);
    for (name, shown) in [
        ("Row: form factor F", Quantity::RowFactor),
        ("Row: light per area", Quantity::RowLight),
        ("Row: F per area", Quantity::RowDensity),
    ] {
        click(&mut harness, name);
        assert_eq!(quantity(&harness), shown);
        let values = harness.state().shown_values();
        assert_eq!(values.len(), mesh.patches.len());
        let (mut seen, mut lux) = (0, 0.0);
        for (j, &value) in values.iter().enumerate() {
            let f = factors.get(patch as usize, j);
            if f == 0.0 || j == patch as usize {
                assert!(value == NO_VALUE || j == patch as usize, "{j} is not seen: {value}");
                continue;
            }
            let area = mesh.patches[j].area;
            let expected = match shown {
                Quantity::RowFactor => f,
                Quantity::RowDensity => f / area,
                _ => {
                    lux += f64::from(value) * area;
                    continue;
                }
            };
            assert!((f64::from(value) - expected).abs() <= 1e-6 * expected, "{j}: {value} and {expected}");
            seen += 1;
        }
        if shown == Quantity::RowLight {
            let h = harness.state().light().irradiance[patch as usize].map(f64::from);
            let expected = lumenwalk::scene::illuminance(h);
            // The lamps' part is more exact in the light itself than in a row.
            assert!((lux / expected - 1.0).abs() < 1e-2, "all of its light: {lux} of {expected} lx");
        } else {
            assert!(seen > 300, "{seen}");
        }
    }
    click(&mut harness, "Row on the scene");
    assert_eq!(quantity(&harness), Quantity::Picture);
}

#[test]
fn the_row_gives_way_to_what_was_shown_before_and_is_one_step_of_undo() {
    let (mut harness, _) = looking(false);
    press(&mut harness, Key::L);
    press(&mut harness, Key::R);
    assert!(quantity(&harness).is_row() && harness.state().edits().display.logarithmic);
    press(&mut harness, Key::R);
    assert_eq!(quantity(&harness), Quantity::Illuminance);
    assert!(!harness.state().edits().display.logarithmic);
    press(&mut harness, Key::R);
    press(&mut harness, Key::Escape);
    assert_eq!((quantity(&harness), harness.state().inspected()), (Quantity::Illuminance, None));
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    harness.run_steps(3);
    assert!(quantity(&harness).is_row(), "undo brings it back");
}

#[test]
fn the_key_alone_looks_into_the_patch_under_the_cursor() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::R);
    assert_eq!((harness.state().inspected(), quantity(&harness)), (None, Quantity::Picture));
    let patch = wall_patch();
    let at = place_of(&harness, patch);
    harness.hover_at(at);
    harness.run_steps(2);
    press(&mut harness, Key::R);
    assert_eq!(harness.state().inspected(), Some(patch));
    assert!(quantity(&harness).is_row());
}

#[test]
fn a_click_into_the_hemicube_looks_into_what_it_sees_and_back() {
    let (mut harness, patch) = looking(false);
    click(&mut harness, "Hemicube by patch ids");
    click(&mut harness, "Hemicube by light");
    let middle = harness.get_by_label(&format!("Hemicube of patch {patch}")).rect().center();
    click_at(&mut harness, middle, Modifiers::NONE);
    let seen = harness.state().inspected().expect("a patch");
    assert_ne!(seen, patch);
    let mesh = solved().mesh().cloned().expect("meshed");
    let [from, to] = [patch, seen].map(|p| &mesh.patches[p as usize]);
    let way = (to.centre - from.centre).normalize();
    assert!(from.normal.dot(way) > 0.9, "the middle looks straight ahead: {}", from.normal.dot(way));
    click(&mut harness, "Back");
    assert_eq!(harness.state().inspected(), Some(patch));
    assert!(harness.query_by_label("Back").is_some());
}

#[test]
fn neighbours_are_listed_and_one_click_away() {
    let (mut harness, patch) = looking(false);
    let mesh = solved().mesh().cloned().expect("meshed");
    let around = mesh.neighbours(patch);
    assert!(around.len() >= 5);
    let (neighbour, _) = around[1];
    harness.get_by_label(&format!("Look into patch {neighbour}")).scroll_to_me();
    harness.run_steps(30);
    click(&mut harness, &format!("Look into patch {neighbour}"));
    assert_eq!(harness.state().inspected(), Some(neighbour));
    press(&mut harness, Key::Backspace);
    assert_eq!(harness.state().inspected(), Some(patch));
}

#[test]
fn the_table_sorts_and_goes_to_a_patch() {
    let mut harness = window(&Counting::showing(solved()), false);
    press(&mut harness, Key::J);
    wait_until(&mut harness, "the maps", |h| h.query_by_label("Sort by recip. %").is_some());
    let (mesh, factors) =
        (solved().mesh().cloned().expect("meshed"), solved().transport().cloned().expect("assembled"));
    let worst = (0..mesh.patches.len())
        .max_by(|&a, &b| {
            let of = |i: usize| factors.quality(i).worst_reciprocity;
            of(a).total_cmp(&of(b)).then(b.cmp(&a))
        })
        .expect("patches");
    click(&mut harness, "Sort by recip. %");
    let name = format!("Patch {worst}");
    wait_until(&mut harness, "the worst pair", |h| {
        h.query_by_label(&name)
            .is_some_and(|line| line.rect().top() < h.get_by_label("Sort by recip. %").rect().bottom() + 30.0)
    });
    click(&mut harness, &name);
    harness.run_steps(60);
    assert_eq!(harness.state().inspected(), Some(worst as u32));
    let camera = harness.state().camera().expect("shown");
    let way = mesh.patches[worst].centre - camera.eye;
    assert!(camera.forward.dot(way.normalize()) > 0.999, "it is in the middle of the view");
    assert!(mesh.patches[worst].normal.dot(way) < 0.0, "from its own side");
    // Once more: the smallest come first.
    let largest = (0..mesh.patches.len())
        .max_by(|&a, &b| mesh.patches[a].area.total_cmp(&mesh.patches[b].area).then(b.cmp(&a)))
        .expect("patches");
    click(&mut harness, "Sort by area m²");
    assert!(harness.query_by_label(&format!("Patch {largest}")).is_some());
    click(&mut harness, "Sort by area m²");
    assert!(harness.query_by_label(&format!("Patch {largest}")).is_none());
    click(&mut harness, "Close");
    harness.run_steps(30);
    assert!(harness.query_by_label("Sort by aspect").is_none());
}

#[test]
fn maps_of_defects_come_in_their_units_and_signs() {
    let mut harness = window(&Counting::showing(solved()), false);
    let factors = solved().transport().cloned().expect("assembled");
    let chosen = |harness: &mut Harness<'_, App>, name: &str| {
        harness.get_by_label("Show").scroll_to_me();
        harness.run_steps(20);
        click(harness, "Show");
        // Its line in the list, not the panels' own numbers of that name.
        let line = |h: &Harness<'_, App>| h.get_by_role_and_label(Role::Button, name).rect().center();
        harness.get_by_role_and_label(Role::Button, name).scroll_to_me();
        harness.run_steps(10);
        let at = line(harness);
        click_at(harness, at, Modifiers::NONE);
        wait_until(harness, name, |h| !h.state().shown_values().is_empty());
        harness.state().shown_values().to_vec()
    };
    let reciprocity = chosen(&mut harness, "Worst reciprocity");
    assert_eq!(quantity(&harness), Quantity::Reciprocity);
    for (i, &value) in reciprocity.iter().enumerate() {
        assert!((value - 100.0 * factors.quality(i).worst_reciprocity).abs() < 1e-3);
    }
    let escape = chosen(&mut harness, "Escaping share");
    assert_eq!(quantity(&harness), Quantity::Escape);
    let mut blind = 0;
    for (i, &value) in escape.iter().enumerate() {
        if factors.sees(i) {
            assert!((f64::from(value) - 100.0 * (1.0 - factors.row_sum(i))).abs() < 1e-3, "{i}: {value}");
        } else {
            assert_eq!(value, NO_VALUE, "{i} sees nothing");
            blind += 1;
        }
    }
    assert!(blind < escape.len() / 10, "{blind}");
    let residual = chosen(&mut harness, "Residual");
    let brightest = harness.state().light().radiosity.iter().map(|b| lumenwalk::display::luminance(*b));
    let brightest = brightest.fold(0.0, f64::max);
    assert!(residual.iter().all(|r| f64::from(r.abs()) < 1e-3 * brightest), "converged");
    assert!(residual.iter().any(|&r| r != 0.0));
}

#[test]
fn the_map_of_the_error_comes_with_the_check_and_goes_with_the_light() {
    let mut harness = window(&Counting::showing(solved()), false);
    wait_until(&mut harness, "the check", |h| {
        h.query_by_label("Half the area is off by less than -").is_none()
    });
    click(&mut harness, "Map of the error");
    assert_eq!(quantity(&harness), Quantity::Error);
    let mesh = solved().mesh().cloned().expect("meshed");
    let values = harness.state().shown_values().to_vec();
    assert_eq!(values.len(), mesh.patches.len());
    for (value, patch) in values.iter().zip(&mesh.patches) {
        let receives = patch.luminaire.is_none() && !patch.buried;
        assert_eq!(*value > NO_VALUE, receives);
        assert!(!receives || (*value > 0.0 && value.is_finite()));
    }
    // Another light is another error: nothing is shown until it is known.
    press(&mut harness, Key::Num1);
    assert!(harness.state().shown_values().is_empty());
    wait_until(&mut harness, "the next check", |h| !h.state().shown_values().is_empty());
    assert_ne!(harness.state().shown_values(), values);
}
