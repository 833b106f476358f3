use super::balance::{Aggregates, PowerBalance};
use super::{LightBases, SweepReport, System, direct_bases};
use crate::mesh::PatchMesh;
use crate::transport::{Cancelled, LANES, Lanes, Transport};
use crate::watch;
use rayon::prelude::*;

/// How often a sweep reads the rows for so many columns.
pub fn columns_read(columns: usize) -> usize {
    columns.div_ceil(LANES)
}

/// Iterates R = rho (D + F R) for all columns from any start: D is the light straight from the lamps, F R what
/// surfaces pass on, and R what they reflect of both.
///
/// Groups of columns are independent of each other and run in parallel, each strictly in the order
/// of the patches: the same bits whatever the thread count.
#[derive(Clone, Debug)]
pub struct GaussSeidel {
    groups: Vec<Group>,
    /// What it started from: columns that no group has stay as they are there.
    start: LightBases,
    aggregates: Aggregates,
    balance: PowerBalance,
    sweep: u32,
    row_sums: Vec<f64>,
    /// Largest rho_i sum_j F_ij.
    spectral_bound: f64,
    started: std::time::Instant,
}

/// Up to [`LANES`] columns.
#[derive(Clone, Debug)]
struct Group {
    columns: Vec<usize>,
    /// D.
    direct: Vec<Lanes>,
    /// R.
    radiosity: Vec<Lanes>,
    /// F R.
    irradiance: Vec<Lanes>,
    residual: Vec<Lanes>,
    /// The state before the last sweep, once there is one.
    before: Option<State>,
    /// Largest residual of any column over its largest radiosity.
    error: f64,
    /// Sweeps to come without a correction: the last one did not help.
    plain: u32,
}

/// A sweep with its correction that leaves more than this of the residual is followed by so many without. Where some of
/// what an aggregate holds can hardly follow, corrections and sweeps may undo each other for ever; plain sweeps converge
/// whatever the scene.
const STALLED: f64 = 0.8;
const PLAIN: u32 = 8;

/// Radiosities with what follows from them.
#[derive(Clone, Debug)]
struct State {
    radiosity: Vec<Lanes>,
    irradiance: Vec<Lanes>,
    residual: Vec<Lanes>,
}

impl GaussSeidel {
    /// Starts from the irradiance in `start` if it has as many patches and columns, else from direct light alone.
    /// Where the system has no direct light, it is gathered from what the lamps emit.
    pub fn new(
        mesh: &PatchMesh,
        transport: &dyn Transport,
        system: &System,
        start: Option<&LightBases>,
    ) -> Self {
        match Self::new_unless(mesh, transport, system, (start, None), &|| false) {
            Ok(solver) => solver,
            Err(watch::Cancelled) => unreachable!("nobody ends it"),
        }
    }

    /// As [`Self::new`], of some `columns` alone where these are named; asks every few milliseconds whether to end.
    ///
    /// # Errors
    /// It was `cancelled`.
    pub fn new_unless(
        mesh: &PatchMesh,
        transport: &dyn Transport,
        system: &System,
        (start, columns): (Option<&LightBases>, Option<&[usize]>),
        cancelled: &(dyn Fn() -> bool + Sync),
    ) -> Result<Self, watch::Cancelled> {
        let n = system.patches();
        let start = start.filter(|s| s.patches == n && s.lamps == system.lamps && s.bands == system.bands);
        let columns: Vec<usize> = match columns {
            Some(columns) => columns.iter().copied().filter(|&c| c < system.columns()).collect(),
            None => (0..system.columns()).collect(),
        };
        let gathered;
        let direct = match &system.direct {
            Some(direct) => direct,
            None => {
                gathered = direct_bases(transport, system, cancelled)?;
                &gathered
            }
        };
        let start = start.unwrap_or(direct);
        let groups = columns
            .chunks(LANES)
            .map(|columns| {
                let stride = system.columns();
                let of = |light: &LightBases, i: usize| {
                    let mut lanes = [0.0; LANES];
                    for (lane, &c) in lanes.iter_mut().zip(columns) {
                        *lane = f64::from(light.values[i * light.lamps * light.bands + c]);
                    }
                    lanes
                };
                let radiosity = (0..n)
                    .map(|i| {
                        let mut b = [0.0; LANES];
                        for (b, &c) in b.iter_mut().zip(columns) {
                            *b = system.leaving(i, c, |j| f64::from(start.values[j * stride + c]));
                        }
                        b
                    })
                    .collect();
                let zeros = vec![[0.0; LANES]; n];
                Group {
                    columns: columns.to_vec(),
                    direct: (0..n).map(|i| of(direct, i)).collect(),
                    radiosity,
                    irradiance: zeros.clone(),
                    residual: zeros,
                    before: None,
                    error: f64::INFINITY,
                    plain: 0,
                }
            })
            .collect();
        let aggregates = Aggregates::new(mesh, transport, cancelled)?;
        let balance = PowerBalance::new(transport, system, &aggregates, cancelled)?;
        let row_sums: Vec<f64> = (0..n).into_par_iter().map(|i| transport.row_sum(i)).collect();
        let spectral_bound = (0..n).map(|i| row_sums[i] * system.greatest_share(i)).fold(0.0, f64::max);
        let kept = if columns.len() < system.columns() { start.clone() } else { LightBases::default() };
        let mut solver = Self {
            groups,
            start: kept,
            aggregates,
            balance,
            row_sums,
            sweep: 0,
            spectral_bound,
            started: std::time::Instant::now(),
        };
        solver.groups.par_iter_mut().for_each(|group| group.measure(transport, system, cancelled));
        if cancelled() { Err(watch::Cancelled) } else { Ok(solver) }
    }

    /// One correction and one sweep; polls `cancelled` every few rows. `None` if cancelled, with the
    /// state somewhere on the way, still usable.
    pub fn sweep(
        &mut self,
        transport: &dyn Transport,
        system: &System,
        cancelled: Cancelled,
    ) -> Option<SweepReport> {
        let (aggregates, balance) = (&self.aggregates, &self.balance);
        self.groups.par_iter_mut().for_each(|group| {
            let corrects = group.plain == 0;
            if corrects {
                group.correct(transport, system, aggregates, balance);
            }
            group.relax(transport, system, cancelled);
            group.measure(transport, system, cancelled);
            // What was cut short has no residual to go by.
            if !cancelled() {
                group.combine(system);
                group.judge(corrects);
            }
        });
        if cancelled() {
            return None;
        }
        self.sweep += 1;
        Some(self.report(system))
    }

    /// Where the iteration stands now.
    pub fn report(&self, system: &System) -> SweepReport {
        let mut report = SweepReport {
            sweep: self.sweep,
            seconds: self.started.elapsed().as_secs_f64(),
            ..SweepReport::default()
        };
        for group in &self.groups {
            for (lane, &column) in group.columns.iter().enumerate() {
                // What is reflected, not what a lamp emits: beside a lamp of a million W/m² all light of
                // a room is small.
                let largest = group.radiosity.iter().map(|b| b[lane].abs()).fold(0.0, f64::max);
                let residual = group.residual.iter().map(|r| r[lane].abs()).fold(0.0, f64::max);
                if largest > 0.0 {
                    report.residual = report.residual.max(residual / largest);
                }
                let output = system.output[column];
                // One grey band stands for three.
                let copies = if system.bands == 1 { 3.0 } else { 1.0 };
                // What shines by photometry arrives at patches or leaves through openings.
                let area = system.photometric_area(column);
                report.emitted += output * copies * area;
                if area > 0.0 || system.is_outdoors(column) {
                    let arrived: f64 = system
                        .areas
                        .iter()
                        .zip(&group.direct)
                        .map(|(area, direct)| area * direct[lane])
                        .sum();
                    match system.is_outdoors(column) {
                        true => report.emitted += output * copies * arrived,
                        false => report.escaped += output * copies * (area - arrived).max(0.0),
                    }
                }
                for i in 0..system.patches() {
                    let power = system.areas[i] * output * copies;
                    let emitted = system.exitance(i, column);
                    let arriving = |i: usize| group.direct[i][lane] + group.irradiance[i][lane];
                    report.emitted += power * emitted;
                    let passed = system.passed(i, column, arriving);
                    report.absorbed += power * ((1.0 - system.rho(i, column)) * arriving(i) - passed);
                    let leaving = emitted + group.radiosity[i][lane];
                    report.escaped += power * (1.0 - self.row_sums[i]) * leaving;
                }
            }
        }
        report.error_bound = report.residual / (1.0 - self.spectral_bound).max(1e-12);
        report
    }

    /// The irradiance of every patch and column as it stands.
    pub fn bases(&self, system: &System) -> LightBases {
        let stride = system.columns();
        let mut values = self.start.values.clone();
        values.resize(system.patches() * stride, 0.0);
        for group in &self.groups {
            for (i, (passed_on, direct)) in group.irradiance.iter().zip(&group.direct).enumerate() {
                for (lane, &column) in group.columns.iter().enumerate() {
                    values[i * stride + column] = (direct[lane] + passed_on[lane]) as f32;
                }
            }
        }
        LightBases { patches: system.patches(), lamps: system.lamps, bands: system.bands, values }
    }
}

impl Group {
    /// Adds the power-balance correction to the radiosities.
    fn correct(
        &mut self,
        transport: &dyn Transport,
        system: &System,
        aggregates: &Aggregates,
        balance: &PowerBalance,
    ) {
        for (lane, &column) in self.columns.iter().enumerate() {
            let mut power = vec![0.0; aggregates.count];
            for (i, r) in self.residual.iter().enumerate() {
                power[aggregates.of_patch[i] as usize] += system.areas[i] * r[lane];
            }
            balance.correct(column % system.bands, &mut power);
            for (i, b) in self.radiosity.iter_mut().enumerate() {
                // A black patch reflects nothing; the correction is for what is reflected.
                if system.greatest_share(i) > 0.0 && transport.sees(i) {
                    b[lane] = (b[lane] + power[aggregates.of_patch[i] as usize]).max(0.0);
                }
            }
        }
    }

    /// One Gauss-Seidel pass over the patches in order.
    fn relax(&mut self, transport: &dyn Transport, system: &System, cancelled: Cancelled) {
        let (columns, direct, irradiance) = (&self.columns, &self.direct, &mut self.irradiance);
        transport.relax(&mut self.radiosity, cancelled, &mut |i, others, own| {
            let mut radiosity = [0.0; LANES];
            for (lane, &column) in columns.iter().enumerate() {
                // What a patch keeps for itself is solved for, not iterated. Its far side has what it had last.
                let rho = system.rho(i, column);
                let passed = system.passed(i, column, |j| direct[j][lane] + irradiance[j][lane]);
                radiosity[lane] = (rho * (direct[i][lane] + others[lane]) + passed) / (1.0 - rho * own);
            }
            for lane in 0..LANES {
                irradiance[i][lane] = others[lane] + own * radiosity[lane];
            }
            radiosity
        });
    }

    /// Notes how far the sweep has come, and whether the next ones do better without a correction.
    fn judge(&mut self, corrected: bool) {
        let mut error: f64 = 0.0;
        for lane in 0..self.columns.len() {
            let largest = |of: &[Lanes]| of.iter().map(|value| value[lane].abs()).fold(0.0, f64::max);
            let radiosity = largest(&self.radiosity);
            if radiosity > 0.0 {
                error = error.max(largest(&self.residual) / radiosity);
            }
        }
        self.plain = match corrected {
            true if error > STALLED * self.error => PLAIN,
            true => 0,
            false => self.plain.saturating_sub(1),
        };
        self.error = error;
    }

    /// Mixes the last two states, column by column, so that the residual becomes least: what a sweep leaves
    /// of the slowest errors it leaves with much the same shape (Anderson 1965, of depth one).
    fn combine(&mut self, system: &System) {
        let now = State {
            radiosity: self.radiosity.clone(),
            irradiance: self.irradiance.clone(),
            residual: self.residual.clone(),
        };
        let Some(before) = self.before.replace(now) else { return };
        let n = system.patches();
        for lane in 0..self.columns.len() {
            let (mut along, mut square) = (0.0, 0.0);
            for i in 0..n {
                let change = self.residual[i][lane] - before.residual[i][lane];
                along += system.areas[i] * self.residual[i][lane] * change;
                square += system.areas[i] * change * change;
            }
            let step = if square > 0.0 { -along / square } else { 0.0 };
            let mixed = |now: f64, before: f64| now + step * (now - before);
            // Light below nothing would be worse than one sweep more.
            let fits = (0..n).all(|i| mixed(self.radiosity[i][lane], before.radiosity[i][lane]) >= 0.0);
            if !step.is_finite() || !fits {
                continue;
            }
            for i in 0..n {
                let (b, h, r) = (
                    &mut self.radiosity[i][lane],
                    &mut self.irradiance[i][lane],
                    &mut self.residual[i][lane],
                );
                *b = mixed(*b, before.radiosity[i][lane]);
                *h = mixed(*h, before.irradiance[i][lane]);
                *r = mixed(*r, before.residual[i][lane]);
            }
        }
    }

    /// Irradiance and residual of the radiosities as they stand.
    fn measure(&mut self, transport: &dyn Transport, system: &System, cancelled: Cancelled) {
        let (columns, radiosity) = (&self.columns, &self.radiosity);
        transport.gather(0..radiosity.len(), radiosity, &mut self.irradiance, cancelled);
        if cancelled() {
            return;
        }
        let (direct, irradiance) = (&self.direct, &self.irradiance);
        for (i, residual) in self.residual.iter_mut().enumerate() {
            for (lane, &column) in columns.iter().enumerate() {
                let arriving = |j: usize| direct[j][lane] + irradiance[j][lane];
                residual[lane] = system.leaving(i, column, arriving) - radiosity[i][lane];
            }
        }
    }
}
