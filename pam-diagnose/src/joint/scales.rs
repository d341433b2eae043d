//! Magnitudes of the recordings, from which starting values follow.

use crate::data::OpenPart;
use crate::settings::DataSettings;
use pam_core::units::{ATMOSPHERE_KPA, MN_PER_N};
use pam_effects::effects::{DataScales, ScaleSample};
use pam_effects::simulation::{Base, Trial};

/// Intervals between the quantiles of the size of the force.
const QUANTILES: usize = 1000;

/// The magnitudes of the open parts of trials before any fit.
#[must_use]
pub(super) fn data_scales(
    trials: &[&Trial],
    open: &[OpenPart],
    base: &Base<f64>,
    settings: &DataSettings,
) -> DataScales {
    let (high, peak) = (settings.scale_quantile, settings.peak_quantile);
    let in_part = |part: &OpenPart| {
        let trial = trials[part.experiment];
        (trial, trial.record.points_within(part.end_s))
    };
    let open: Vec<(&Trial, usize)> = open.iter().map(in_part).collect();
    let percentile = |mut values: Vec<f64>, share: f64| {
        if values.is_empty() {
            return 0.0;
        }
        let at = (share * (values.len() - 1) as f64) as usize;
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let sizes = |f: &dyn Fn(&Trial, usize) -> Vec<f64>| -> Vec<f64> {
        open.iter().flat_map(|&(t, n)| f(t, n)).collect()
    };
    let forces = |t: &Trial, n: usize| 0..2 * t.record.steps_per_point * n;
    let force =
        sizes(&|t, n| t.record.force.values_mn()[forces(t, n)].iter().map(|f| f.abs()).collect());
    // A limit just below the peaks of the noise would remove noise, and the prediction would be better for it.
    let mut quiet_force = sizes(&|t, n| {
        let whole = &t.record.force.values_mn()[forces(t, n)];
        match &t.record.doubtful_force {
            Some(doubtful) => {
                whole.iter().zip(doubtful.values_mn()).map(|(f, noise)| (f - noise).abs()).collect()
            }
            None => whole.iter().map(|f| f.abs()).collect(),
        }
    });
    let travel = sizes(&|t, n| {
        let x = &t.record.measured[0][..n];
        let middle = percentile(x.to_vec(), 0.5);
        x.iter().map(|x| (x - middle).abs()).collect()
    });
    let reach = sizes(&|t, n| t.record.measured[0][..n].iter().map(|x| x.abs()).collect());
    let speed = sizes(&|t, n| t.record.measured[1][..n].iter().map(|v| v.abs()).collect());
    let stride = (open.iter().map(|t| t.1).sum::<usize>() / settings.scale_samples).max(1);
    let mut samples = Vec::new();
    for &(t, n) in &open {
        for k in (2..n.saturating_sub(2)).step_by(stride) {
            let v = &t.record.measured[1];
            let acceleration = (v[k + 2] - v[k - 2]) / (4.0 * t.record.step_s);
            let x = t.record.measured[0][k];
            let restoring = t.table.force_mn(x, v[k], [0.0; 2]);
            let missing = base.mass_kg * acceleration + restoring + base.damping_kg_s * v[k]
                - t.record.force_mn(k);
            samples.push(ScaleSample { displacement_mm: x, missing_n: missing / MN_PER_N });
        }
    }
    quiet_force.sort_unstable_by(f64::total_cmp);
    let last = quiet_force.len().saturating_sub(1);
    let intervals = QUANTILES.min(last);
    let force_quantiles_n = (0..=intervals)
        .filter_map(|k| quiet_force.get(k * last / intervals.max(1)))
        .map(|f| f / MN_PER_N)
        .collect();
    let (force_n, travel_mm) = (percentile(force, high) / MN_PER_N, percentile(travel, high));
    let gauge = |t: &Trial| {
        let [flexor, extensor] = t.record.rest.sealed_kpa;
        0.5 * (flexor + extensor) - ATMOSPHERE_KPA
    };
    let gauge_kpa = open.iter().map(|&(t, _)| gauge(t)).sum::<f64>() / open.len().max(1) as f64;
    DataScales {
        force_n,
        peak_force_n: percentile(quiet_force, peak) / MN_PER_N,
        force_quantiles_n,
        travel_mm,
        reach_mm: percentile(reach, high),
        speed_mm_s: percentile(speed, high),
        stiffness_n_mm: force_n / travel_mm.max(1e-3),
        gauge_kpa,
        duration_s: trials.iter().map(|t| t.record.duration_s()).fold(0.0, f64::max),
        samples,
    }
}
