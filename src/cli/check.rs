use super::failure::Failure;
use super::lamps::LampOptions;
use super::options::FrameOptions;
use super::photometry;
use super::report::severity_name;
use super::{text, weather};
use crate::mesh::{self, MeshSettings};
use crate::outputs::save_repaired;
use crate::scene::{self, Crossing, Finding, Scene, Severity, Summary};
use clap::Args;
use std::path::{Path, PathBuf};

/// Models of more surfaces take long to be cut into patches.
const MOST_SURFACES: usize = 40_000;

/// Tell what a file holds and what is wrong with it: a model, a photometric file of a luminaire (IES, EULUMDAT), or a weather file (EPW)
///
/// Exits with 1 where a part of the model had to be left out.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), builtin:NAME, or an .ies, .ldt or .epw file
    #[arg(value_name = "FILE")]
    scene: String,
    #[command(flatten)]
    frame: FrameOptions,
    #[command(flatten)]
    lamps: LampOptions,
    /// Write a mended copy, with its MTL and sidecar beside it; the model itself stays as it is
    #[arg(long, value_name = "OUT.obj")]
    repair: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    if photometry::is_photometric(&arguments.scene) {
        return text::print(&photometry::check(&arguments.scene)?);
    }
    if weather::is_weather(&arguments.scene) {
        return text::print(&weather::check(&arguments.scene)?);
    }
    let scene = scene::load(&arguments.frame.source(&arguments.scene)?)?;
    let scene = arguments.lamps.add_to(scene)?;
    let mut findings = scene.findings.clone();
    let examination = scene::examine(&scene);
    findings.extend(examination.findings);
    findings.extend(of_patches(&scene, &examination.crossings));
    let mut told = format!("{}{}", Summary::of(&scene), describe(&mut findings));
    if let Some(copy) = &arguments.repair {
        told += &repair(copy, &scene)?;
    }
    text::print(&told)?;
    if findings.iter().any(|finding| finding.severity == Severity::Error) {
        return Err(Failure::Told);
    }
    Ok(())
}

/// Writes the copy and tells what was done to it.
fn repair(copy: &Path, scene: &Scene) -> Result<String, Failure> {
    let mended = save_repaired(copy, scene)?;
    let mut told = format!("repaired copy: {}\n", copy.display());
    if mended.done.is_empty() {
        told += "  nothing had to be mended\n";
    }
    for line in &mended.done {
        told += &format!("  {line}\n");
    }
    for line in &mended.left {
        told += &format!("  left: {line}\n");
    }
    Ok(told)
}

/// What the patches of the scene tell, where it is small enough to be cut into them at once.
fn of_patches(scene: &Scene, crossings: &[Crossing]) -> Vec<Finding> {
    if scene.surfaces.len() > MOST_SURFACES {
        let message = format!(
            "unlit parts and cut patches were not looked for among {} surfaces; open the model in the window for that",
            text::thousands(scene.surfaces.len())
        );
        return vec![Finding::unsearched(message)];
    }
    match mesh::build(scene, &MeshSettings::default()) {
        Ok(mesh) => mesh::checkup(scene, &mesh, crossings),
        // A solve would say the same, as an error.
        Err(error) => vec![Finding::unsearched(format!("the model was not cut into patches: {error}"))],
    }
}

/// The findings, worst first, and a line that counts them.
fn describe(findings: &mut [Finding]) -> String {
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let mut out = String::new();
    for finding in &*findings {
        out += &format!("{}: {finding}\n", severity_name(finding.severity));
    }
    let of = |severity| findings.iter().filter(|finding| finding.severity == severity).count();
    let counts = [
        text::count(of(Severity::Error), "error"),
        text::count(of(Severity::Warning), "warning"),
        text::count(of(Severity::Note), "note"),
    ];
    out + &counts.join(", ") + "\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_come_worst_first_and_are_counted() {
        let finding =
            |severity, message: &str| Finding { severity, ..Finding::unsearched(message.to_owned()) };
        let mut findings = [
            finding(Severity::Note, "a"),
            finding(Severity::Error, "b"),
            finding(Severity::Warning, "c"),
            finding(Severity::Note, "d"),
        ];
        assert_eq!(
            describe(&mut findings),
            "error: b\nwarning: c\nnote: a\nnote: d\n1 error, 1 warning, 2 notes\n"
        );
    }
}
