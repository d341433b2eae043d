//! A force model of one's own: a spring that hardens, `f = (k + k₃ x²) x + b ẋ` with `k` from the air.
//!
//! Written once over [`Scalar`] it simulates, differentiates and has a stiffness. [`StoredForce`] and `map` are for
//! files: to give it a name there, put all before `main` into `pam-core/src/force/hardening.rs` and add two lines:
//! `mod hardening;` in `mod.rs`, and `"hardening" => Hardening(super::hardening::HardeningSpring<S>),` in the
//! list of `any.rs`.

use num_dual::Dual64;
use pam_core::{
    Chambers, ForceInput, ForceModel, ForceParts, JointField, JointModel, ModelError,
    ParametricField, ParametricForce, Scalar, StoredForce, VectorField,
};

/// `f = (k₀ + k₁ (m_f + m_e) + k₃ x²) x + b ẋ`, in mN, mm, g, kg/s.
#[derive(Debug, Clone, PartialEq)]
pub struct HardeningSpring<S> {
    /// k₀, mN/mm.
    pub k0: S,
    /// k₁, mN/mm/g.
    pub k1: S,
    /// k₃, mN/mm³.
    pub k3: S,
    /// b, kg/s.
    pub b: S,
}

impl<S: Scalar> HardeningSpring<S> {
    /// The same with other numbers.
    pub fn map<T: Scalar>(&self, mut f: impl FnMut(S) -> T) -> HardeningSpring<T> {
        HardeningSpring { k0: f(self.k0), k1: f(self.k1), k3: f(self.k3), b: f(self.b) }
    }
}

impl<S: Scalar> ForceModel<S> for HardeningSpring<S> {
    fn restoring_force_mn(&self, at: &ForceInput<S>, _work: &mut [S]) -> S {
        let x = at.displacement_mm;
        let k = self.k0 + self.k1 * (at.mass_flexor_g + at.mass_extensor_g) + self.k3 * x * x;
        k * x + self.b * at.velocity_mm_s
    }
}

/// Its numbers can be exchanged: every gradient method then applies.
impl ParametricForce for HardeningSpring<f64> {
    type With<S: Scalar> = HardeningSpring<S>;
    fn parameters(&self) -> Vec<f64> {
        vec![self.k0, self.k1, self.k3, self.b]
    }
    fn with_parameters<S: Scalar>(&self, p: &[S]) -> HardeningSpring<S> {
        HardeningSpring { k0: p[0], k1: p[1], k3: p[2], b: p[3] }
    }
}

/// In files it is one tensor.
impl StoredForce for HardeningSpring<f64> {
    fn to_parts(&self) -> ForceParts {
        let mut parts = ForceParts::default();
        parts.push_tensor("numbers", vec![4], self.parameters());
        parts
    }
    fn from_parts(parts: &ForceParts) -> Result<Self, ModelError> {
        let numbers = &parts.require("numbers")?.values;
        let [k0, k1, k3, b] = numbers[..] else {
            return Err(ModelError::Shape(format!("{} numbers instead of four", numbers.len())));
        };
        Ok(Self { k0, k1, k3, b })
    }
    fn describe(&self) -> String {
        format!("hardening spring of {:.0} N/mm and more", self.k0 / 1e3)
    }
}

fn main() {
    let spring = HardeningSpring::<f64> { k0: 80e3, k1: 500e3, k3: 4e3, b: 6500.0 };
    let kept = HardeningSpring::from_parts(&spring.to_parts());
    assert_eq!(kept.as_ref(), Ok(&spring));
    let model = JointModel::datasheet(spring);
    let masses = model.gas_law_masses(0.0, [412.0, 412.0]); // kPa absolute, sealed at x = 0
    let [pf, pe] = model.gas_law_pressures_kpa(0.0, masses);

    // The hybrid vector field around it: m ẍ = F_e − f − B ẋ.
    let field = model.sealed(masses);
    let mut dy = [0.0; 4];
    field.eval_into(0.0, &[1.0, 0.0, pf, pe], &[0.0], &mut dy, &mut []);
    let air = masses.flexor_g + masses.extensor_g;
    let expected = -(80e3 + 500e3 * air + 4e3) / model.physical().mass_kg;
    assert!((dy[1] - expected).abs() < 1e-9 * expected.abs());

    // Stiffness ∂f/∂x, exact: k + 3 k₃ x².
    let numbers: Vec<Dual64> = model.force.parameters().into_iter().map(Dual64::from).collect();
    let dual = model.force.with_parameters(&numbers);
    let at = ForceInput {
        displacement_mm: Dual64::new(2.0, 1.0),
        velocity_mm_s: 0.0.into(),
        mass_flexor_g: masses.flexor_g.into(),
        mass_extensor_g: masses.extensor_g.into(),
    };
    let stiffness = dual.restoring_force_mn(&at, &mut []).eps;
    println!("K(2 mm) = {:.2} N/mm", stiffness / 1e3);
    assert!((stiffness - (80e3 + 500e3 * air + 3.0 * 4e3 * 4.0)).abs() < 1e-6);

    // The joint's parameters are those of the force and its own: m, C, ν, B, m_f, m_e.
    let joint = JointField::new(model, Chambers::Sealed(masses));
    assert_eq!(joint.parameter_len(), 4 + 6);
}
