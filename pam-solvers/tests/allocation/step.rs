//! A step allocates nothing: the number of allocations of a solve does not depend on its length.

use pam_core::{JointModel, Mlp, NetworkForce, SealedMasses, force::Dense};
use pam_solvers::{
    ConstantStep, Integrator, Interpolation, PidController, SampledInput, SaveAt, Tableau, Term,
};

fn network() -> NetworkForce<f64> {
    let value = |k: usize| 0.3 * (k as f64 * 1.7).sin();
    let layer = |outputs: usize, inputs: usize| {
        let weights: Vec<f64> = (0..outputs * inputs).map(value).collect();
        Dense::from_rows(&weights, (0..outputs).map(value).collect()).unwrap()
    };
    let activation = pam_core::Activation::from_name("leaky_relu").unwrap();
    NetworkForce::new(
        Mlp::new(vec![layer(96, 4), layer(96, 96), layer(1, 96)], activation).unwrap(),
    )
    .unwrap()
}

#[test]
fn steps_do_not_allocate() {
    let mut model = JointModel::datasheet(network());
    // The network is arbitrary and holds nothing back; damping keeps the motion small.
    model.auxiliary_damping_kg_s = 1e5;
    let masses = SealedMasses::new(0.06, 0.07).unwrap();
    let [pf, pe] = model.gas_law_pressures_kpa(0.0, masses);
    let allocations = |samples: usize, adaptive: bool, interpolation: Interpolation| {
        let times: Vec<f64> = (0..samples).map(|k| k as f64 * 1e-3).collect();
        let force: Vec<f64> = times.iter().map(|t| 1e5 * (3.0 * t).sin()).collect();
        let input = SampledInput::new(&times, &force, interpolation).unwrap();
        let term = Term::new(model.sealed(masses), input);
        let (t1, y0) = (times[samples - 1], [0.0, 0.0, pf, pe]);
        let constant = Integrator::new(Tableau::tsit5(), ConstantStep::new(1e-3));
        let controlled = Integrator::new(Tableau::tsit5(), PidController::new(1e-6, 1e-6));
        let before = crate::count();
        let solution = if adaptive {
            controlled.solve(&term, 0.0, t1, &y0, SaveAt::Times(&times))
        } else {
            constant.solve(&term, 0.0, t1, &y0, SaveAt::Times(&times))
        };
        let count = crate::count() - before;
        assert_eq!(solution.unwrap().len(), samples);
        count
    };
    for adaptive in [false, true] {
        for interpolation in [Interpolation::Hold, Interpolation::Linear, Interpolation::Cubic] {
            let _warm_up = allocations(50, adaptive, interpolation);
            let short = allocations(100, adaptive, interpolation);
            let long = allocations(3000, adaptive, interpolation);
            assert!(short > 0, "the counter counts");
            assert_eq!(short, long, "adaptive {adaptive}, {interpolation:?}");
        }
    }
}
