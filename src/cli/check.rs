use super::failure::Failure;
use super::report::severity_name;
use super::text;
use crate::scene::{self, Finding, SceneSource, Severity, Summary};
use clap::Args;

/// Tell what a file holds and what is wrong with it
///
/// Exits with 1 where a part of the model had to be left out.
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// An OBJ file, or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let scene = scene::load(&SceneSource::from(arguments.scene.as_str()))?;
    let mut findings = scene.findings.clone();
    findings.extend(scene::check(&scene));
    text::print(&format!("{}{}", Summary::of(&scene), describe(&mut findings)))?;
    if findings.iter().any(|finding| finding.severity == Severity::Error) {
        return Err(Failure::Told);
    }
    Ok(())
}

/// The findings, worst first, and a line that counts them.
fn describe(findings: &mut [Finding]) -> String {
    findings.sort_by_key(|finding| std::cmp::Reverse(finding.severity));
    let mut out = String::new();
    for finding in &*findings {
        out += &format!("{}: {}\n", severity_name(finding.severity), finding.message);
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
        let finding = |severity, message: &str| Finding { severity, message: message.into(), count: 1 };
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
