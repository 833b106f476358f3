//! The stage of a solve that lays out direct light.

use super::element_light::ElementLight;
use super::error::PipelineError;
use super::pipeline::{BALANCED, DirectTarget, ELEMENTS, Prepared, ROWS_OF_LAMPS, Run, SWEEPS, Stage};
use super::store::RowStore;
use crate::direct::Focus;
use crate::form_factors::Method;
use crate::solver::System;
use crate::transport::Transport;
use std::sync::atomic::Ordering;

impl Run<'_> {
    /// Direct light on elements; `None` where rows are computed by another method than the usual one, which is then
    /// to be seen as it is unless something shines that is no patch, and where there are no lamps. `rows` are those that
    /// there are so far: they tell how long the others will take.
    ///
    /// # Errors
    /// The run was ended.
    pub fn elements(
        &mut self,
        prepared: &Prepared,
        system: &System,
        rows: &RowStore,
    ) -> Result<Option<ElementLight>, PipelineError> {
        let mesh = &prepared.mesh;
        let by_rows = prepared.computer.sampling().method != Method::Lines
            && mesh.photometric.is_empty()
            && mesh.outdoors.is_none();
        if by_rows || system.lamps == 0 {
            return Ok(None);
        }
        let clock = self.clock();
        let n = prepared.mesh.patches.len();
        // The rows that come after it take as long as those of the lamps did, a row each.
        let known = rows.known();
        let per_row = if known > 0 { self.timings.rows / known as f64 } else { 0.0 };
        let rest = per_row * (n - known) as f64 * (1.0 + SWEEPS);
        let light =
            self.watched(Stage::Elements, (known, n), ([ROWS_OF_LAMPS, ELEMENTS], rest), |watch| {
                ElementLight::compute(prepared, prepared.direct, None, system, watch)
            })?;
        self.timings.elements = clock.seconds(self);
        Ok(Some(light))
    }

    /// Direct light anew on elements of another fineness, with most of them where somebody looks.
    ///
    /// # Errors
    /// The run was ended.
    pub fn finer_elements(
        &mut self,
        prepared: &Prepared,
        target: DirectTarget,
        focus: Option<Focus>,
        system: &System,
    ) -> Result<ElementLight, PipelineError> {
        let clock = self.clock();
        let n = prepared.mesh.patches.len();
        let light = self.watched(Stage::Elements, (n, n), ([0.0, BALANCED], 0.0), |watch| {
            ElementLight::compute(prepared, target, focus, system, watch)
        })?;
        self.timings.elements += clock.seconds(self);
        Ok(light)
    }

    /// Direct light of the hour with the edges of the sun's shadows, where it stands [at once](ElementLight::at_hour).
    ///
    /// # Errors
    /// The run was ended.
    pub fn shadows(
        &mut self,
        prepared: &Prepared,
        light: &ElementLight,
        system: &System,
    ) -> Result<ElementLight, PipelineError> {
        let n = prepared.mesh.patches.len();
        Ok(self.watched(Stage::Elements, (n, n), ([0.0, BALANCED], 0.0), |watch| {
            light.at_hour(prepared, system, false, watch)
        })?)
    }

    /// Direct light on elements, as patches take it over from them once the transport stands.
    ///
    /// # Errors
    /// The run was ended.
    pub fn settle(
        &mut self,
        prepared: &Prepared,
        elements: ElementLight,
        transport: &dyn Transport,
        system: &System,
    ) -> Result<ElementLight, PipelineError> {
        let clock = self.clock();
        let cancel = self.cancel;
        let settled = elements.settled(prepared, transport, system, &|| cancel.load(Ordering::Relaxed))?;
        self.timings.elements += clock.seconds(self);
        Ok(settled)
    }
}
