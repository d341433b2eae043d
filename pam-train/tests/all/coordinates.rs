use approx::assert_relative_eq;
use pam_core::force::Dense;
use pam_core::{
    Activation, ForceInput, ForceModel, JointModel, Mlp, NetworkForce, ParametricForce,
    RawParameters, Scalar,
};
use pam_train::coordinates::{Coordinates, Frozen, PHYSICAL, PhysicalForm, Scaling};
use pam_trajectory::engine::NetworkJoint;

fn joint() -> NetworkJoint {
    let number = |k: usize| (0.7 * k as f64 + 0.3).sin();
    let rows = |n: usize, m: usize| (0..n * m).map(number).collect::<Vec<_>>();
    let layers = vec![
        Dense::from_rows(&rows(5, 4), (0..5).map(number).collect()).unwrap(),
        Dense::from_rows(&rows(3, 5), (0..3).map(number).collect()).unwrap(),
        Dense::from_rows(&rows(1, 3), vec![0.2]).unwrap(),
    ];
    let mlp = Mlp::new(layers, Activation::from_name("tanh").unwrap()).unwrap();
    JointModel::datasheet(NetworkForce::new(mlp).unwrap())
}

fn scaling() -> Scaling {
    Scaling { centre: [0.08, 0.07, 0.2, -0.5], width: [0.03, 0.02, 1.2, 6.0], force_mn: 1e5 }
}

fn force(model: &NetworkJoint, input: [f64; 4]) -> f64 {
    let [mass_flexor_g, mass_extensor_g, displacement_mm, velocity_mm_s] = input;
    let input = ForceInput { displacement_mm, velocity_mm_s, mass_flexor_g, mass_extensor_g };
    let mut work = vec![0.0; model.force.work_len()];
    model.force.restoring_force_mn(&input, &mut work)
}

#[test]
fn models_survive_their_coordinates() {
    for form in [PhysicalForm::Logarithm, PhysicalForm::Softplus] {
        let model = joint();
        let coordinates = Coordinates::new(model.clone(), scaling(), form, Frozen::default());
        let back = coordinates.model(&coordinates.of(&model));
        let input = [0.05, 0.1, -1.1, 7.0];
        assert_relative_eq!(force(&back, input), force(&model, input), max_relative = 1e-9);
        assert_relative_eq!(back.raw.mass, model.raw.mass, max_relative = 1e-12);
    }
}

/// The coordinates are the weights of a network between scaled inputs and a scaled output.
#[test]
fn coordinates_are_the_weights_of_a_scaled_network() {
    let model = joint();
    let s = scaling();
    let coordinates =
        Coordinates::new(model.clone(), s, PhysicalForm::Logarithm, Frozen::default());
    let at = coordinates.of(&model);
    let inner = JointModel::datasheet(model.force.with_parameters(&at[..at.len() - PHYSICAL]));
    let input = [0.05, 0.1, -1.1, 7.0];
    let scaled = std::array::from_fn(|i| (input[i] - s.centre[i]) / s.width[i]);
    assert_relative_eq!(
        s.force_mn * force(&inner, scaled),
        force(&model, input),
        max_relative = 1e-9
    );
}

#[test]
fn gradients_follow_the_chain_rule() {
    let model = joint();
    let input = [0.05, 0.1, -1.1, 7.0];
    // A made-up loss whose derivative by every number of the model is known by differences.
    let loss = |m: &NetworkJoint| {
        let p = m.physical();
        force(m, input).powi(2) + 1e-3 * p.mass_kg + 1e-9 * p.gas_coefficient + p.deformation.sin()
    };
    let weights = model.force.parameters();
    let own: Vec<f64> = (0..weights.len())
        .map(|i| {
            let at = |h: f64| {
                let mut w = weights.clone();
                w[i] += h;
                let mut m = model.clone();
                m.force = model.force.with_parameters(&w);
                loss(&m)
            };
            (at(1e-6) - at(-1e-6)) / 2e-6
        })
        .collect();
    let p = model.physical();
    let raw = RawParameters { mass: 1e-3, gas_coefficient: 1e-9, deformation: p.deformation.cos() };
    let raw = RawParameters {
        mass: raw.mass * model.raw.mass.sigmoid(),
        gas_coefficient: raw.gas_coefficient * model.raw.gas_coefficient.sigmoid(),
        deformation: raw.deformation * model.raw.deformation.sigmoid(),
    };
    for form in [PhysicalForm::Logarithm, PhysicalForm::Softplus] {
        let coordinates = Coordinates::new(model.clone(), scaling(), form, Frozen::default());
        let at = coordinates.of(&model);
        let gradient = coordinates.gradient_of(&model, &own, &raw);
        for i in (0..at.len()).step_by(4).chain(at.len() - 3..at.len()) {
            let h = 1e-6 * at[i].abs().max(1e-2);
            let shifted = |h: f64| {
                let mut at = at.clone();
                at[i] += h;
                loss(&coordinates.model(&at))
            };
            let slope = (shifted(h) - shifted(-h)) / (2.0 * h);
            assert_relative_eq!(
                gradient[i],
                slope,
                max_relative = 2e-4,
                epsilon = 1e-4 * gradient[0].abs()
            );
        }
    }
}

#[test]
fn frozen_groups_have_no_gradient() {
    let model = joint();
    let frozen = Frozen { network: true, mass: true, ..Frozen::default() };
    let coordinates = Coordinates::new(model.clone(), scaling(), PhysicalForm::default(), frozen);
    let ones = vec![1.0; model.force.parameter_len()];
    let raw = RawParameters { mass: 1.0, gas_coefficient: 1.0, deformation: 1.0 };
    let g = coordinates.gradient_of(&model, &ones, &raw);
    assert!(g[..ones.len() + 1].iter().all(|v| *v == 0.0));
    assert!(g[ones.len() + 1..].iter().all(|v| *v != 0.0));
}
