//! The parts of the study, in their full and their short form.

use super::batched::BatchGrid;
use super::case::Case;
use super::cells::Grid;
use super::conditions::ConditionGrid;
use super::method::{Method, all, checkpointings, for_many_parameters, of_joint};
use super::problems::small::SmallField;
use super::problems::{Problem, joint};
use super::solver::Solver;
use super::study::Study;
use pam_core::{Activation, JointModel, NetworkForce, ParametricField};
use pam_solvers::sensitivity::Checkpointing;
use pam_solvers::{NoInput, ParametricInput, Tableau};

/// Part: every method on every problem at every tolerance, horizon and activation.
pub const GRID: &str = "grid";
/// Part: Runge–Kutta methods at constant steps, for a kinked and a smooth activation.
pub const STEPS: &str = "steps";
/// Part: errors and cost against the horizon.
pub const HORIZON: &str = "horizon";
/// Part: cost against the number of parameters.
pub const PARAMETERS: &str = "parameters";
/// Part: one and many trajectories in a batch.
pub const BATCHED: &str = "batched";
/// Part: time against memory of the adjoint.
pub const CHECKPOINTS: &str = "checkpoints";

/// Tolerances of the full grid.
const TOLERANCES: [f64; 3] = [1e-4, 1e-6, 1e-8];
/// Width of the networks of the grid.
const SMALL: usize = 8;
/// Width of the networks whose Runge–Kutta methods are compared, and of batches.
const MIDDLE: usize = 32;
/// Steps that the published figures are about, s.
pub const FIVE_MS: f64 = 5e-3;

/// The whole study: some minutes.
#[must_use]
pub fn full() -> Study {
    let study = Study::new();
    let study = grid(study, &TOLERANCES, &[0.4, 1.0], Activation::NAMES);
    let study = steps(study, &[20.0, 10.0, 5.0, 2.0, 1.0, 0.5], 1.0);
    let study = horizons(study, &[0.125, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0]);
    let study = parameters(study, &[8, 16, 32, 64, 96], 0.05);
    let study = batched(study, &[32, 96], &[1, 4, 16], 1.0);
    checkpoints(study, 10.0)
}

/// The short form: less than half a minute.
#[must_use]
pub fn quick() -> Study {
    let study = Study::new().marked_quick();
    let study = grid(study, &[1e-4, 1e-7], &[0.4], &["leaky_relu", "tanh"]);
    let study = steps(study, &[20.0, 10.0, 5.0, 2.0, 1.0], 0.5);
    let study = horizons(study, &[0.25, 0.5, 1.0]);
    let study = parameters(study, &[8, 16, 32], 0.02);
    let study = batched(study, &[32], &[1, 4], 0.3);
    checkpoints(study, 2.0)
}

/// `study` with a trained network over the training conditions, at constant steps of Runge–Kutta methods.
#[must_use]
pub fn with_model(study: Study, model: JointModel<f64, NetworkForce<f64>>) -> Study {
    let steps_s = [20e-3, 10e-3, FIVE_MS, 2e-3, 1e-3];
    let solvers = tableaus().into_iter().flat_map(|t| steps_s.map(|h| (t.clone(), h))).collect();
    study.with(ConditionGrid { part: STEPS.into(), model, horizon_s: 5.0, solvers })
}

/// `study` with a field of the user's at the tolerances of the full grid.
#[must_use]
pub fn with_field(study: Study, case: Case<SmallField<f64>, NoInput>) -> Study {
    let solvers = tolerances(&Tableau::tsit5(), &TOLERANCES);
    study.with(Grid { part: GRID.into(), case, methods: all(), solvers })
}

fn tableaus() -> [Tableau; 4] {
    [Tableau::rk4(), Tableau::tsit5(), Tableau::bogacki_shampine3(), Tableau::dormand_prince5()]
}

fn activation(name: &str) -> Activation {
    Activation::from_name(name).expect("the name is on the list of activations")
}

fn tolerances(tableau: &Tableau, tolerances: &[f64]) -> Vec<Solver> {
    tolerances.iter().map(|&t| Solver::adaptive(tableau.clone(), t)).collect()
}

fn cells<F, I>(
    part: &str,
    case: Case<F, I>,
    methods: Vec<Method<F, I>>,
    solvers: &[Solver],
) -> Grid<F, I>
where
    F: ParametricField + 'static,
    I: ParametricInput + 'static,
{
    Grid { part: part.into(), case, methods, solvers: solvers.to_vec() }
}

fn grid(mut study: Study, tolerance: &[f64], horizons_s: &[f64], activations: &[&str]) -> Study {
    let tsit5 = tolerances(&Tableau::tsit5(), tolerance);
    // The trap shows with a method of low order; Tsit5 integrates both polynomials exactly.
    let bs3 = tolerances(&Tableau::bogacki_shampine3(), tolerance);
    let mut joint_solvers = tsit5.clone();
    joint_solvers.push(Solver::constant(Tableau::rk4(), FIVE_MS));
    for &horizon_s in horizons_s {
        // The small problems have their own scale of time.
        let (long, short) = (10.0 * horizon_s, horizon_s);
        study = study
            .with(Problem::Linear.with_every_method(GRID, long, tsit5.clone()))
            .with(Problem::VanDerPol.with_every_method(GRID, long, tsit5.clone()))
            .with(Problem::Quartic.with_every_method(GRID, 2.0 * horizon_s, bs3.clone()))
            .with(Problem::Stiff.with_every_method(GRID, short, tsit5.clone()));
        for name in activations {
            let joint = Problem::Joint { activation: activation(name), width: SMALL };
            study = study.with(joint.with_every_method(GRID, horizon_s, joint_solvers.clone()));
        }
    }
    study
}

fn steps(mut study: Study, steps_ms: &[f64], horizon_s: f64) -> Study {
    let tableaus = tableaus();
    for name in ["leaky_relu", "tanh"] {
        let case = joint::case(activation(name), MIDDLE, horizon_s);
        let solver = |tableau: &Tableau, ms: f64| {
            let mut solver = Solver::constant(tableau.clone(), ms * 1e-3);
            // Interpolation between steps is not what is compared.
            solver.stops_s.clone_from(&case.observations_s);
            solver
        };
        let solvers: Vec<Solver> = tableaus
            .iter()
            .flat_map(|tableau| steps_ms.iter().map(move |&ms| (tableau, ms)))
            .map(|(tableau, ms)| solver(tableau, ms))
            .collect();
        study = study.with(cells(STEPS, case, taped(all(), "adjoint"), &solvers));
    }
    study
}

fn horizons(mut study: Study, horizons_s: &[f64]) -> Study {
    for &horizon_s in horizons_s {
        let case = joint::case(activation("tanh"), SMALL, horizon_s);
        let solvers = [Solver::adaptive(Tableau::tsit5(), 1e-6)];
        study = study.with(cells(HORIZON, case, for_many_parameters(of_joint()), &solvers));
    }
    study
}

fn parameters(mut study: Study, widths: &[usize], horizon_s: f64) -> Study {
    let solvers = [Solver::constant(Tableau::rk4(), FIVE_MS)];
    for &width in widths {
        let case = if width == joint::PUBLISHED_WIDTH {
            joint::published_size(horizon_s)
        } else {
            joint::case(activation("leaky_relu"), width, horizon_s)
        };
        study = study.with(cells(PARAMETERS, case, for_many_parameters(of_joint()), &solvers));
    }
    study
}

fn batched(mut study: Study, widths: &[usize], trajectories: &[usize], horizon_s: f64) -> Study {
    for &width in widths {
        study = study.with(BatchGrid {
            part: BATCHED.into(),
            activation: activation("leaky_relu"),
            width,
            horizon_s,
            trajectories: trajectories.to_vec(),
            tableau: Tableau::rk4(),
            step_s: FIVE_MS,
        });
    }
    study
}

fn checkpoints(study: Study, horizon_s: f64) -> Study {
    let case = joint::case(activation("tanh"), SMALL, horizon_s);
    let steps = horizon_s / 1e-3;
    let mut choices = vec![Checkpointing::AllSave, Checkpointing::Interval(steps.sqrt() as usize)];
    choices.extend([64, 32, 16, 8, 4].map(|snapshots| Checkpointing::Binomial { snapshots }));
    let solvers = [Solver::constant(Tableau::rk4(), 1e-3)];
    study.with(cells(CHECKPOINTS, case, checkpointings(&choices), &solvers))
}

/// The methods of this name, differentiated by a tape.
fn taped<F, I>(methods: Vec<Method<F, I>>, name: &str) -> Vec<Method<F, I>> {
    methods.into_iter().filter(|m| m.name == name && m.differentiation == "tape").collect()
}
