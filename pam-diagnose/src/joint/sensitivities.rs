//! Residuals and sensitivities of one recording.

use super::divergence::diverges;
use super::parts::{Parts, magnitudes};
use super::system::{JointSystem, is_absent};
use crate::error::DiagnoseError;
use crate::fit::{FittedParameter, Hypothesis, Sensitivities, fitted_outputs, row_means};
use crate::search::Candidates;
use pam_autodiff::Chunk;
use pam_core::{Scalar, parallel};
use pam_effects::effects::{AnyEffect, EffectScalar, NARROW, WIDE, WIDTH};
use pam_effects::simulation::{Nuisances, SimulationScalar, Trajectory, sensed, simulate_until};
use std::ops::Range;

/// Shared and local nuisances that the simulation is differentiated by, beside the shares of learned effects. The lead
/// follows from the time series, and the offsets are added to the result.
const SIMULATED: usize = 7;

/// One recording under a hypothesis.
#[derive(Clone, Copy)]
pub(super) struct Experiment<'s> {
    pub(super) system: &'s JointSystem<'s>,
    pub(super) hypothesis: &'s Hypothesis,
    pub(super) local: &'s [f64],
    pub(super) index: usize,
}

impl Experiment<'_> {
    /// Residuals and sensitivities by all unknowns in a window.
    pub(super) fn sensitivities(
        &self,
        window: &Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let parameters = self.hypothesis.parameters(self.system).len();
        let mut all =
            self.differentiated(window, parameters + SIMULATED + self.system.learned.len())?;
        let t = self.system.trials[self.index];
        let points = self.system.points_per_row();
        let share = t.record.sample_s / t.record.step_s;
        let by_slope =
            || all.simulated.iter().map(|c| by_time(c, window.clone(), share, points)).collect();
        let lead = self.lead_of_delay(&all.columns).unwrap_or_else(by_slope);
        all.columns.insert(parameters + JointSystem::LEAD, lead);
        let channels = all.simulated.len();
        for i in 0..self.local[4..].len() {
            let mut unit = vec![Vec::new(); channels];
            unit[1 + i] = vec![1.0; window.len() / points];
            all.columns.push(unit);
        }
        Ok(Sensitivities { residuals: self.residuals(&all, window), columns: all.columns })
    }

    /// Residuals and sensitivities by the parameters alone.
    pub(super) fn of_parameters(
        &self,
        window: &Range<usize>,
    ) -> Result<Sensitivities, DiagnoseError> {
        let all = self.differentiated(window, self.hypothesis.parameters(self.system).len())?;
        Ok(Sensitivities { residuals: self.residuals(&all, window), columns: all.columns })
    }

    /// The sensitivity to the lead, derived from that to an actuation delay that acts throughout; `None` without one. Both shift the same
    /// force in time, so the data cannot separate them. Numerical differences between two columns computed independently would suggest
    /// that they can.
    fn lead_of_delay(&self, columns: &[Vec<Vec<f64>>]) -> Option<Vec<Vec<f64>>> {
        let slope_of = |p: &FittedParameter| -> Option<f64> {
            let member = &self.hypothesis.members[p.member];
            let effect = self.system.effect(member.candidate);
            if !effect.hooks().delay || member.schedule.is_some() {
                return None;
            }
            let mut seeded: Vec<Chunk<NARROW>> =
                member.own().iter().copied().map(Chunk::constant).collect();
            seeded[p.value] = Chunk::variable(member.values[p.value], 0);
            let delay_s = Chunk::hooks(effect).delay_s(&seeded, 0.0);
            let by_coordinate = if p.info.logarithmic { member.values[p.value] } else { 1.0 };
            Some(delay_s.derivatives[0] * by_coordinate).filter(|slope| *slope != 0.0)
        };
        let parameters = self.hypothesis.parameters(self.system);
        let (k, slope_s) =
            parameters.iter().enumerate().find_map(|(k, p)| Some((k, slope_of(p)?)))?;
        let by_lead = -self.system.trials[self.index].record.sample_s / slope_s;
        let scaled = |channel: &Vec<f64>| channel.iter().map(|v| by_lead * v).collect();
        Some(columns[k].iter().map(scaled).collect())
    }

    fn residuals(&self, all: &Differentiated, window: &Range<usize>) -> Vec<Vec<f64>> {
        let (system, record) = (self.system, &self.system.trials[self.index].record);
        let points = system.points_per_row();
        let channels = fitted_outputs(system).zip(&all.simulated);
        let mut residuals: Vec<Vec<f64>> = channels
            .map(|((c, _), y)| row_means(&record.measured[c], y, window.clone(), points))
            .collect();
        for (i, offset) in self.local[4..].iter().enumerate() {
            residuals[1 + i].iter_mut().for_each(|r| *r -= offset);
        }
        residuals
    }

    /// The simulated channels, differentiated by the first `count` of parameters and simulated nuisances.
    fn differentiated(
        &self,
        window: &Range<usize>,
        count: usize,
    ) -> Result<Differentiated, DiagnoseError> {
        let mut all =
            Differentiated { simulated: Vec::new(), columns: Vec::with_capacity(count + 3) };
        let absent = self.absent();
        let active = count - absent.len();
        let (mut first, mut passes) = (0, Vec::new());
        while first < active.max(1) {
            let left = active - first;
            let width = if left > 2 * WIDTH {
                WIDE
            } else if left > NARROW {
                WIDTH
            } else {
                NARROW
            };
            passes.push((width, first..(first + width).min(active)));
            first += width;
        }
        let found = parallel::map_each(passes, |(width, some)| match width {
            WIDE => self.pass::<WIDE>(window, some),
            WIDTH => self.pass::<WIDTH>(window, some),
            _ => self.pass::<NARROW>(window, some),
        });
        for pass in found {
            let Differentiated { simulated, columns } = pass?;
            if all.simulated.is_empty() {
                all.simulated = simulated;
            }
            all.columns.extend(columns);
        }
        let none =
            vec![vec![0.0; window.len() / self.system.points_per_row()]; all.simulated.len()];
        for k in absent {
            all.columns.insert(k, none.clone());
        }
        Ok(all)
    }

    /// The parameters that this experiment does not have: members that are not there, and times of others.
    fn absent(&self) -> Vec<usize> {
        let places = self.system.parts(self.hypothesis, self.index).places;
        let parameters = self.hypothesis.parameters(self.system);
        let missing =
            |(k, p): (usize, &FittedParameter)| places[p.member][p.value].is_none().then_some(k);
        parameters.iter().enumerate().filter_map(missing).collect()
    }

    /// The channels and the columns of `some` unknowns by one simulation.
    fn pass<const N: usize>(
        &self,
        window: &Range<usize>,
        some: Range<usize>,
    ) -> Result<Differentiated, DiagnoseError>
    where
        Chunk<N>: SimulationScalar,
    {
        let system = self.system;
        let points = system.points_per_row();
        let channels: Vec<usize> = fitted_outputs(system).map(|(c, _)| c).collect();
        let parts = system.parts(self.hypothesis, self.index);
        let (values, nuisances) = self.seeded::<N>(&parts, &some);
        let of = Differentiable::new(&parts.effects, values);
        let mut out = Trajectory::default();
        let (trial, base) = (system.trials[self.index], &system.base);
        let grid_points = system.simulated_points(self.index, window.end);
        let parameters = self.hypothesis.parameters(system).len() - self.absent().len();
        if of.leave_the_motion && some.end <= parameters {
            let motion = system.motion(self.hypothesis, self.local, (self.index, grid_points))?;
            sensed(trial, &of.effects, &of.values, &motion, &mut out);
        } else {
            let (effects, values) = (&of.effects, &of.values);
            simulate_until(trial, base, effects, values, &nuisances, grid_points, &mut out)
                .map_err(|diverged| diverges(trial, diverged))?;
        }
        let plain = |&c: &usize| out.channels[c].iter().map(|v| v.value).collect();
        let simulated = channels.iter().map(plain).collect();
        let mut columns: Vec<Vec<Vec<f64>>> =
            some.clone().map(|_| Vec::with_capacity(channels.len())).collect();
        for &c in &channels {
            let of_channel = row_derivatives(&out.channels[c][window.clone()], points, some.len());
            columns.iter_mut().zip(of_channel).for_each(|(all, column)| all.push(column));
        }
        Ok(Differentiated { simulated, columns })
    }

    /// Values and nuisances with `some` unknowns as directions. Parameters with a logarithmic coordinate carry
    /// the derivative by their logarithm.
    fn seeded<const N: usize>(
        &self,
        parts: &Parts<'_>,
        some: &Range<usize>,
    ) -> (Vec<Chunk<N>>, Nuisances<Chunk<N>>)
    where
        Chunk<N>: SimulationScalar,
    {
        let (system, hypothesis) = (self.system, self.hypothesis);
        let seeded = |value: f64, k: usize| match some.contains(&k) {
            true => Chunk::<N>::variable(value, k - some.start),
            false => Chunk::constant(value),
        };
        let mut values: Vec<Chunk<N>> = parts.values.iter().map(|&v| Chunk::constant(v)).collect();
        let parameters = hypothesis.parameters(system);
        let absent =
            parameters.iter().filter(|p| parts.places[p.member][p.value].is_none()).count();
        let present = parameters.len() - absent;
        let mut fixed: usize = system.fixed.iter().map(|a| a.values.len()).sum();
        // The lead is none of those that are simulated.
        let simulated = JointSystem::SHARES - 1;
        for (k, learned) in system.learned.iter().enumerate() {
            let unknown = present + simulated + k;
            for (value, magnitude) in values[fixed..].iter_mut().zip(magnitudes(learned)) {
                let seed = seeded(value.value, unknown);
                *value = Chunk::new(seed.value, seed.derivatives.map(|d| d * magnitude));
            }
            fixed += learned.values.len();
        }
        let there = parameters.iter().filter_map(|p| Some((p, parts.places[p.member][p.value]?)));
        for (k, (p, place)) in there.enumerate() {
            let value = &mut values[place];
            let seed = seeded(value.value, k);
            let slope = if p.info.logarithmic { seed.value } else { 1.0 };
            *value = Chunk::new(seed.value, seed.derivatives.map(|d| d * slope));
        }
        let mut n = JointSystem::nuisances::<Chunk<N>>(hypothesis, self.local);
        let [air_f, air_e] = &mut n.log_air;
        let shared = [&mut n.log_mass, &mut n.log_deformation, &mut n.force_noise_share];
        let local = [&mut n.start_mm, &mut n.start_mm_s, air_f, air_e];
        let of_learned = simulated..simulated + system.learned.len();
        for (k, value) in (0..of_learned.start).zip(shared).chain((of_learned.end..).zip(local)) {
            *value = seeded(value.value, present + k);
        }
        (values, n)
    }
}

/// Effects with their values, without absent ones that are not differentiated by: they change nothing.
struct Differentiable<'e, S> {
    effects: Vec<&'e dyn AnyEffect>,
    values: Vec<S>,
    /// Whether all differentiated unknowns belong to effects on sensors, so that the motion has no derivatives.
    leave_the_motion: bool,
}

impl<'e, S: EffectScalar> Differentiable<'e, S> {
    fn new(effects: &[&'e dyn AnyEffect], values: Vec<S>) -> Self {
        let mut of = Self { effects: Vec::new(), values: Vec::new(), leave_the_motion: true };
        let mut first = 0;
        for effect in effects {
            let own = &values[first..first + effect.info().value_len()];
            first += own.len();
            let constant = own.iter().all(EffectScalar::is_constant);
            if constant && is_absent(*effect, own) {
                continue;
            }
            of.leave_the_motion &= constant || effect.hooks().leave_the_motion();
            of.effects.push(*effect);
            of.values.extend_from_slice(own);
        }
        of
    }
}

/// Fitted channels at the grid points, and the columns of their derivatives.
struct Differentiated {
    simulated: Vec<Vec<f64>>,
    columns: Vec<Vec<Vec<f64>>>,
}

/// Means over rows of points of the first `count` derivatives, one column each, in one pass through the numbers.
fn row_derivatives<const N: usize>(
    numbers: &[Chunk<N>],
    points: usize,
    count: usize,
) -> Vec<Vec<f64>> {
    let rows = numbers.chunks_exact(points);
    let mut columns = vec![vec![0.0; rows.len()]; count];
    for (k, row) in rows.enumerate() {
        let mut sums = [0.0; N];
        for number in row {
            for (sum, derivative) in sums.iter_mut().zip(&number.derivatives) {
                *sum += derivative;
            }
        }
        for (column, sum) in columns.iter_mut().zip(&sums) {
            column[k] = sum / points as f64;
        }
    }
    columns
}

/// Derivative of each row by `step_share` of a step of time, by central differences over the row. A force that
/// acts earlier moves the response earlier, apart from what remains of the start.
fn by_time(values: &[f64], window: Range<usize>, step_share: f64, points: usize) -> Vec<f64> {
    let last = values.len() - 1;
    window
        .step_by(points)
        .map(|from| {
            // The mean of central differences over a row depends on its ends only.
            let (to, before) = (from + points - 1, from.saturating_sub(1));
            let ends = values[to] + values[(to + 1).min(last)] - values[from] - values[before];
            0.5 * step_share * ends / points as f64
        })
        .collect()
}
