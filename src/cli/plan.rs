use super::failure::Failure;
use super::lamps::{self, LampOptions};
use super::options::{EffectOptions, FrameOptions, PatchOptions, transports};
use super::{budget, solve, text};
use crate::effects::{EffectPlan, EffectState};
use crate::solve::{SolveSettings, predicted, prepare};
use crate::study::{Forecast, Outlook};
use crate::transport::TransportKind;
use clap::Args;

/// Errors whose cost is told.
const ERRORS: [f64; 3] = [0.1, 0.03, 0.01];

/// Tell which effects a scene calls for and why, and what solves of it cost
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// A model (OBJ, glTF, GLB, PLY), or builtin:NAME
    #[arg(value_name = "SCENE")]
    scene: String,
    #[command(flatten)]
    frame: FrameOptions,
    #[command(flatten)]
    lamps: LampOptions,
    #[command(flatten)]
    patches: PatchOptions,
    /// What carries light between patches: a matrix of all pairs, or rows that end at nodes of a tree over patches,
    /// which take less memory [default: auto: the matrix where it is small]
    #[arg(long, value_name = "KIND", value_parser = transports())]
    transport: Option<TransportKind>,
    #[command(flatten)]
    effects: EffectOptions,
}

pub(super) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let effects = arguments.effects.choices()?;
    let scene = solve::load(&arguments.scene, &arguments.frame, arguments.lamps)?;
    lamps::tell_darkness(&scene, &scene.lighting());
    let patches = arguments.patches.target(scene.unit);
    let transport = arguments.transport.unwrap_or_default();
    let settings = SolveSettings { patches, effects, transport, ..SolveSettings::default() };
    let prepared = prepare(scene, &settings)?;
    let statistics = &prepared.mesh.statistics;
    let excess: String = [statistics.excess(), statistics.clustering()]
        .into_iter()
        .flatten()
        .map(|told| told + "\n")
        .collect();
    let counts = format!(
        "{}: {}, {}\n{excess}\n",
        prepared.scene.name,
        text::count(prepared.scene.surfaces.len(), "surface"),
        text::patches(prepared.mesh.patches.len()),
    );
    if prepared.scene.luminaires.is_empty() {
        return text::print(&(counts + &describe(&prepared.plan)));
    }
    let transport = text::predicted(&predicted(&prepared));
    let costs = budget::outlook(&prepared.scene, &settings.effects)?
        .map_or_else(String::new, |outlook| costs(&outlook, prepared.mesh.patches.len()));
    text::print(&(counts + &transport + "\n" + &costs + &describe(&prepared.plan)))
}

/// What a solve of so many patches at these settings takes, and the last one on the way to each error.
fn costs(outlook: &Outlook, patches: usize) -> String {
    let head = ["", "patches", "elements", "seconds", "memory", "error"].map(str::to_owned).to_vec();
    let about = |value: f64| text::thousands(rounded(value) as usize);
    let row = |name: String, of: &Forecast| {
        let memory = format!("{} MB", about(1e3 * of.gigabytes));
        let error = format!("{} %", two_digits(100.0 * of.error));
        let seconds = two_digits(of.seconds);
        vec![name, about(of.patches), about(of.elements), seconds, memory, error]
    };
    let mut rows = vec![head, row("as asked for".to_owned(), &outlook.by_default(patches))];
    for asked in ERRORS {
        let name = format!("--error {:.0}%", 100.0 * asked);
        rows.push(match outlook.to(asked) {
            Some(of) => row(name, &of),
            None => {
                let memory = format!("over {} MB", about(1e3 * outlook.memory()));
                let unknown = || "-".to_owned();
                vec![name, unknown(), unknown(), unknown(), memory, unknown()]
            }
        });
    }
    format!(
        "{}predicted from a solve of {} and its check ({}); an error is reached by steps, which take about as long again\n\n",
        text::table(&rows),
        text::patches(outlook.measured.fineness.patches as usize),
        text::seconds(outlook.seconds),
    )
}

/// The number with two digits: predictions tell no more.
fn rounded(value: f64) -> f64 {
    let digit = 10.0_f64.powf(value.abs().max(f64::MIN_POSITIVE).log10().floor() - 1.0);
    (value / digit).round() * digit
}

fn two_digits(value: f64) -> String {
    let text = text::significant(rounded(value));
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_owned() } else { text }
}

/// Two or three lines an effect: its state, why, on what evidence and at what cost.
fn describe(plan: &EffectPlan) -> String {
    let width = plan.decisions.iter().map(|d| d.effect.name().len()).max().unwrap_or(0);
    let mut out = String::new();
    for decision in &plan.decisions {
        let name = decision.effect.name();
        let indent = " ".repeat(width + 2);
        out += &format!("{name:width$}  {}\n{indent}{}\n", state_name(decision.state), decision.reason);
        let facts = [("evidence", &decision.evidence), ("cost", &decision.predicted_cost)];
        for (what, fact) in facts.into_iter().filter(|(_, fact)| !fact.is_empty()) {
            out += &format!("{indent}{what}: {fact}\n");
        }
    }
    out
}

/// How a state reads in a listing and in the report.
pub(super) fn state_name(state: EffectState) -> &'static str {
    match state {
        EffectState::On => "on",
        EffectState::NotCalledFor => "off: not called for",
        EffectState::OnByChoice => "on by choice",
        EffectState::OffByChoice => "off by choice",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{Decision, Effect};

    #[test]
    fn predictions_have_two_digits() {
        let cases = [(37.4, "37"), (5.42, "5.4"), (0.0912, "0.091"), (131.0, "130"), (0.3, "0.3")];
        for (value, told) in cases {
            assert_eq!(two_digits(value), told);
        }
    }

    #[test]
    fn a_decision_shows_its_reason_and_evidence() {
        let decision = Decision {
            effect: Effect::Visibility,
            state: EffectState::NotCalledFor,
            reason: "The room is convex and empty.".into(),
            evidence: "0 of 6 regions stand in front of another".into(),
            predicted_cost: String::new(),
            measured: None,
        };
        let text = describe(&EffectPlan { decisions: vec![decision] });
        assert_eq!(
            text,
            "visibility  off: not called for\n            The room is convex and empty.\n            \
             evidence: 0 of 6 regions stand in front of another\n"
        );
    }
}
