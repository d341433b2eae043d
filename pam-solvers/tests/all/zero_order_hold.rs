//! A zero-order hold is exact: steps end at samples, the left value holds through the step.

use pam_core::{FieldFn, VectorField};
use pam_solvers::{
    ConstantStep, Integrator, Interpolation, PidController, SampledInput, SaveAt, Tableau, Term,
};

// The oscillator `m ẍ + b ẋ + k x = F`, in mN, mm and kg.
const M: f64 = 300.0;
const B: f64 = 6000.0;
const K: f64 = 150e3;

fn oscillator() -> impl VectorField<f64> {
    FieldFn::new(2, 1, |_t, y: &[f64], u: &[f64], dy: &mut [f64]| {
        dy[0] = y[1];
        dy[1] = (u[0] - K * y[0] - B * y[1]) / M;
    })
}

/// The exact motion over one hold of length `h` with constant force `f`.
fn exact_hold(y: [f64; 2], f: f64, h: f64) -> [f64; 2] {
    let decay = B / (2.0 * M);
    let wd = (K / M - decay * decay).sqrt();
    let rest = f / K;
    let (a, b) = (y[0] - rest, (y[1] + decay * (y[0] - rest)) / wd);
    let (sin, cos) = (wd * h).sin_cos();
    let e = (-decay * h).exp();
    let x = e * (a * cos + b * sin);
    [rest + x, -decay * x + e * wd * (b * cos - a * sin)]
}

/// A rough force on a 1 kHz grid whose times carry rounding, as logs have it.
fn force(n: usize) -> (Vec<f64>, Vec<f64>) {
    let times = (0..n).map(|k| k as f64 / 1000.0 + 0.2).collect();
    let mut state = 12345_u32;
    let values = (0..n)
        .map(|k| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let noise = f64::from(state) / f64::from(u32::MAX) - 0.5;
            133.5e3 * (k as f64 * 0.0031).sin() + 40e3 * noise
        })
        .collect();
    (times, values)
}

fn reference(times: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let mut y = [0.1, 0.5];
    let mut out = vec![y];
    for k in 1..times.len() {
        y = exact_hold(y, values[k - 1], times[k] - times[k - 1]);
        out.push(y);
    }
    out
}

#[test]
fn every_method_reproduces_the_exact_hold() {
    let (times, values) = force(5000);
    let truth = reference(&times, &values);
    let (t0, t1) = (times[0], times[times.len() - 1]);
    for name in Tableau::NAMES {
        let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
        let s = Integrator::new(Tableau::from_name(name).unwrap(), ConstantStep::new(1e-3))
            .solve(&Term::new(oscillator(), input), t0, t1, &[0.1, 0.5], SaveAt::Times(&times))
            .unwrap();
        let worst =
            (0..times.len()).map(|i| (s.state(i)[0] - truth[i][0]).abs()).fold(0.0, f64::max);
        // Third order at 1 ms leaves 1e-6 mm; fourth and fifth order are at rounding.
        assert!(worst < 1e-5, "{name}: {worst:e} mm");
        if name != &"bs3" {
            assert!(worst < 1e-8, "{name}: {worst:e} mm");
        }
        // One step a sample, and no evaluation beyond the stages of each.
        assert_eq!(s.statistics.accepted, times.len() - 1);
        let stages = Tableau::from_name(name).unwrap().stages();
        assert_eq!(s.statistics.evaluations, stages * (times.len() - 1), "{name}");
    }
}

#[test]
fn adaptive_steps_also_end_at_samples() {
    let (times, values) = force(3000);
    let truth = reference(&times, &values);
    let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
    let (t0, t1) = (times[0], times[times.len() - 1]);
    let s = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6))
        .solve(&Term::new(oscillator(), input), t0, t1, &[0.1, 0.5], SaveAt::Times(&times))
        .unwrap();
    for (i, y) in truth.iter().enumerate() {
        assert!((s.state(i)[0] - y[0]).abs() < 1e-6);
    }
    assert!(s.statistics.accepted < 3100, "{:?}", s.statistics);
}

/// Steps larger than the sample time are cut at every sample, smaller ones divide it.
#[test]
fn step_sizes_that_do_not_fit_the_grid_are_cut() {
    let (times, values) = force(400);
    let truth = reference(&times, &values);
    for step in [0.7e-3, 0.33e-3, 5e-3] {
        let input = SampledInput::new(&times, &values, Interpolation::Hold).unwrap();
        let s = Integrator::new(Tableau::tsit5(), ConstantStep::new(step))
            .solve(
                &Term::new(oscillator(), input),
                times[0],
                times[399],
                &[0.1, 0.5],
                SaveAt::Times(&times),
            )
            .unwrap();
        for (i, y) in truth.iter().enumerate() {
            assert!((s.state(i)[0] - y[0]).abs() < 1e-9, "step {step}");
        }
    }
}

/// Looking the force up at the stage times, as the published path does, is wrong by far more than
/// the solver's error: the test above would catch it.
#[test]
fn the_published_lookup_would_fail_this_test() {
    let (times, values) = force(5000);
    let truth = reference(&times, &values);
    let lookup = pam_solvers::InputFn::new(1, |t: f64, u: &mut [f64]| {
        u[0] = values[times.partition_point(|&s| s <= t).saturating_sub(1)];
    });
    let (t0, t1) = (times[0], times[times.len() - 1]);
    let s = Integrator::new(Tableau::tsit5(), ConstantStep::new(1e-3))
        .solve(&Term::new(oscillator(), lookup), t0, t1, &[0.1, 0.5], SaveAt::Times(&times))
        .unwrap();
    let worst = (0..times.len()).map(|i| (s.state(i)[0] - truth[i][0]).abs()).fold(0.0, f64::max);
    assert!(worst > 1e-4, "{worst:e} mm");
}
