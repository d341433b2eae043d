//! Your own system: a servo axis with recorded position and motor voltage.
//!
//! The model knows viscous friction only. The diagnosis names what it misses out of the candidates below.
//!
//! `cargo run --release -- data/*.csv`: every file but the last is fitted, the last one is held out.

use pam::field::*;
use std::error::Error;

/// Moved mass, weighed, kg. From the position alone only forces per mass can be told.
const MASS_KG: f64 = 2.0;
/// Names of the parameters, in the order in which the field takes them.
const PARAMETERS: [&str; 5] =
    ["motor_n_v", "viscous_n_s_mm", "coulomb_n", "asymmetry_n", "quadratic_n_s2_mm2"];

/// `m v̇ = k u − b v − F`, with `F = c σ + a |σ| + q v |v|`: the motor `k` (N/V), viscous friction `b`, and what may be
/// missing: dry friction, `c + a` (N) forwards and `c − a` backwards, and drag `q`.
#[derive(Clone, Copy)]
pub struct Axis<S>(pub [S; 5]);

impl<S: Scalar> Axis<S> {
    /// The friction at speed `v` (mm/s) in direction `σ`, N.
    pub fn friction_n(&self, v: S, direction: S) -> S {
        let [_, viscous, coulomb, asymmetry, drag] = self.0;
        let size = direction.real().abs();
        viscous * v
            + coulomb * direction
            + asymmetry.scaled(size)
            + drag * v * v.scaled(v.real().signum())
    }
}

impl<S: Scalar> VectorField<S> for Axis<S> {
    fn state_len(&self) -> usize {
        2 // position (mm), speed (mm/s)
    }
    fn input_len(&self) -> usize {
        2 // voltage (V), and the direction σ of the motion, which the solver sets
    }
    fn eval_into(&self, _t: f64, y: &[S], u: &[S], dy: &mut [S], _work: &mut [S]) {
        dy[0] = y[1];
        // N/kg = 1000 mm/s²
        dy[1] = (self.0[0] * u[0] - self.friction_n(y[1], u[1])).scaled(1e3 / MASS_KG);
    }
    fn output_len(&self) -> usize {
        1
    }
    fn outputs_into(&self, _t: f64, y: &[S], u: &[S], out: &mut [S]) {
        out[0] = self.friction_n(y[1], u[1]); // no sensor has it, but it can be read from the model
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
    fn names(&self) -> FieldNames {
        FieldNames::new(
            &["position_mm", "speed_mm_s"],
            &["voltage_v"],
            &["friction_n"],
            &PARAMETERS,
        )
    }
    fn dry_friction(&self) -> Option<DryFriction> {
        Some(DryFriction { velocity: 1, direction: 1 }) // state 1 sticks; input 1 is its direction
    }
}

/// Asks what the axis misses that data sheets describe; `noise_mm` is a guess of the noise of the position.
pub fn diagnose_axis(
    runs: &[Experiment<MeasuredInput>],
    held_out: &[Experiment<MeasuredInput>],
    noise_mm: f64,
) -> Result<FieldDiagnosis, Box<dyn Error>> {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));
    let healthy = Axis([3.0, 0.05, 0.0, 0.0, 0.0]); // from data sheets
    let (motor, viscous) = (0, 1);
    let outputs = Outputs::named(&healthy, [("position_mm", noise_mm)])?;
    let candidates = [
        Candidate::term("coulomb_friction", (2, PARAMETERS[2]), [0.0, 100.0], &[0.5, 2.0]),
        Candidate::term("friction_asymmetry", (3, PARAMETERS[3]), [-100.0, 100.0], &[0.1])
            .of("coulomb_friction"),
        Candidate::term("quadratic_drag", (4, PARAMETERS[4]), [-1.0, 1.0], &[1e-5]),
    ];
    let options = FieldOptions {
        refitted: vec![motor, viscous],
        logarithmic: vec![motor, viscous],
        refitted_deviation: Some(vec![1.0; 2]), // known to a factor of about three
        delay_deviation_s: 1e-3,
        ..FieldOptions::default()
    };
    let problem = FieldProblem::new(&healthy, runs, outputs, &integrator).with_held_out(held_out);
    Ok(diagnose_field(&problem, &candidates, &options)?)
}

pub fn main() -> Result<(), Box<dyn Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let read = |path| Experiment::read_csv(path, &["voltage_v"], &["position_mm"]);
    let runs: Vec<_> = paths.iter().map(read).collect::<Result<_, _>>()?;
    let (held_out, runs) = runs.split_last().ok_or("give recordings: data/*.csv")?;
    let found = diagnose_axis(runs, std::slice::from_ref(held_out), 0.01)?;
    println!("{}\n{}: {:?}", found.residual.description, found.verdict, found.named());
    for (name, value) in found.model.parameter_names.iter().zip(&found.model.parameters) {
        println!("  {name} = {value:.5}");
    }
    // cargo run --release --features report
    #[cfg(feature = "report")]
    std::fs::write(
        "report.html",
        pam::diagnose::report::diagnosis_report(&found, &Default::default()),
    )?;
    Ok(())
}
