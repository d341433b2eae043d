//! The joint with sealed chambers, moved by a sine.

use super::network;
use crate::gradients::case::{Case, evenly, half_squares};
use crate::gradients::kinked::KinkedJoint;
use pam_core::{
    Activation, ActivationFunction, JointField, JointModel, NetworkForce, SealedMasses,
};
use pam_solvers::InputFn;
use std::f64::consts::TAU;

/// Name of the problem.
pub const NAME: &str = "joint";
/// Name of the problem with the published network's size.
pub const PUBLISHED_SIZE: &str = "joint-published-size";
/// Width of the published network, whose activation is LeakyReLU.
pub const PUBLISHED_WIDTH: usize = 96;

/// A force without parameters.
pub type Drive = InputFn<fn(f64, &mut [f64])>;
/// The joint with its own network.
pub type Joint = JointField<f64, NetworkForce<f64>>;

/// The tendon force, mN: two sines, some 60 N each.
fn drive(t: f64, u: &mut [f64]) {
    u[0] = 60e3 * ((TAU * 0.7 * t + 0.4).sin() + (TAU * 2.3 * t).sin());
}

/// The reference of the motion: about the motion of a straight spring.
#[must_use]
pub fn target(t: f64) -> [f64; 4] {
    let (x, v) = motion_target(t);
    [x, v, 412.0, 412.0]
}

fn motion_target(t: f64) -> (f64, f64) {
    let w = TAU * 0.7;
    (0.4 * (w * t).sin(), 0.4 * w * (w * t).cos())
}

/// The force, for solvers.
#[must_use]
pub fn input() -> Drive {
    InputFn::new(1, drive)
}

/// The model with its network.
#[must_use]
pub fn model(activation: Activation, width: usize) -> JointModel<f64, NetworkForce<f64>> {
    let mut model = JointModel::datasheet(network::force(activation, width));
    model.auxiliary_damping_kg_s = 200.0;
    model
}

/// The air of trajectory `index` of a set, g.
#[must_use]
pub fn masses(index: usize) -> SealedMasses {
    let part = (index as f64 * 0.618_033_988_7).fract();
    SealedMasses { flexor_g: 0.07 + 0.02 * part, extensor_g: 0.09 - 0.02 * part }
}

/// Initial state for that air, `[x, ẋ, P_f, P_e]`.
#[must_use]
pub fn start(model: &JointModel<f64, NetworkForce<f64>>, masses: SealedMasses) -> [f64; 4] {
    let [pf, pe] = model.gas_law_pressures_kpa(0.2, masses);
    [0.2, 0.0, pf, pe]
}

/// The joint up to `horizon_s`, observed at every twentieth of a second at the latest, with a loss of
/// motion and pressures.
#[must_use]
pub fn case(activation: Activation, width: usize, horizon_s: f64) -> Case<Joint, Drive> {
    let scales = [0.3, 4.0, 20.0, 20.0];
    let model = model(activation, width);
    let masses = masses(0);
    let y0 = start(&model, masses);
    let network_len = model.force.mlp().parameter_count();
    let field = JointField::new(model.clone(), pam_core::Chambers::Sealed(masses));
    let loss = half_squares(target, scales);
    let mut case = Case::new(NAME, (field, input()), &y0, observations_s(horizon_s), loss);
    case.activation = Some(activation.name().into());
    case.width = Some(width);
    case.groups = vec![network_len];
    if activation.relu_slope().is_some() {
        let observations_s = case.observations_s.clone();
        case.closed_form = Some(Box::new(move || {
            kinked(&model, masses, y0, &observations_s).truth(&half_squares(target, scales))
        }));
    }
    case
}

/// The loss of the motion alone, for states `[x, ẋ]`.
pub fn motion_loss() -> impl Fn(&[f64], &[f64], &mut [f64]) -> f64 {
    half_squares(|t| motion_target(t).into(), [0.3, 4.0])
}

/// The same for the published network's size and activation.
#[must_use]
pub fn published_size(horizon_s: f64) -> Case<Joint, Drive> {
    let activation = Activation::LeakyRelu(Default::default());
    let mut case = case(activation, PUBLISHED_WIDTH, horizon_s);
    case.name = PUBLISHED_SIZE.into();
    case
}

/// When a solve up to `horizon_s` is observed, s.
#[must_use]
pub fn observations_s(horizon_s: f64) -> Vec<f64> {
    evenly((20.0 * horizon_s).round().max(1.0) as usize, horizon_s)
}

/// The method that gives the reference for a joint with kinks.
#[must_use]
pub fn kinked<'a>(
    model: &'a JointModel<f64, NetworkForce<f64>>,
    masses: SealedMasses,
    start: [f64; 4],
    observations_s: &'a [f64],
) -> KinkedJoint<'a> {
    KinkedJoint { model, masses, drive, start, observations_s }
}
