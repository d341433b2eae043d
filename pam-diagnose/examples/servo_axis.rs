//! A system without muscles, identified and diagnosed: a servo axis with a screw.
//!
//! ```text
//! m v̇ = k_F i − b v − c tanh(v / v_s) − a sin(2π x / pitch) − F₀        states x (mm), v (mm/s)
//! i = 0.1 A/mm (r − x) − 0.02 A s/mm v                                 the servo, input r (mm)
//! ```
//!
//! The model knows mass, motor constant and viscous friction; dry friction and a cogging force are hidden in
//! the plant. Eight seconds of position from an encoder, with its noise, tell.

use pam_core::{ParametricField, Scalar, VectorField};
use pam_diagnose::Verdict;
use pam_diagnose::field::{Candidate, FieldOptions, diagnose_field};
use pam_effects::effects::ParameterInfo;
use pam_solvers::{InputFn, Integrator, PidController, SaveAt, Tableau, Term};
use pam_train::field::{Experiment, FieldProblem, LeastSquares, Outputs};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand_distr::{Distribution, Normal};
use std::f64::consts::TAU;

/// Moved mass with that of the motor (kg), motor constant (N/A), then what may be missing: viscous friction (N·s/mm), dry friction (N),
/// cogging (N) and its pitch (mm), a load (N).
#[derive(Clone, Copy)]
struct Axis<S>([S; 7]);

/// Speed below which dry friction is smoothed, mm/s.
const SMOOTHED_BELOW_MM_S: f64 = 1.0;

impl<S: Scalar> VectorField<S> for Axis<S> {
    fn state_len(&self) -> usize {
        2
    }
    fn input_len(&self) -> usize {
        1
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        let [mass, motor, viscous, dry, cogging, pitch, load] = self.0;
        let (x, v) = (y[0], y[1]);
        let current_a = (u[0] - x).scaled(0.1) - v.scaled(0.02);
        let force_n = motor * current_a
            - viscous * v
            - dry * v.scaled(1.0 / SMOOTHED_BELOW_MM_S).tanh()
            - cogging * (x / pitch).scaled(TAU).sin()
            - load;
        dy[0] = v;
        dy[1] = force_n.scaled(1e3) / mass; // N/kg = 1000 mm/s²
    }
}

impl ParametricField for Axis<f64> {
    type With<S: Scalar> = Axis<S>;
    fn parameters(&self) -> Vec<f64> {
        self.0.to_vec()
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> Axis<S> {
        Axis(std::array::from_fn(|i| p[i]))
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));
    let healthy = Axis([60.0, 20.0, 0.05, 0.0, 0.0, 5.0, 0.0]);
    let worn = Axis([60.0, 20.0, 0.05, 4.0, 3.0, 5.0, 0.0]);
    let noise_mm = 0.02;
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let noise = Normal::new(0.0, noise_mm)?;
    let times_s: Vec<f64> = (0..800).map(|k| 0.01 * f64::from(k)).collect();
    let mut record = |axis: Axis<f64>,
                      amplitude_mm: f64,
                      hz: f64|
     -> Result<_, Box<dyn std::error::Error>> {
        let input = InputFn::new(1, move |t: f64, u: &mut [f64]| {
            u[0] = amplitude_mm * ((TAU * hz * t).sin() + 0.4 * (TAU * 2.3 * hz * t).sin());
        });
        let y0 = vec![0.0, 0.0];
        let run =
            integrator.solve(&Term::new(axis, input), 0.0, 8.0, &y0, SaveAt::Times(&times_s))?;
        let measured = run.component(0).map(|x| x + noise.sample(&mut random)).collect();
        let name = format!("{amplitude_mm} mm at {hz} Hz");
        Ok(Experiment::new(&name, input, times_s.clone(), measured).starting_at(y0))
    };

    // The numbers of the healthy axis, by least squares with intervals.
    let calibration = [record(healthy, 10.0, 0.5)?];
    let guess = Axis([66.0, 18.0, 0.04, 0.0, 0.0, 5.0, 0.0]);
    let outputs = Outputs::new([(0, noise_mm)]);
    let problem = FieldProblem::new(&guess, &calibration, outputs.clone(), &integrator);
    // The position tells k_F / m and b / m, not all three: the mass is weighed.
    let mut start = guess.parameters();
    start[0] = 60.0;
    let free = Some(vec![1, 2]);
    let fit =
        problem.least_squares(&LeastSquares { free, start: Some(start), ..Default::default() })?;
    for (index, truth, name) in
        [(1, 20.0, "motor constant, N/A"), (2, 0.05, "viscous friction, N s/mm")]
    {
        let [low, high] = fit.interval(index).expect("it was fitted");
        println!("{name}: {:.4} [{low:.4}, {high:.4}], true {truth}", fit.parameters[index]);
        assert!((fit.parameters[index] - truth).abs() < 0.01 * truth);
    }

    // The worn axis against that model.
    let model = Axis(std::array::from_fn(|i| fit.parameters[i]));
    let experiments = [record(worn, 10.0, 0.5)?, record(worn, 15.0, 0.3)?, record(worn, 6.0, 0.8)?];
    let problem = FieldProblem::new(&model, &experiments, outputs, &integrator);
    let candidates = [
        Candidate::one(
            "motor_gain",
            1,
            ParameterInfo::linear("motor_n_a", [1.0, 100.0]).off_at(Some(model.0[1])),
            &[19.0],
        ),
        Candidate::one(
            "dry_friction",
            3,
            ParameterInfo::linear("force_n", [0.0, 50.0]),
            &[1.0, 5.0],
        ),
        Candidate {
            name: "cogging".into(),
            parameters: vec![
                (4, ParameterInfo::linear("force_n", [-50.0, 50.0])),
                (5, ParameterInfo::scale("pitch_mm", [0.5, 50.0])),
            ],
            starts: [3.0, 4.6, 7.0, 10.0].iter().map(|&pitch| vec![1.0, pitch]).collect(),
            property_of: None,
        },
        Candidate::one("load", 6, ParameterInfo::linear("force_n", [-50.0, 50.0]), &[0.5]),
    ];
    let found = diagnose_field(&problem, &candidates, &FieldOptions::default())?;
    println!("{}", found.residual.description);
    println!("{}: {:?}", found.verdict, found.named());
    for cause in &found.causes {
        for (name, i) in &cause.parameters {
            println!(
                "  {} {name} = {:.3} [{:.3}, {:.3}]",
                cause.effect, i.value, i.ci95[0], i.ci95[1]
            );
        }
    }
    let position = &found.error_reduction.channels[0];
    println!(
        "error on the test set {:.3} mm before, {:.3} mm after",
        position.rmse_before, position.rmse_after
    );
    let mut named = found.named();
    named.sort_unstable();
    assert_eq!(found.verdict, Verdict::Explained);
    assert_eq!(named, ["cogging", "dry_friction"]);
    for (index, truth) in [(3, 4.0), (4, 3.0), (5, 5.0)] {
        assert!(
            (found.model.parameters[index] - truth).abs() < 0.03 * truth,
            "{:?}",
            found.model.parameters
        );
    }
    assert!(position.rmse_after < 1.2 * noise_mm);

    // A healthy axis: nothing is found.
    let experiments = [record(healthy, 10.0, 0.5)?, record(healthy, 15.0, 0.3)?];
    let problem = FieldProblem { experiments: &experiments, ..problem };
    let nothing = diagnose_field(&problem, &candidates, &FieldOptions::default())?;
    println!("healthy: {}", nothing.verdict);
    assert_eq!(nothing.verdict, Verdict::NothingFound);
    Ok(())
}
