//! A replay of the recorded grid is the solve, bit for bit.

use num_dual::Dual64;
use pam_core::{FieldFn, Scalar, VectorField};
use pam_solvers::{
    ConstantStep, Grid, Integrator, Interpolation, NoInput, ParametricInput, PidController,
    SampledInput, SaveAt, Solution, StepController, Tableau, Term, replay,
};

/// Van der Pol with a force on the second state.
fn van_der_pol<S: Scalar>(mu: f64) -> impl VectorField<S> {
    FieldFn::new(2, 1, move |t: f64, y: &[S], u: &[S], dy: &mut [S]| {
        dy[0] = y[1];
        dy[1] = ((S::constant(1.0) - y[0] * y[0]) * y[1]).scaled(mu) - y[0] + u[0];
        dy[1] += S::constant(0.1 * t.sin());
    })
}

const T1: f64 = 2.0;
const STOPS: [f64; 3] = [0.333, 0.5, 1.777];

fn samples() -> (Vec<f64>, Vec<f64>) {
    let times: Vec<f64> = (0..12).map(|k| 0.01 + f64::from(k) * 0.17).collect();
    let values = times.iter().map(|t| (7.0 * t).sin()).collect();
    (times, values)
}

fn bits(solution: &Solution<f64>) -> Vec<(u64, Vec<u64>)> {
    (0..solution.len())
        .map(|i| {
            let state = solution.state(i).iter().map(|v| v.to_bits()).collect();
            (solution.times_s()[i].to_bits(), state)
        })
        .collect()
}

fn check(integrator: &Integrator<dyn StepController>, interpolation: Interpolation) -> usize {
    let (times, values) = samples();
    let input = SampledInput::new(&times, &values, interpolation).unwrap();
    let term = Term::new(van_der_pol::<f64>(3.0), &input);
    let y0 = [1.0, 0.3];
    // The start, inside steps, user stops, jumps, the end.
    let saves = [0.0, 0.1, 0.333, 0.35, 0.36, times[3], 1.0, times[8], 1.777, 1.9, T1];
    let mut rejected = 0;
    for save_at in [SaveAt::End, SaveAt::Steps, SaveAt::Times(&saves), SaveAt::Dense] {
        let mut grid = Grid::new();
        let solved = integrator.solve_with_grid(&term, 0.0, T1, &y0, save_at, &mut grid).unwrap();
        let plain = integrator.solve(&term, 0.0, T1, &y0, save_at).unwrap();
        assert_eq!(bits(&solved), bits(&plain), "recording the grid changes nothing");
        assert_eq!(solved.statistics, plain.statistics);
        let replayed = replay(integrator.tableau(), &term, &grid, &y0, save_at).unwrap();
        assert_eq!(bits(&solved), bits(&replayed), "{save_at:?}, {interpolation:?}");
        assert_eq!(grid.steps(), solved.statistics.accepted);
        assert_eq!(replayed.statistics.accepted, grid.steps());
        assert!(replayed.statistics.evaluations <= solved.statistics.evaluations);
        if let (Some(a), Some(b)) = (&solved.dense, &replayed.dense) {
            for k in 0..=200 {
                let t = T1 * f64::from(k) / 200.0;
                assert_eq!(a.at(t), b.at(t));
            }
        }
        for stop in STOPS {
            assert!(grid.times_s().contains(&stop));
        }
        let held = interpolation == Interpolation::Hold;
        // A sample before the start or at it is no jump inside the solve.
        assert_eq!(grid.jumps_s().count(), if held { times.len() - 1 } else { 0 });
        rejected += solved.statistics.rejected;

        // The input rebuilt from its own parameters is the same input.
        let again = Term::new(&term.field, input.with_parameters(&values));
        let rebuilt = replay(integrator.tableau(), &again, &grid, &y0, save_at).unwrap();
        assert_eq!(bits(&solved), bits(&rebuilt));
    }
    rejected
}

#[test]
fn a_replay_is_the_solve_bit_for_bit() {
    let mut rejected = 0;
    for name in Tableau::NAMES {
        let tableau = Tableau::from_name(name).unwrap();
        for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
            let constant = Integrator::new(tableau.clone(), ConstantStep::new(0.0371));
            check(&constant.with_stops(&STOPS), interpolation);
            if tableau.error.is_some() {
                for tolerance in [1e-3, 1e-8] {
                    // A first step that is far too long, so that steps are rejected.
                    let mut controller = PidController::new(tolerance, tolerance);
                    controller.initial_step_s = Some(0.9);
                    let adaptive = Integrator::new(tableau.clone(), controller);
                    rejected += check(&adaptive.with_stops(&STOPS), interpolation);
                }
            }
        }
    }
    assert!(rejected > 0, "no step was rejected, so rejections are not tested");
}

/// The derivative of a replay is that of the frozen steps, and differences of it converge to it.
#[test]
fn a_replay_with_dual_numbers_differentiates_the_frozen_steps() {
    let integrator = Integrator::new(Tableau::tsit5(), PidController::new(1e-4, 1e-4));
    let field = |y0: f64| {
        let free = FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| {
            dy[0] = -y[0] * y[0];
        });
        (Term::new(free, NoInput), [y0])
    };
    let (term, y0) = field(1.3);
    let mut grid = Grid::new();
    integrator.solve_with_grid(&term, 0.0, 3.0, &y0, SaveAt::End, &mut grid).unwrap();
    let dual = FieldFn::new(1, 0, |_t, y: &[Dual64], _u: &[Dual64], dy: &mut [Dual64]| {
        dy[0] = -y[0] * y[0];
    });
    let start = [Dual64::new(1.3, 1.0)];
    let term_d = Term::new(dual, NoInput);
    let end = replay(integrator.tableau(), &term_d, &grid, &start, SaveAt::End).unwrap();
    let at = |y0: f64| {
        replay(integrator.tableau(), &term, &grid, &[y0], SaveAt::End).unwrap().state(0)[0]
    };
    let difference = (at(1.3 + 1e-5) - at(1.3 - 1e-5)) / 2e-5;
    assert!((end.state(0)[0].eps / difference - 1.0).abs() < 1e-9);
}

#[test]
fn an_unrecorded_grid_is_refused() {
    let term = Term::new(
        FieldFn::new(1, 0, |_t, y: &[f64], _u: &[f64], dy: &mut [f64]| dy[0] = -y[0]),
        NoInput,
    );
    let error = replay(&Tableau::rk4(), &term, &Grid::new(), &[1.0], SaveAt::End).unwrap_err();
    assert!(error.to_string().contains("never recorded"), "{error}");
}
