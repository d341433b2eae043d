//! Physics only: the joint as a linear spring and damper.
//!
//! ```text
//! m ẍ = F − K (x − s (m_f − m_e)) − B ẋ        K = k₀ + k₁ (m_f + m_e)
//! ```
//!
//! All of m, B, k₀, k₁ and s are found by least squares on the equation of motion of the training
//! recordings; nothing is learned beyond these five numbers.

use crate::error::BaselineError;
use crate::joint::{JointBaseline, JointForce, gas_of, masses_of};
use crate::method::{FittedModel, Method, Structure, TrainingSet, is_positive};
use crate::points::motion_points;
use num_dual::Dual64;
use pam_core::{Scalar, SpringDamper};
use pam_data::formats::npz::Array;
use pam_numerics::least_squares;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Distance of the points that are regressed on, s.
const SPACING_S: f64 = 0.01;

/// The linear joint.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LinearJoint {}

impl JointForce for SpringDamper<f64> {
    type Dual = SpringDamper<Dual64>;

    fn dual(&self) -> Self::Dual {
        self.map(Dual64::constant)
    }

    fn parameter_count(&self) -> usize {
        4
    }

    fn structure(&self) -> Structure {
        Structure::Physical
    }

    fn details(&self) -> Value {
        json!({
            "stiffness_mn_mm": self.stiffness_mn_mm,
            "stiffness_per_mass_mn_mm_g": self.stiffness_per_mass_mn_mm_g,
            "shift_per_mass_mm_g": self.shift_per_mass_mm_g,
            "damping_kg_s": self.damping_kg_s,
        })
    }

    fn arrays(&self) -> BTreeMap<String, Array> {
        let values = vec![
            self.stiffness_mn_mm,
            self.stiffness_per_mass_mn_mm_g,
            self.shift_per_mass_mm_g,
            self.damping_kg_s,
        ];
        BTreeMap::from([("spring_damper".into(), Array::vector(values))])
    }
}

impl Method for LinearJoint {
    fn title(&self) -> String {
        "Linear spring–damper".into()
    }

    fn fit(
        &self,
        training: &TrainingSet<'_>,
        _progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn FittedModel>, BaselineError> {
        let mut physical = gas_of(training.subjects);
        // The products K s (m_f − m_e) are linear in k₀ s and k₁ s: s is found in a first fit with
        // free products, and held in a second one.
        let rows = |shift: Option<f64>| {
            let mut all = Vec::new();
            for s in training.subjects {
                let masses = masses_of(&s.recording, &physical);
                let (sum, difference) =
                    (masses.flexor_g + masses.extensor_g, masses.flexor_g - masses.extensor_g);
                for p in motion_points(&s.recording, SPACING_S) {
                    let x = p.displacement_mm - shift.unwrap_or(0.0) * difference;
                    let own = if shift.is_none() { difference } else { 0.0 };
                    let (a, v) = (p.acceleration_mm_s2, p.velocity_mm_s);
                    all.push(([a, v, x, x * sum, own, own * sum], p.force_mn));
                }
            }
            all
        };
        let dependent = || {
            BaselineError::unfit(
                "Linear spring–damper",
                "the training recordings do not distinguish mass, damping and stiffness; they must \
                 move at more than one frequency and hold more than one amount of air",
            )
        };
        let [_, _, k0, k1, c0, c1] =
            least_squares(rows(None).into_iter(), 1e-10).ok_or_else(dependent)?;
        // s such that −s (k₀ + k₁ Σm) follows c₀ + c₁ Σm over the recordings.
        let sums: Vec<f64> = training
            .subjects
            .iter()
            .map(|s| masses_of(&s.recording, &physical))
            .map(|m| m.flexor_g + m.extensor_g)
            .collect();
        let (top, bottom) = sums.iter().fold((0.0, 0.0), |(t, b), m| {
            let (k, c) = (k0 + k1 * m, c0 + c1 * m);
            (t - k * c, b + k * k)
        });
        let shift = top / bottom;
        let second = rows(Some(shift));
        let second = second.into_iter().map(|([a, v, x, xs, ..], f)| ([a, v, x, xs], f));
        let [mass, damping, k0, k1] = least_squares(second, 0.0).ok_or_else(dependent)?;
        if !(is_positive(mass) && shift.is_finite()) {
            return Err(dependent());
        }
        physical.mass_kg = mass;
        let force = SpringDamper {
            stiffness_mn_mm: k0,
            stiffness_per_mass_mn_mm_g: k1,
            shift_per_mass_mm_g: shift,
            damping_kg_s: damping,
        };
        Ok(Box::new(JointBaseline::new(physical, force)?))
    }
}
