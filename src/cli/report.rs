use super::plan::state_name;
use crate::export::{
    EffectReport, ElementReport, FindingReport, FormFactorReport, LampReport, MaterialReport, MeshReport,
    PowerReport, Report, SceneReport, SettingsReport, SweepLine, TimingReport, peak_memory_bytes,
};
use crate::mesh::{PatchMesh, PatchTarget};
use crate::scene::{Lighting, Scene, Severity};
use crate::solve::Solution;
use crate::solver::{PatchLight, patch_emission, photometric_power};

/// Seconds that the pipeline does not measure itself.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct OwnTimings {
    /// Reading the model.
    pub(super) load: f64,
    /// From bases to corners.
    pub(super) display: f64,
    /// Pictures, tables and points.
    pub(super) outputs: f64,
    /// The whole command up to the report.
    pub(super) total: f64,
}

/// Everything that a solve tells, as plain values.
pub(super) fn report(
    solved: &Solution,
    lighting: &Lighting,
    light: &PatchLight,
    own: OwnTimings,
    outputs: Vec<String>,
) -> Report {
    let (statistics, settings) = (&solved.mesh.statistics, &solved.settings);
    let last = solved.sweeps.last();
    let timings = &solved.timings;
    Report {
        version: env!("CARGO_PKG_VERSION"),
        scene: scene(&solved.scene, lighting),
        settings: SettingsReport {
            finer_where_wrong: settings.refinement.is_some(),
            patches: match settings.patches {
                PatchTarget::Auto => "auto".into(),
                PatchTarget::Size(size) => format!("{size} m"),
                PatchTarget::Count(count) => format!("{count} patches"),
                PatchTarget::AsGiven => "as given".into(),
            },
            method: settings.method.name(),
            resolution: settings.resolution.unwrap_or_else(|| settings.method.default_resolution()),
            receiving_points: settings.points.name(),
            tolerance: settings.tolerance,
            threads: rayon::current_num_threads(),
        },
        mesh: MeshReport {
            patches: statistics.patches,
            emitters: statistics.emitters,
            regions: statistics.regions,
            dark_sides: statistics.dark_sides,
            dropped: statistics.dropped,
            area_m2: statistics.area,
            smallest_area_m2: statistics.smallest_area,
            largest_area_m2: statistics.largest_area,
            median_aspect: statistics.median_aspect,
            worst_aspect: statistics.worst_aspect,
            patch_size_m: statistics.patch_size,
        },
        form_factors: FormFactorReport {
            transport: solved.transport.as_ref().map_or("none", |t| t.kind().name()),
            entries: solved.transport.as_ref().map_or(0, |t| t.entries()),
            bytes: solved.transport.as_ref().map_or(0, |t| t.bytes()),
            close_pairs: solved.assembled().close_pairs,
            worst_closure: solved.assembled().worst_closure,
            mean_reciprocity: solved.assembled().mean_reciprocity,
            balance_passes: solved.assembled().passes,
            imbalance: solved.assembled().imbalance,
            kept: solved.assembled().kept,
            joined_error: solved.assembled().joined_error,
            mended_rows: solved.assembled().mended,
        },
        effects: solved
            .plan
            .decisions
            .iter()
            .map(|decision| EffectReport {
                effect: decision.effect.name(),
                state: state_name(decision.state),
                reason: decision.reason.clone(),
                evidence: decision.evidence.clone(),
                predicted_cost: decision.predicted_cost.clone(),
                measured_seconds: decision.measured.map(|time| time.as_secs_f64()),
            })
            .collect(),
        elements: solved.element_light.as_deref().map(|light| ElementReport {
            count: light.elements.leaves().count(),
            corners: light.elements.corners.len(),
            expected_error: light.elements.expected_error,
            scaling: light.scaling.iter().fold([f64::INFINITY, 0.0], |[low, high], &factor| {
                [low.min(f64::from(factor)), high.max(f64::from(factor))]
            }),
        }),
        timings: TimingReport {
            load: own.load,
            mesh: timings.mesh,
            plan: timings.plan,
            first_light: timings.first_light,
            elements: timings.elements,
            rows: timings.rows,
            balance: timings.balance,
            sweeps: timings.sweeps,
            display: own.display,
            outputs: own.outputs,
            total: own.total,
        },
        sweeps: solved
            .sweeps
            .iter()
            .map(|sweep| SweepLine {
                sweep: sweep.sweep,
                residual: sweep.residual,
                error_bound: sweep.error_bound,
                seconds: sweep.seconds,
            })
            .collect(),
        residual: last.map(|sweep| sweep.residual),
        error_bound: last.map(|sweep| sweep.error_bound),
        power: last.map(|sweep| PowerReport {
            emitted: sweep.emitted,
            absorbed: sweep.absorbed,
            escaped: Some(sweep.escaped),
        }),
        power_as_switched: power(&solved.mesh, lighting, light, &solved.reflectance),
        accuracy: None,
        points: None,
        work_planes: Vec::new(),
        peak_memory_bytes: peak_memory_bytes(),
        outputs,
    }
}

fn scene(scene: &Scene, lighting: &Lighting) -> SceneReport {
    SceneReport {
        name: scene.name.clone(),
        source: scene.source.to_string(),
        unit: scene.unit.symbol(),
        extent_m: scene.extent().main.size().to_array(),
        surfaces: scene.surfaces.len(),
        objects: scene.objects.len(),
        textures: scene.textures.len(),
        materials: scene
            .materials
            .iter()
            .map(|material| MaterialReport { name: material.name.clone(), reflectance: material.reflectance })
            .collect(),
        luminaires: scene
            .luminaires
            .iter()
            .zip(&lighting.lamps)
            .map(|(luminaire, state)| LampReport {
                name: luminaire.name.clone(),
                area_m2: luminaire.area,
                on: state.on,
                dimmer: state.dimmer,
                exitance: state.exitance,
            })
            .collect(),
        findings: scene
            .findings
            .iter()
            .map(|finding| FindingReport {
                severity: severity_name(finding.severity),
                message: finding.message.clone(),
                count: finding.count,
            })
            .collect(),
    }
}

/// Sum of E A and of (1 - rho) H A over patches and bands, W.
fn power(mesh: &PatchMesh, lighting: &Lighting, light: &PatchLight, reflectance: &[[f32; 3]]) -> PowerReport {
    let outdoors = light.detail.as_ref().map_or(0.0, |detail| detail.outdoors);
    let (mut emitted, mut absorbed) = (photometric_power(mesh, lighting) + outdoors, 0.0);
    for ((patch, irradiance), rho) in mesh.patches.iter().zip(&light.irradiance).zip(reflectance) {
        let shines = patch.luminaire.is_some_and(|lamp| !mesh.is_photometric(lamp));
        let exitance = if shines { patch_emission(patch, lighting) } else { [0.0; 3] };
        for band in 0..3 {
            emitted += patch.area * f64::from(exitance[band]);
            absorbed += patch.area * f64::from(irradiance[band]) * (1.0 - f64::from(rho[band]));
        }
    }
    PowerReport { emitted, absorbed, escaped: None }
}

/// How a severity reads.
pub(super) fn severity_name(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    }
}
