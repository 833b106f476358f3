use super::failure::Failure;
use super::lamps::{self, LampOptions};
use super::options::{EffectOptions, FrameOptions, PatchOptions, transports};
use super::{solve, text};
use crate::effects::{EffectPlan, EffectState};
use crate::solve::{SolveSettings, predicted, prepare};
use crate::transport::TransportKind;
use clap::Args;

/// Tell which effects a scene calls for, why, and what they cost
#[derive(Args, Debug)]
pub(super) struct Arguments {
    /// An OBJ file, or builtin:NAME
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
    let predicted = if prepared.scene.luminaires.is_empty() {
        String::new()
    } else {
        text::predicted(&predicted(&prepared)) + "\n"
    };
    text::print(&(counts + &predicted + &describe(&prepared.plan)))
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
