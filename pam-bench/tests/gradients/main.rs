//! The study's rows say what is known of the methods.

mod kinked;
mod network;
mod own;

use pam_bench::gradients::{
    BatchGrid, Cells, Grid, Kind, Method, Problem as OfStudy, Row, Solver, Study, StudyResult,
    methods, output, parts, problems,
};
use pam_bench::memory::CountingAllocator;
use pam_core::{Activation, ParametricField};
use pam_solvers::sensitivity::{Gradient, GradientMethod, Loss, Problem};
use pam_solvers::{ParametricInput, SolveError, Tableau};
use std::sync::{Mutex, MutexGuard, PoisonError};

#[global_allocator]
static MEMORY: CountingAllocator = CountingAllocator;

fn all_on(problem: OfStudy, horizon_s: f64, solver: Solver) -> Box<dyn Cells> {
    problem.with_every_method(parts::GRID, horizon_s, vec![solver])
}

/// One test at a time: memory is counted over the whole process, and what a neighbour frees would count as well.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

fn run(study: Study) -> StudyResult {
    study.with_repeat(1).run(|_| {})
}

fn tanh() -> Activation {
    Activation::from_name("tanh").unwrap()
}

#[test]
fn exact_methods_agree_with_the_frozen_steps_and_all_with_the_truth() {
    let _alone = alone();
    let tsit5 = || Solver::adaptive(Tableau::tsit5(), 1e-8);
    let leaky = Activation::from_name("leaky_relu").unwrap();
    let study = Study::new()
        .with(all_on(OfStudy::Linear, 3.0, tsit5()))
        .with(all_on(OfStudy::VanDerPol, 3.0, tsit5()))
        .with(all_on(OfStudy::Joint { activation: tanh(), width: 8 }, 0.1, tsit5()))
        .with(all_on(OfStudy::Joint { activation: leaky, width: 4 }, 0.1, tsit5()));
    let result = run(study);
    assert!(result.rows.iter().any(|row| row.method_text() == "adjoint / hand"));
    assert_eq!(result.rows.len(), 2 * 19 + 2 * 27);
    for row in &result.rows {
        let name = format!("{} on {}", row.method_text(), row.problem_text());
        assert_eq!(row.failure, None, "{name}");
        let (replay, truth) = (row.replay_error.unwrap(), row.gradient_error.unwrap());
        match row.kind {
            Kind::Exact => assert!(replay < 1e-10, "{name}: {replay:e}"),
            Kind::Difference => assert!(replay < 1e-4, "{name}: {replay:e}"),
            _ => assert!(replay < 1e-2, "{name}: {replay:e}"),
        }
        if row.activation.as_deref() != Some("leaky_relu") {
            assert!(truth < 1e-4, "{name}: {truth:e}");
        }
        assert!(row.seconds.unwrap() > 0.0 && row.evaluations > 0 && row.steps > 0, "{name}");
        assert!(row.peak_bytes.is_some_and(|bytes| bytes > 0), "{name}: memory is counted");
    }
}

#[test]
fn on_the_stiff_problem_backsolve_is_lost_and_the_discrete_adjoint_right() {
    let _alone = alone();
    let solver = Solver::adaptive(Tableau::tsit5(), 1e-6);
    let result = run(Study::new().with(all_on(OfStudy::Stiff, 1.0, solver)));
    for row in &result.rows {
        let lost = row.failure.is_some() || row.gradient_error.unwrap() > 0.1;
        match row.method.as_str() {
            "backsolve" | "backsolve-free" => assert!(lost, "{}", row.method_text()),
            _ => assert!(!lost && row.gradient_error.unwrap() < 1e-3, "{}", row.method_text()),
        }
    }
    let failed = result.rows.iter().find(|row| row.failure.is_some()).expect("one fails outright");
    assert!(failed.failure.as_deref().unwrap().contains("backward"), "{failed:?}");
    assert!(output::to_markdown(&result).contains("**failed**"));
}

#[test]
fn on_the_quartic_the_gradient_is_worse_than_the_state() {
    let _alone = alone();
    let solvers = [1e-3, 1e-5, 1e-7]
        .map(|tolerance| Solver::adaptive(Tableau::bogacki_shampine3(), tolerance));
    let cells = OfStudy::Quartic.with_every_method(parts::GRID, 2.0, solvers.to_vec());
    let study = Study::new().with(cells);
    for row in run(study.with_methods(&["adjoint".into()]).unwrap()).rows {
        let (value, gradient) = (row.value_error.unwrap(), row.gradient_error.unwrap());
        assert!(gradient > 1.2 * value, "{}: {value:e}, {gradient:e}", row.steps_text());
        assert!(row.replay_error.unwrap() < 1e-10, "exact for the steps taken all the same");
    }
}

#[test]
fn lanes_are_the_adjoint_of_all_trajectories() {
    let _alone = alone();
    let batched = BatchGrid {
        part: parts::BATCHED.into(),
        activation: tanh(),
        width: 8,
        horizon_s: 0.1,
        trajectories: vec![1, 3],
        tableau: Tableau::rk4(),
        step_s: 5e-3,
    };
    let result = run(Study::new().with(batched));
    assert_eq!(result.rows.len(), 6);
    for row in &result.rows {
        let within = if row.kind == Kind::SinglePrecision { 1e-4 } else { 1e-10 };
        assert!(row.replay_error.unwrap() < within, "{row:?}");
        assert!(row.gradient_error.unwrap() < 1e-3, "{row:?}");
    }
}

#[test]
fn results_repeat_except_for_time_and_memory() {
    let _alone = alone();
    let study = || {
        let joint = OfStudy::Joint { activation: tanh(), width: 4 };
        let cells = all_on(joint, 0.1, Solver::constant(Tableau::rk4(), 5e-3));
        run(Study::new().with(cells)).rows.iter().map(Row::repeatable).collect::<Vec<_>>()
    };
    assert_eq!(study(), study());
}

/// A method that a user adds; it fails.
struct Broken;

impl<F: ParametricField, I: ParametricInput> GradientMethod<F, I> for Broken {
    fn name(&self) -> String {
        "broken".into()
    }
    fn value_and_gradient(
        &self,
        problem: &Problem<'_, F, I>,
        loss: &mut dyn Loss,
    ) -> Result<Gradient, Box<SolveError<f64>>> {
        let mut gradient =
            pam_solvers::sensitivity::TapeThroughSolver.value_and_gradient(problem, loss)?;
        gradient.parameters[0] = f64::NAN;
        Ok(gradient)
    }
}

#[test]
fn a_failure_is_a_row_and_files_hold_every_row() {
    let _alone = alone();
    let mut all = methods();
    all.push(Method::new("broken", "tape", Kind::Exact, |_| Box::new(Broken)));
    let study = Study::new().with(Grid {
        part: "mine".into(),
        case: problems::van_der_pol::case(1.0),
        methods: all,
        solvers: vec![Solver::adaptive(Tableau::tsit5(), 1e-6)],
    });
    let unknown = study.method_names();
    assert!(unknown.contains(&"broken".to_owned()) && unknown.contains(&"fd".to_owned()));
    let study = study.with_methods(&["broken".into(), "adjoint".into()]).unwrap();
    let mut told = Vec::new();
    let result = study.with_repeat(1).run(|progress| told.push((progress.done, progress.total)));
    assert_eq!(told, [(1, 3), (2, 3), (3, 3)]);
    assert_eq!(result.rows[2].failure.as_deref(), Some("the gradient is not finite"));
    let back: StudyResult = serde_json::from_str(&output::to_json(&result)).unwrap();
    assert_eq!(back, result);
    assert_eq!(output::to_csv(&result.rows).lines().count(), 4);
    let folder = tempfile::tempdir().unwrap();
    output::write(folder.path(), &result, "test").unwrap();
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(report.contains("broken") && report.contains("not finite"));
}

#[test]
fn unknown_names_list_the_known_ones() {
    let _alone = alone();
    let error = parts::quick().with_problems(&["nonsense".into()]).err().unwrap().to_string();
    for name in ["nonsense", "linear", "van-der-pol", "quartic", "stiff", "joint"] {
        assert!(error.contains(name), "{error}");
    }
    let error = parts::quick().with_methods(&["magic".into()]).err().unwrap().to_string();
    for name in ["adjoint", "forward", "backsolve", "interpolating", "quadrature", "batched"] {
        assert!(error.contains(name), "{error}");
    }
}
