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
    weights_len: usize,
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
        let weights_len = template.force.parameter_len();
        Self { template, weights_len, scaling, form, frozen, effects: Vec::new() }
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
        self.weights_len
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
