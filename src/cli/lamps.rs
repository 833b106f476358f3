use super::failure::Failure;
use super::text;
use crate::scene::{self, Lighting, Scene, nearest_names};
use clap::Args;

/// Lamps that the model does not have.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct LampOptions {
    /// Add a lamp below the ceiling of each room, several in a large one, whether the model has lamps or not
    #[arg(long)]
    pub(super) ceiling_lamps: bool,
}

impl LampOptions {
    /// The scene with the lamps asked for; tells on standard error which they are.
    ///
    /// # Errors
    /// There is no place for a lamp.
    pub(super) fn add_to(self, scene: Scene) -> Result<Scene, Failure> {
        if !self.ceiling_lamps {
            return Ok(scene);
        }
        let lamps = scene::ceiling_lamps(&scene);
        if lamps.is_empty() {
            let message = format!("{} has no floor that a lamp could hang over", scene.name);
            return Err(Failure::input(message));
        }
        let names = scene::name_list(lamps.iter().map(|lamp| lamp.name.as_str()));
        let lumens: f64 = lamps.iter().map(|lamp| lamp.lumens).sum();
        text::complain(&format!(
            "{} added to {}, {} lm in all: {names}",
            text::count(lamps.len(), "lamp"),
            scene.name,
            text::thousands(lumens.round() as usize),
        ));
        let placed = scene.placed.iter().cloned().chain(lamps).collect();
        Ok(scene.with_placed(placed))
    }
}

/// Says at once that there is no light, and what can be done about it.
pub(super) fn tell_darkness(scene: &Scene, lighting: &Lighting) {
    let name = &scene.name;
    let dark = |e: [f64; 3]| e.iter().all(|e| *e <= 0.0);
    if scene.luminaires.is_empty() {
        text::complain(&format!(
            "{name} has no lamps, so no light is computed and pictures show it in plain even light; \
             --ceiling-lamps adds a lamp to each room"
        ));
    } else if lighting.lamps.iter().all(|lamp| dark(lamp.exitance)) {
        text::complain(&format!("no lamp of {name} gives any light, so pictures of it are black"));
    } else if lighting.lamps.iter().all(|lamp| dark(lamp.output())) {
        text::complain(&format!(
            "all lamps of {name} are off, so pictures of it are black; --on NAME switches one on"
        ));
    }
}

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
