//! Features from which a flexible model learns the residual of the joint.

use crate::settings::VerdictSettings;
use pam_effects::simulation::Trial;

/// Forces that might be missing (powers of position and velocity, direction, the command, play of three widths, three
/// relaxations, time) as the joint would respond to them, through the second-order system that the model is near its
/// middle; and the same features as a sensor would add them.
pub(super) fn features(
    t: &Trial,
    [x, v]: [&[f64]; 2],
    mass_kg: f64,
    settings: &VerdictSettings,
) -> Vec<Vec<f64>> {
    let n = x.len();
    let rms = |s: &[f64]| (s.iter().map(|a| a * a).sum::<f64>() / n as f64).sqrt().max(1e-9);
    let whole = t.record.points();
    let force: Vec<f64> = (0..n).map(|k| t.record.force_mn(k)).collect();
    let (sx, sv, sf) = (rms(x), rms(v), rms(&force));
    let map = |f: &dyn Fn(usize) -> f64| (0..n).map(f).collect::<Vec<f64>>();
    // Any scale serves: the ridge is relative to columns of unit size.
    let pressure = (t.record.rest.sealed_kpa[0] + t.record.rest.sealed_kpa[1]) / 1000.0;
    let difference = (t.record.rest.sealed_kpa[0] - t.record.rest.sealed_kpa[1]) / 500.0;
    let play = |half: f64| {
        let mut at = x[0];
        map_mut(x, |x| {
            at = at.clamp(x - half, x + half);
            x - at
        })
    };
    let relaxed = |time_s: f64| {
        let share = -(-t.record.step_s / time_s).exp_m1();
        let mut at = x[0];
        map_mut(x, |x| {
            at += share * (x - at);
            x - at
        })
    };
    let mut features: Vec<Vec<f64>> = vec![
        vec![1.0; n],
        vec![pressure; n],
        vec![difference; n],
        map(&|k| x[k] / sx),
        map(&|k| (x[k] / sx).powi(2)),
        map(&|k| (x[k] / sx).powi(3)),
        map(&|k| pressure * x[k] / sx),
        map(&|k| difference * x[k] / sx),
        map(&|k| v[k] / sv),
        map(&|k| pressure * v[k] / sv),
        map(&|k| v[k] * v[k].abs() / (sv * sv)),
        map(&|k| (v[k] / (settings.direction_width * sv)).tanh()),
        map(&|k| x[k] * v[k] / (sx * sv)),
        map(&|k| force[k] / sf),
        map(&|k| (force[k] / sf).powi(3)),
        map(&|k| k as f64 / whole as f64),
        map(&|k| x[k] / sx * k as f64 / whole as f64),
    ];
    features.extend(settings.play_widths.map(|w| play(w * sx)));
    features.extend(settings.relaxations_s.map(relaxed));
    // The model near the middle of the motion.
    let middle = x.iter().sum::<f64>() / n as f64;
    let f = |x: f64, v: f64| t.table.force_mn(x, v, [0.0; 2]);
    let stiffness = (f(middle + 0.5 * sx, 0.0) - f(middle - 0.5 * sx, 0.0)) / sx;
    let damping = ((f(middle, 0.5 * sv) - f(middle, -0.5 * sv)) / sv).max(0.0);
    let responses: Vec<Vec<f64>> = features
        .iter()
        .map(|cause| {
            let (mut y, mut w) = (0.0, 0.0);
            map_mut(cause, |c| {
                // Implicit: stable at any step.
                let free = w + t.record.step_s / mass_kg * (c * 1e3 - stiffness * y);
                let slowed = damping + t.record.step_s * stiffness.max(0.0);
                w = free / (1.0 + t.record.step_s * slowed / mass_kg);
                y += t.record.step_s * w;
                y
            })
        })
        .collect();
    features.extend(responses);
    features
}

fn map_mut(values: &[f64], mut f: impl FnMut(f64) -> f64) -> Vec<f64> {
    values.iter().map(|&v| f(v)).collect()
}
