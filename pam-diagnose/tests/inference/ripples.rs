//! Fits of a cost with many local minima.

use crate::linear::{Experiment, Linear};
use pam_diagnose::DiagnosisSettings;

/// `θ + sin 4θ` is not monotonic: the cost has a local minimum in each period of 1.6. Gradient-based steps end in the nearest of them; with
/// compass steps, the fit ends within one period of the truth.
#[test]
fn a_fit_leaves_local_minima() {
    let column: Vec<f64> = (0..200).map(|k| (0.3 * f64::from(k)).sin()).collect();
    let acting = 8.0 + (4.0_f64 * 8.0).sin();
    let measured = column.iter().map(|x| acting * x).collect();
    let run = Experiment { columns: vec![column], measured, ..Experiment::default() };
    let mut system = Linear::new(vec![run]);
    system.ripples = Some([1.0, 4.0]);
    let settings = DiagnosisSettings::default();
    let problem = system.problem(1e-2, &settings);
    for start in [2.0, 5.0, 12.0, 20.0, 40.0] {
        let fit = problem.fit(problem.base().with(0, &[start]), 60).expect("a regression");
        let slope = fit.hypothesis.members[0].values[0];
        assert!((slope - 8.0).abs() < 1.6, "from {start}: {slope}");
    }
}
