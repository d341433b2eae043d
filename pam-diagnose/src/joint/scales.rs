//! Magnitudes of the recordings, from which starting values follow.

use pam_core::units::MN_PER_N;
use pam_effects::effects::{DataScales, ScaleSample};
use pam_effects::simulation::{Base, Trial};

/// Samples that are kept, over all trials.
const SAMPLES: usize = 6000;

/// The magnitudes of trials before any fit.
#[must_use]
pub fn data_scales(trials: &[&Trial], base: &Base<f64>) -> DataScales {
    let percentile = |mut values: Vec<f64>, share: f64| {
        if values.is_empty() {
            return 0.0;
        }
        let at = (share * (values.len() - 1) as f64) as usize;
        *values.select_nth_unstable_by(at, f64::total_cmp).1
    };
    let sizes = |f: &dyn Fn(&Trial) -> Vec<f64>| trials.iter().flat_map(|t| f(t)).collect();
    let force: Vec<f64> = sizes(&|t| t.record.force.values_mn().iter().map(|f| f.abs()).collect());
    let travel: Vec<f64> = sizes(&|t| {
        let middle = percentile(t.record.measured[0].clone(), 0.5);
        t.record.measured[0].iter().map(|x| (x - middle).abs()).collect()
    });
    let speed: Vec<f64> = sizes(&|t| t.record.measured[1].iter().map(|v| v.abs()).collect());
    let stride = (trials.iter().map(|t| t.record.points()).sum::<usize>() / SAMPLES).max(1);
    let mut samples = Vec::new();
    for t in trials {
        for k in (2..t.record.points().saturating_sub(2)).step_by(stride) {
            let v = &t.record.measured[1];
            let acceleration = (v[k + 2] - v[k - 2]) / (4.0 * t.record.step_s);
            let x = t.record.measured[0][k];
            let restoring = t.table.force_mn(x, v[k], [0.0; 2]);
            let missing = base.mass_kg * acceleration + restoring + base.damping_kg_s * v[k]
                - t.record.force.values_mn()[2 * k];
            samples.push(ScaleSample { displacement_mm: x, missing_n: missing / MN_PER_N });
        }
    }
    let (force_n, travel_mm) =
        (percentile(force.clone(), 0.95) / MN_PER_N, percentile(travel, 0.95));
    DataScales {
        force_n,
        peak_force_n: percentile(force, 0.999) / MN_PER_N,
        travel_mm,
        speed_mm_s: percentile(speed, 0.95),
        stiffness_n_mm: force_n / travel_mm.max(1e-3),
        samples,
    }
}
