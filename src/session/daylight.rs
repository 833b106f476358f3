//! Another sky over the same scene: what that leaves standing, and what it lights anew.

use super::failure::Failure;
use super::wanted::Wanted;
use super::worker::Worker;
use crate::scene::{PlacedLamp, Scene};
use crate::solve::{Prepared, Stage, patch_reflectance, system};
use crate::solver::System;
use crate::watch::{Cancelled, Watch};
use std::sync::Arc;
use std::sync::atomic::Ordering;

impl Worker<'_> {
    /// The scene as read with the lamps and the daylight that are wanted.
    pub(super) fn other_scene(&self, wanted: &Wanted, read: &Arc<Scene>) -> Result<Arc<Scene>, Failure> {
        let placed: &[PlacedLamp] = wanted.lamps_of(read).unwrap_or(&read.placed);
        let daylight = wanted.daylight_of(read).map(|choice| choice.without_lamps());
        let own = read.outdoors.as_ref().map(|outdoors| outdoors.choice.without_lamps());
        let scene = match placed == read.placed.as_slice() {
            true => Arc::clone(read),
            false => Arc::new(read.with_placed(placed.to_vec())),
        };
        if daylight == own {
            return Ok(scene);
        }
        Ok(Arc::new(scene.with_daylight(wanted.daylight_of(read))?))
    }

    /// Puts the present scene under another sky: its mesh stays but for what shines from outside. Direct light comes anew,
    /// and the light of the patches by that, about; shown at once.
    ///
    /// A newer wish for yet another sky does not end it, so that a handle that is dragged is followed.
    pub(super) fn take_up_daylight(&mut self, wanted: &Wanted) -> Result<(), Failure> {
        let before = self.state.prepared.clone().ok_or(Failure::Cancelled)?;
        let read = self.state.read.clone().ok_or(Failure::Cancelled)?;
        let Some(choice) = wanted.daylight_of(&read) else { return Ok(()) };
        // 1. Nothing of the state changes before all is there.
        let prepared = before.under(choice)?;
        let scene = Arc::clone(&prepared.scene);
        let reflectance = patch_reflectance(&prepared.mesh, &|material| self.reflectance_of(material));
        let system = system(&prepared, &reflectance);
        let standing = self.element_light().filter(|light| light.serves(&system)).cloned();
        let lit = match &standing {
            Some(light) => {
                let shared = Arc::clone(&self.shared);
                let cancelled = || shared.cancel_direct.load(Ordering::Acquire);
                let mut nobody = |_| {};
                let mut watch = Watch::new(&cancelled, &mut nobody);
                let lit = light.at_hour(&prepared, &system, true, &mut watch);
                Some(Arc::new(lit.map_err(|Cancelled| Failure::Cancelled)?))
            }
            None => None,
        };
        // 2. Who holds an index into one of these scenes means the same in the others.
        self.state.alike.retain(|scene| scene.strong_count() > 0);
        self.state.alike.push(Arc::downgrade(&scene));
        (self.state.scene, self.state.prepared) = (Some(scene), Some(prepared.clone()));
        if let (Some(standing), Some(lit), Some(bases)) = (&standing, &lit, &self.state.bases) {
            self.state.bases = Some(Arc::new(lit.guess(standing, bases)));
        }
        let bases = self.state.bases.clone();
        if let Some(solution) = self.snapshot.solution_mut() {
            (solution.scene, solution.mesh) = (prepared.scene, prepared.mesh);
            solution.element_light = lit;
            solution.budget = None;
            if let Some(bases) = bases {
                solution.bases = bases;
            }
        }
        self.publish(Stage::Sweeping);
        Ok(())
    }

    /// What sky and sun make of this scene in the end, once direct light stands: the light of all lamps stays.
    pub(super) fn settle_daylight(&mut self, prepared: &Prepared, system: &System) -> Result<usize, Failure> {
        let transport = self.state.transport.clone().ok_or(Failure::Cancelled)?;
        let columns: Vec<usize> =
            (0..system.columns()).filter(|&column| system.is_outdoors(column)).collect();
        let mut done = 0;
        // First by what was seen at once, then with all edges of shadows and as light leaves patches.
        for is_last in [false, true] {
            if is_last {
                self.find_shadows(prepared, system)?;
                self.settle_elements(prepared, system)?;
            }
            let given = self.element_light().map(|elements| &elements.given);
            let lit = system.clone().with_direct(given);
            let (start, tolerance) = (self.state.bases.clone(), self.state.settings.tolerance);
            let (bases, sweeps) = self.with_run(|run| {
                let start = (start.as_deref(), Some(columns.as_slice()));
                run.sweeps_of(prepared, transport.as_ref(), &lit, start, tolerance)
            })?;
            done += sweeps.len();
            let bases = Arc::new(bases);
            self.state.bases = Some(Arc::clone(&bases));
            if let Some(solution) = self.snapshot.solution_mut() {
                (solution.bases, solution.sweeps) = (bases, sweeps);
            }
        }
        Ok(done)
    }

    /// Lays out the direct light of the sun where it was seen by a few rays.
    pub(super) fn find_shadows(&mut self, prepared: &Prepared, system: &System) -> Result<(), Failure> {
        let Some(standing) = self.element_light().cloned() else { return Ok(()) };
        let lit = self.with_run(|run| run.shadows(prepared, &standing, system))?;
        // Shown with what patches make of it.
        let bases = self.state.bases.as_deref().map(|bases| lit.guess(&standing, bases)).map(Arc::new);
        self.state.bases.clone_from(&bases);
        if let (Some(solution), Some(bases)) = (self.snapshot.solution_mut(), bases) {
            (solution.element_light, solution.bases) = (Some(Arc::new(lit)), bases);
        }
        Ok(())
    }
}
