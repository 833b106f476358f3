use crate::form_factors::Row;
use crate::solver::{LightBases, Refiner, Shooter, System};

/// What the scene is lit by while rows arrive.
pub(super) enum Arriving {
    /// From dark: each row passes on what its patch has.
    Shot(Shooter),
    /// From the light of an earlier solve: each row gathers for its patch.
    Refined(Refiner),
}

impl Arriving {
    /// Refines the light that is `standing`, if it is that of this system.
    pub(super) fn new(system: &System, standing: Option<LightBases>) -> Self {
        match standing.and_then(|light| Refiner::new(system, light)) {
            Some(refiner) => Self::Refined(refiner),
            None => Self::Shot(Shooter::new(system)),
        }
    }

    /// The patches whose rows are to come next.
    pub(super) fn brightest(&mut self, system: &System, count: usize) -> Vec<u32> {
        match self {
            Self::Shot(shooter) => shooter.brightest(system, count),
            Self::Refined(refiner) => refiner.brightest(count),
        }
    }

    /// The row of a patch is known, before it is taken.
    pub(super) fn see(&mut self, system: &System, patch: u32, row_sum: f64) {
        if let Self::Shot(shooter) = self {
            shooter.see(system, patch, row_sum);
        }
    }

    /// The row of a patch has come.
    pub(super) fn take(&mut self, system: &System, patch: u32, row: &Row) {
        match self {
            Self::Shot(shooter) => shooter.shoot(system, patch, row),
            Self::Refined(refiner) => refiner.gather(system, patch, row),
        }
    }

    /// What has not been passed on, where the scene was dark.
    pub(super) fn unshot(&self) -> Option<LightBases> {
        match self {
            Self::Shot(shooter) => Some(shooter.unshot()),
            Self::Refined(_) => None,
        }
    }

    /// The picture so far: with what is still to be passed on as if it were spread evenly.
    pub(super) fn picture(&self, system: &System) -> LightBases {
        match self {
            Self::Shot(shooter) => shooter.picture(system),
            Self::Refined(refiner) => refiner.bases().clone(),
        }
    }

    /// What has arrived so far.
    pub(super) fn bases(&self) -> LightBases {
        match self {
            Self::Shot(shooter) => shooter.bases(),
            Self::Refined(refiner) => refiner.bases().clone(),
        }
    }
}
