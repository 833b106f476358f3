use super::failure::Failure;
use crate::scene::{Lighting, Scene, nearest_names};

/// The lamps as they come with the scene, switched and dimmed as the command line says.
///
/// # Errors
/// A name that no luminaire has, or one that is switched both on and off.
pub(super) fn lighting(
    scene: &Scene,
    on: &[String],
    off: &[String],
    dim: &[(String, f64)],
) -> Result<Lighting, Failure> {
    let mut lighting = scene.lighting();
    let mut switched_on = Vec::new();
    for name in on {
        switched_on.extend(lamps(scene, name)?);
    }
    for index in &switched_on {
        lighting.lamps[*index].on = true;
    }
    for name in off {
        for index in lamps(scene, name)? {
            if switched_on.contains(&index) {
                let name = &scene.luminaires[index].name;
                return Err(Failure::input(format!("'{name}' is named by --on and by --off; choose one")));
            }
            lighting.lamps[index].on = false;
        }
    }
    for (name, value) in dim {
        for index in lamps(scene, name)? {
            lighting.lamps[index].dimmer = *value;
        }
    }
    Ok(lighting)
}

/// The lamps that a name means; one at least.
fn lamps(scene: &Scene, name: &str) -> Result<Vec<usize>, Failure> {
    let found = scene.luminaires_named(name);
    if !found.is_empty() {
        return Ok(found);
    }
    let names = scene.luminaires.iter().map(|lamp| lamp.name.as_str());
    Err(unknown(scene, "lamp", name, names))
}

/// The view with this name.
///
/// # Errors
/// A name that no view has.
pub(super) fn view(scene: &Scene, name: &str) -> Result<usize, Failure> {
    scene
        .view_named(name)
        .ok_or_else(|| unknown(scene, "view", name, scene.views.iter().map(|view| view.name.as_str())))
}

fn unknown<'a>(
    scene: &Scene,
    kind: &str,
    name: &str,
    names: impl ExactSizeIterator<Item = &'a str>,
) -> Failure {
    let total = names.len();
    let near: Vec<String> = nearest_names(name, names).iter().map(|near| format!("'{near}'")).collect();
    let start = format!("{} has no {kind} '{name}'", scene.name);
    Failure::input(match total {
        0 => format!("{start}, nor any other {kind}"),
        n if n <= near.len() => format!("{start}; it has {}", near.join(", ")),
        n => format!("{start}; the nearest of its {n} are {}", near.join(", ")),
    })
}
