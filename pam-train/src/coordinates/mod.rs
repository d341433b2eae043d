//! The vector of numbers that an optimiser moves, and how it relates to a model.
//!
//! The published path moves the network's weights as they are and the physical parameters before
//! softplus. Inputs of a force network differ by three orders of magnitude (0.03 g, 20 mm/s) and its
//! output is 10⁵ mN, so that one step size fits no two weights; and C = 8.47e7 hardly moves at all. The
//! coordinates here can therefore be those of a network between scaled inputs and a scaled output, with
//! logarithms of the physical parameters. The model that they stand for is the same, weight by weight. The
//! parameters of effects come last.

mod effect;
mod scaling;

pub use effect::EffectCoordinate;
pub use scaling::Scaling;

use pam_core::{ParametricForce, PhysicalParameters, Scalar};
use pam_trajectory::engine::{NetworkJoint, TrajectoryGradient};
use serde::{Deserialize, Serialize};

/// Number of physical parameters: mass, gas coefficient, deformation.
pub const PHYSICAL: usize = 3;

/// Which groups of numbers stay as they are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Frozen {
    /// All weights and biases.
    pub network: bool,
    /// The reflected mass m.
    pub mass: bool,
    /// The gas coefficient C.
    pub gas_coefficient: bool,
    /// The deformation coefficient ν.
    pub deformation: bool,
    /// The parameters of effects.
    pub effects: bool,
}

/// In which form the physical parameters are moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PhysicalForm {
    /// Their logarithms.
    #[default]
    Logarithm,
    /// Before softplus, as in the published code.
    Softplus,
}

/// The coordinates of the models of one shape: network parameters in the order of
/// [`ParametricForce`], then mass, gas coefficient and deformation, then the parameters of effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Coordinates {
    template: NetworkJoint,
    scaling: Scaling,
    form: PhysicalForm,
    frozen: Frozen,
    effects: Vec<EffectCoordinate>,
}

impl Coordinates {
    /// Coordinates for models like `template`, which gives what is not moved: shape, activation,
    /// geometry, auxiliary damping.
    #[must_use]
    pub fn new(
        template: NetworkJoint,
        scaling: Scaling,
        form: PhysicalForm,
        frozen: Frozen,
    ) -> Self {
        Self { template, scaling, form, frozen, effects: Vec::new() }
    }

    /// The same coordinates followed by those of effects.
    #[must_use]
    pub fn with_effects(self, effects: Vec<EffectCoordinate>) -> Self {
        Self { effects, ..self }
    }

    /// The coordinates of the effects.
    #[must_use]
    pub fn effects(&self) -> &[EffectCoordinate] {
        &self.effects
    }

    /// The parameters of the effects at coordinates.
    #[must_use]
    pub fn effect_parameters(&self, at: &[f64]) -> Vec<f64> {
        let own = &at[self.weights_len() + PHYSICAL..];
        self.effects.iter().zip(own).map(|(c, &at)| c.value(at)).collect()
    }

    /// Brings the parameters of the effects back into their ranges.
    pub fn project(&self, at: &mut [f64]) {
        let own = &mut at[self.weights_len() + PHYSICAL..];
        for (c, at) in self.effects.iter().zip(own) {
            let value = c.value(*at);
            if value <= c.range[0] || value >= c.range[1] {
                *at = c.at(value);
            }
        }
    }

    /// Number of the network's weights and biases, which stand first.
    #[must_use]
    pub fn weights_len(&self) -> usize {
        self.template.force.parameter_len()
    }

    /// The same coordinates with other groups that stay as they are.
    #[must_use]
    pub fn with_frozen(&self, frozen: Frozen) -> Self {
        Self { frozen, ..self.clone() }
    }

    /// Which groups stay as they are.
    #[must_use]
    pub fn frozen(&self) -> Frozen {
        self.frozen
    }

    /// Number of coordinates.
    #[must_use]
    pub fn len(&self) -> usize {
        self.weights_len() + PHYSICAL + self.effects.len()
    }

    /// Never: there are always physical parameters.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The auxiliary damping of the models, kg/s.
    #[must_use]
    pub fn auxiliary_damping_kg_s(&self) -> f64 {
        self.template.auxiliary_damping_kg_s
    }

    /// Prescribes another auxiliary damping, kg/s.
    pub fn set_auxiliary_damping(&mut self, damping_kg_s: f64) {
        self.template.auxiliary_damping_kg_s = damping_kg_s;
    }

    /// The coordinates of a model, with the effects as they start.
    #[must_use]
    pub fn of(&self, model: &NetworkJoint) -> Vec<f64> {
        let mut at = model.force.parameters();
        self.scaling.scale_weights(&self.template.force, &mut at);
        let p = model.physical();
        at.extend(match self.form {
            PhysicalForm::Logarithm => [p.mass_kg.ln(), p.gas_coefficient.ln(), p.deformation.ln()],
            PhysicalForm::Softplus => {
                [model.raw.mass, model.raw.gas_coefficient, model.raw.deformation]
            }
        });
        at.extend(self.effects.iter().map(|c| c.at(c.start)));
        at
    }

    /// The model at coordinates.
    ///
    /// # Panics
    /// If there are not [`len`](Self::len) of them.
    #[must_use]
    pub fn model(&self, at: &[f64]) -> NetworkJoint {
        let (network, physical) = at.split_at(self.weights_len());
        let mut weights = network.to_vec();
        self.scaling.unscale_weights(&self.template.force, &mut weights);
        let mut model = self.template.clone();
        model.force = self.template.force.with_parameters(&weights);
        model.raw = match self.form {
            PhysicalForm::Logarithm => PhysicalParameters {
                mass_kg: physical[0].exp(),
                gas_coefficient: physical[1].exp(),
                deformation: physical[2].exp(),
            }
            .to_raw(),
            PhysicalForm::Softplus => pam_core::RawParameters {
                mass: physical[0],
                gas_coefficient: physical[1],
                deformation: physical[2],
            },
        };
        model
    }

    /// The gradient by the coordinates of `model` from that by its own numbers: weights (in their
    /// order) and physical parameters before softplus. Zero for what is frozen and for effects.
    #[must_use]
    pub fn gradient_of(
        &self,
        model: &NetworkJoint,
        weights: &[f64],
        raw: &pam_core::RawParameters,
    ) -> Vec<f64> {
        let mut by = weights.to_vec();
        if self.frozen.network {
            by.fill(0.0);
        } else {
            self.scaling.pull_back(&self.template.force, &mut by);
        }
        let p = model.physical();
        // dp/d ln p = p, and softplus' is the logistic function.
        let form = |by_raw: f64, raw: f64, value: f64| match self.form {
            PhysicalForm::Logarithm => by_raw / raw.sigmoid() * value,
            PhysicalForm::Softplus => by_raw,
        };
        let free = |frozen: bool, g: f64| if frozen { 0.0 } else { g };
        let own = &model.raw;
        by.push(free(self.frozen.mass, form(raw.mass, own.mass, p.mass_kg)));
        by.push(free(
            self.frozen.gas_coefficient,
            form(raw.gas_coefficient, own.gas_coefficient, p.gas_coefficient),
        ));
        by.push(free(
            self.frozen.deformation,
            form(raw.deformation, own.deformation, p.deformation),
        ));
        by.resize(self.len(), 0.0);
        by
    }

    /// Writes the part of the effects into a gradient by the coordinates, from the gradient by their parameters.
    pub fn write_effect_gradient(&self, at: &[f64], by_values: &[f64], gradient: &mut [f64]) {
        if self.frozen.effects {
            return;
        }
        let first = self.weights_len() + PHYSICAL;
        for (k, (c, &by)) in self.effects.iter().zip(by_values).enumerate() {
            gradient[first + k] = c.pull_back(at[first + k], by);
        }
    }

    /// The gradient of a loss by the coordinates.
    #[must_use]
    pub fn gradient(&self, model: &NetworkJoint, gradient: &TrajectoryGradient) -> Vec<f64> {
        self.gradient_of(model, &gradient.force, &gradient.raw)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use pam_core::force::Dense;
    use pam_core::{
        Activation, ForceInput, ForceModel, JointModel, Mlp, NetworkForce, RawParameters,
    };

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
            force(m, input).powi(2)
                + 1e-3 * p.mass_kg
                + 1e-9 * p.gas_coefficient
                + p.deformation.sin()
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
        let raw =
            RawParameters { mass: 1e-3, gas_coefficient: 1e-9, deformation: p.deformation.cos() };
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
        let coordinates =
            Coordinates::new(model.clone(), scaling(), PhysicalForm::default(), frozen);
        let ones = vec![1.0; model.force.parameter_len()];
        let raw = RawParameters { mass: 1.0, gas_coefficient: 1.0, deformation: 1.0 };
        let g = coordinates.gradient_of(&model, &ones, &raw);
        assert!(g[..ones.len() + 1].iter().all(|v| *v == 0.0));
        assert!(g[ones.len() + 1..].iter().all(|v| *v != 0.0));
    }
}
