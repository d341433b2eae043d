//! Residuals and sensitivities of one recording.

use super::system::JointSystem;
use crate::error::DiagnoseError;
use crate::fit::{Hypothesis, Sensitivities, fitted_outputs, row_means};
use crate::search::Candidates;
use pam_core::Scalar;
use pam_effects::effects::{Derivatives, WIDTH};
use pam_effects::simulation::{Nuisances, Trajectory, simulate};
use std::ops::Range;

/// Shared and local nuisances that the simulation is differentiated by. The lead follows from the time series, and the
/// offsets are added to the result.
const SIMULATED: usize = 6;

pub(super) fn sensitivities(
    system: &JointSystem<'_>,
    hypothesis: &Hypothesis,
    local: &[f64],
    experiment: usize,
    window: Range<usize>,
) -> Result<Sensitivities, DiagnoseError> {
    let points = system.points_per_row();
    let channels: Vec<usize> = fitted_outputs(system).map(|(c, _)| c).collect();
    let (effects, values) = system.parts(hypothesis);
    let parameters = hypothesis.parameters(system).len();
    let simulated = parameters + SIMULATED;
    let t = system.trials[experiment];
    let mut columns = Vec::with_capacity(simulated + 3);
    let mut residuals: Vec<Vec<f64>> = Vec::new();
    let mut by_lead = Vec::new();
    let mut out = Trajectory::default();
    for first in (0..simulated).step_by(WIDTH) {
        let (values, nuisances) = seeded(system, hypothesis, &values, local, first);
        simulate::<Derivatives>(t, &system.base, &effects, &values, &nuisances, &mut out)?;
        if first == 0 {
            for &c in &channels {
                let plain: Vec<f64> = out.channels[c].iter().map(|v| v.value).collect();
                residuals.push(row_means(&t.record.measured[c], &plain, window.clone(), points));
                by_lead.push(by_time(
                    &plain,
                    window.clone(),
                    t.record.sample_s / t.record.step_s,
                    points,
                ));
            }
        }
        for k in 0..WIDTH.min(simulated - first) {
            let column = |&c: &usize| -> Vec<f64> {
                out.channels[c][window.clone()]
                    .chunks_exact(points)
                    .map(|row| {
                        let sum: f64 = row.iter().map(|v| v.derivatives[k]).sum();
                        sum / points as f64
                    })
                    .collect()
            };
            columns.push(channels.iter().map(column).collect());
        }
    }
    columns.insert(parameters + JointSystem::LEAD, by_lead);
    let rows = window.len() / points;
    for (i, offset) in local[4..].iter().enumerate() {
        residuals[1 + i].iter_mut().for_each(|r| *r -= offset);
        let mut unit = vec![Vec::new(); channels.len()];
        unit[1 + i] = vec![1.0; rows];
        columns.push(unit);
    }
    Ok(Sensitivities { residuals, columns })
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

/// Values and nuisances with the unknowns from `first` on as directions. Parameters with a logarithmic
/// coordinate carry the derivative by their logarithm.
fn seeded(
    system: &JointSystem<'_>,
    hypothesis: &Hypothesis,
    values: &[f64],
    local: &[f64],
    first: usize,
) -> (Vec<Derivatives>, Nuisances<Derivatives>) {
    let mut values: Vec<Derivatives> = values.iter().map(|&v| Derivatives::constant(v)).collect();
    let fixed: usize = system.fixed.iter().map(|a| a.values.len()).sum();
    let parameters = hypothesis.parameters(system);
    for (k, p) in parameters.iter().enumerate() {
        let before: usize = hypothesis.members[..p.member].iter().map(|m| m.values.len()).sum();
        let value = &mut values[fixed + before + p.value];
        let seed = Derivatives::seeded(value.value, k, first);
        let slope = if p.info.logarithmic { seed.value } else { 1.0 };
        *value = Derivatives::new(seed.value, seed.derivatives.map(|d| d * slope));
    }
    let mut n = JointSystem::nuisances::<Derivatives>(hypothesis, local);
    let [air_f, air_e] = &mut n.log_air;
    let others =
        [&mut n.log_mass, &mut n.log_deformation, &mut n.start_mm, &mut n.start_mm_s, air_f, air_e];
    for (k, value) in others.into_iter().enumerate() {
        *value = Derivatives::seeded(value.value, parameters.len() + k, first);
    }
    (values, n)
}
