use super::failure::Failure;
use crate::effects::{Effect, EffectChoices};
use crate::form_factors::{Method, ReceivingPoints};
use crate::mesh::PatchTarget;
use crate::scene::{FrameChoice, LengthUnit, SceneSource, UpAxis};
use crate::solve::{DirectTarget, SolveSettings};
use crate::transport::TransportKind;
use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use glam::DVec3;

/// Lines and hemicubes finer than this gain nothing but time.
const FINEST: u32 = 8192;

/// How finely surfaces are split.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct PatchOptions {
    /// Longest edge of a patch, in the unit of the scene's file
    #[arg(long, value_name = "LENGTH", value_parser = positive, conflicts_with = "patches")]
    pub(super) patch_size: Option<f64>,
    /// About how many patches in all
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=10_000_000))]
    pub(super) patches: Option<u32>,
    /// Take every polygon of the file as one patch, for models that are cut into patches already
    #[arg(long, conflicts_with_all = ["patches", "patch_size"])]
    pub(super) patches_as_given: bool,
}

impl PatchOptions {
    pub(super) fn target(&self, unit: LengthUnit) -> PatchTarget {
        if self.patches_as_given {
            return PatchTarget::AsGiven;
        }
        match (self.patch_size, self.patches) {
            (Some(size), _) => PatchTarget::Size(size * unit.metres()),
            (None, Some(count)) => PatchTarget::Count(count as usize),
            (None, None) => PatchTarget::Auto,
        }
    }
}

/// How the file of a scene is to be read.
#[derive(Args, Clone, Copy, Debug, Default)]
pub(super) struct FrameOptions {
    /// Unit of the scene's file, over its sidecar: mm, cm, m, in or ft
    #[arg(long, value_name = "UNIT", value_parser = units())]
    pub(super) unit: Option<LengthUnit>,
    /// Axis of the scene's file that points up, over its sidecar
    #[arg(long, value_name = "AXIS", value_parser = axes())]
    pub(super) up: Option<UpAxis>,
}

impl FrameOptions {
    /// The scene of this name, to be read so.
    pub(super) fn source(&self, name: &str) -> Result<SceneSource, Failure> {
        let source = SceneSource::from(name);
        let choice = FrameChoice { unit: self.unit, up: self.up };
        if source.path().is_none() && choice != FrameChoice::default() {
            return Err(Failure::input("--unit and --up are for files; embedded scenes know theirs"));
        }
        Ok(source.framed(choice))
    }
}

/// Effects forced on or off.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct EffectOptions {
    /// Simulate this effect even where the scene does not call for it (may be repeated)
    #[arg(long, value_name = "EFFECT", value_parser = effects())]
    pub(super) with: Vec<Effect>,
    /// Leave this effect out (may be repeated)
    #[arg(long, value_name = "EFFECT", value_parser = effects())]
    pub(super) without: Vec<Effect>,
}

impl EffectOptions {
    pub(super) fn choices(&self) -> Result<EffectChoices, Failure> {
        if let Some(both) = self.with.iter().find(|effect| self.without.contains(effect)) {
            let name = both.name();
            return Err(Failure::input(format!("{name} is named by --with and by --without; choose one")));
        }
        Ok(EffectChoices { with: self.with.clone(), without: self.without.clone() })
    }
}

/// Everything that a solve depends on besides the scene.
#[derive(Args, Clone, Debug, Default)]
pub(super) struct SolveOptions {
    #[command(flatten)]
    pub(super) patches: PatchOptions,
    /// How form factors are computed [default: lines]
    #[arg(long, value_parser = methods())]
    pub(super) method: Option<Method>,
    /// Lines, cells along an edge of the hemicube, or rays a patch [default: by method]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(4..=1_048_576))]
    pub(super) resolution: Option<u32>,
    /// At how many points of a patch its row is gathered: auto, 1 (its centre), 4 or 16 [default: auto]
    #[arg(long, value_name = "N", value_parser = receiving_points())]
    pub(super) receiving_points: Option<ReceivingPoints>,
    /// Elements that direct light is laid out on at most, besides the triangles of the mesh [default: 200000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=4_000_000))]
    pub(super) elements: Option<u32>,
    /// What carries light between patches: a matrix of all pairs, or rows that end at nodes of a tree over patches,
    /// which take less memory [default: auto: the matrix where it is small]
    #[arg(long, value_name = "KIND", value_parser = transports())]
    pub(super) transport: Option<TransportKind>,
    /// Relative error bound at which the solve stops [default: 0.0001]
    #[arg(long, value_name = "T", value_parser = tolerance)]
    pub(super) tolerance: Option<f64>,
    #[command(flatten)]
    pub(super) effects: EffectOptions,
    /// Threads at work [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
}

impl SolveOptions {
    /// Settings for a scene whose file is in this unit.
    pub(super) fn settings(&self, unit: LengthUnit) -> Result<SolveSettings, Failure> {
        let defaults = SolveSettings::default();
        let method = self.method.unwrap_or(defaults.method);
        if method != Method::Rays && self.resolution.is_some_and(|n| n > FINEST) {
            return Err(Failure::input(format!(
                "--resolution of the method {} goes up to {FINEST}",
                method.name()
            )));
        }
        Ok(SolveSettings {
            refinement: None,
            patches: self.patches.target(unit),
            method,
            resolution: self.resolution,
            points: self.receiving_points.unwrap_or(defaults.points),
            direct: DirectTarget {
                most: self.elements.map_or(defaults.direct.most, |most| most as usize),
                // Whoever names a number waits for it.
                work: if self.elements.is_some() { u64::MAX } else { defaults.direct.work },
                ..defaults.direct
            },
            transport: self.transport.unwrap_or(defaults.transport),
            tolerance: self.tolerance.unwrap_or(defaults.tolerance),
            effects: self.effects.choices()?,
        })
    }

    /// Lets `--threads` rule over all parallel work of the process. To be called before any.
    pub(super) fn set_threads(&self) -> Result<(), Failure> {
        set_threads(self.threads)
    }
}

/// As [`SolveOptions::set_threads`]; `None` sets all cores to work.
pub(super) fn set_threads(threads: Option<u16>) -> Result<(), Failure> {
    rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from)).build_global().map_err(
        |error| {
            let what =
                "the threads cannot be started; raise the limits of this process (ulimit -u, ulimit -v)";
            Failure::work(anyhow::Error::new(error).context(what))
        },
    )
}

fn units() -> impl TypedValueParser<Value = LengthUnit> {
    PossibleValuesParser::new(LengthUnit::ALL.map(LengthUnit::symbol))
        .map(|symbol| LengthUnit::ALL.into_iter().find(|unit| unit.symbol() == symbol).unwrap_or_default())
}

fn axes() -> impl TypedValueParser<Value = UpAxis> {
    PossibleValuesParser::new(["y", "z"]).map(|axis| if axis == "z" { UpAxis::Z } else { UpAxis::Y })
}

fn methods() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(Method::ALL.map(Method::name))
        .map(|name| Method::ALL.into_iter().find(|method| method.name() == name).unwrap_or_default())
}

pub(super) fn transports() -> impl TypedValueParser<Value = TransportKind> {
    PossibleValuesParser::new(TransportKind::ALL.map(TransportKind::name))
        .map(|name| TransportKind::ALL.into_iter().find(|kind| kind.name() == name).unwrap_or_default())
}

fn receiving_points() -> impl TypedValueParser<Value = ReceivingPoints> {
    PossibleValuesParser::new(ReceivingPoints::ALL.map(ReceivingPoints::name))
        .map(|name| ReceivingPoints::ALL.into_iter().find(|points| points.name() == name).unwrap_or_default())
}

fn effects() -> impl TypedValueParser<Value = Effect> {
    PossibleValuesParser::new(Effect::ALL.map(Effect::name))
        .try_map(|name| Effect::ALL.into_iter().find(|effect| effect.name() == name).ok_or("no such effect"))
}

/// A finite number above zero.
pub(super) fn positive(text: &str) -> Result<f64, String> {
    let value = finite(text)?;
    if value > 0.0 { Ok(value) } else { Err("it must be above zero".into()) }
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value = finite(text)?;
    if (1e-9..1.0).contains(&value) { Ok(value) } else { Err("it must lie between 1e-9 and 1".into()) }
}

/// Degrees of a field of view.
pub(super) fn field_of_view(text: &str) -> Result<f64, String> {
    let value = finite(text)?;
    if (5.0..=150.0).contains(&value) { Ok(value) } else { Err("it must lie between 5 and 150".into()) }
}

/// Frames a second.
pub(super) fn frame_rate(text: &str) -> Result<f64, String> {
    let value = finite(text)?;
    if (0.1..=240.0).contains(&value) { Ok(value) } else { Err("it must lie between 0.1 and 240".into()) }
}

/// `X,Y,Z`.
pub(super) fn place(text: &str) -> Result<DVec3, String> {
    let fields: Vec<&str> = text.split(',').collect();
    let [x, y, z] = fields[..] else { return Err("three numbers are needed: X,Y,Z".into()) };
    Ok(DVec3::new(finite(x)?, finite(y)?, finite(z)?))
}

/// `WxH` in pixels.
pub(super) fn size(text: &str) -> Result<[u32; 2], String> {
    const LARGEST: u32 = 16_384;
    let wrong = || format!("WIDTHxHEIGHT is needed, each from 1 to {LARGEST}");
    let (width, height) = text.split_once(['x', 'X']).ok_or_else(wrong)?;
    let side = |text: &str| text.parse().ok().filter(|side| (1..=LARGEST).contains(side)).ok_or_else(wrong);
    Ok([side(width)?, side(height)?])
}

/// `NAME=0.3`; the name may hold `=` itself.
pub(super) fn dimming(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.rsplit_once('=').ok_or("NAME=VALUE is needed, as in \"Desk lamp=0.3\"")?;
    let value = finite(value)?;
    if name.trim().is_empty() {
        Err("the name of a lamp is missing before =".into())
    } else if (0.0..=1.0).contains(&value) {
        Ok((name.to_owned(), value))
    } else {
        Err("a dimmer goes from 0 to 1".into())
    }
}

/// A finite number.
pub(super) fn finite(text: &str) -> Result<f64, String> {
    let value = text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    value.ok_or_else(|| format!("{:?} is not a number", text.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_read_and_refused_with_a_reason() {
        assert_eq!(positive("2.5"), Ok(2.5));
        for bad in ["0", "-1", "nan", "inf", "two", ""] {
            assert!(positive(bad).is_err(), "{bad}");
        }
        assert_eq!(place("1,-2.5, 3e1"), Ok(DVec3::new(1.0, -2.5, 30.0)));
        assert!(place("1,2").is_err() && place("1,2,3,4").is_err() && place("1,2,x").is_err());
        assert_eq!(size("640x400"), Ok([640, 400]));
        assert!(size("640").is_err() && size("0x4").is_err() && size("99999x4").is_err());
        assert_eq!(dimming("Desk=left=0.3"), Ok(("Desk=left".into(), 0.3)));
        assert!(dimming("Desk").is_err() && dimming("=1").is_err() && dimming("Desk=1.5").is_err());
        assert!(tolerance("0").is_err() && tolerance("1").is_err() && tolerance("1e-4").is_ok());
        assert!(frame_rate("0").is_err() && frame_rate("29.97") == Ok(29.97));
        assert!(field_of_view("4").is_err() && field_of_view("60").is_ok());
    }

    #[test]
    fn patch_sizes_are_in_the_unit_of_the_file() {
        let options = PatchOptions { patch_size: Some(250.0), ..PatchOptions::default() };
        assert_eq!(options.target(LengthUnit::Millimetre), PatchTarget::Size(0.25));
        assert_eq!(PatchOptions::default().target(LengthUnit::Metre), PatchTarget::Auto);
        let given = PatchOptions { patches_as_given: true, ..PatchOptions::default() };
        assert_eq!(given.target(LengthUnit::Metre), PatchTarget::AsGiven);
    }

    #[test]
    fn an_effect_cannot_be_forced_on_and_off() {
        let both = EffectOptions { with: vec![Effect::Visibility], without: vec![Effect::Visibility] };
        assert!(both.choices().is_err());
    }

    #[test]
    fn fine_resolutions_are_for_rays() {
        let mut options = SolveOptions { resolution: Some(100_000), ..SolveOptions::default() };
        assert!(options.settings(LengthUnit::Metre).is_err());
        options.method = Some(Method::Rays);
        assert_eq!(options.settings(LengthUnit::Metre).unwrap().resolution, Some(100_000));
    }
}
