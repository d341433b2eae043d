use super::{ForceInput, ForceModel, ForceParts, StoredForce};
use crate::error::ModelError;
use crate::scalar::Scalar;

/// A linear spring–damper whose stiffness grows with the air in the joint and whose rest position
/// shifts with the difference between the muscles:
///
/// ```text
/// K = stiffness + stiffness_per_mass · (m_f + m_e)
/// f = K (x − shift_per_mass · (m_f − m_e)) + damping · ẋ
/// ```
///
/// All forces in mN, displacements in mm, masses in g, damping in kg/s (mN·s/mm). It is the
/// physics-only baseline, and with constant `K` it has a closed-form solution to test solvers
/// against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpringDamper<S> {
    /// Stiffness without air, mN/mm.
    pub stiffness_mn_mm: S,
    /// Growth of the stiffness with the sum of the air masses, mN/(mm·g).
    pub stiffness_per_mass_mn_mm_g: S,
    /// Shift of the rest position with the mass difference m_f − m_e, mm/g.
    pub shift_per_mass_mm_g: S,
    /// Damping, kg/s.
    pub damping_kg_s: S,
}

impl<S: Scalar> SpringDamper<S> {
    /// A spring of constant stiffness `stiffness_mn_mm` (mN/mm) and damping `damping_kg_s` (kg/s),
    /// at rest at x = 0 whatever the masses.
    pub fn constant(stiffness_mn_mm: S, damping_kg_s: S) -> Self {
        Self {
            stiffness_mn_mm,
            stiffness_per_mass_mn_mm_g: S::zero(),
            shift_per_mass_mm_g: S::zero(),
            damping_kg_s,
        }
    }

    /// The published joint as a straight line: 127.3 N/mm at 0.0315272 g in each muscle (170 kPa),
    /// 175.3 N/mm at 0.1211015 g (653 kPa), and the damping of 6500 kg/s with which the published
    /// curriculum starts. Unequal masses do not move its rest position.
    #[must_use]
    pub fn published() -> Self {
        let (low_g, high_g) = (2.0 * 0.031_527_2, 2.0 * 0.121_101_5);
        let per_mass = (175.3e3 - 127.3e3) / (high_g - low_g);
        Self {
            stiffness_mn_mm: S::constant(127.3e3 - per_mass * low_g),
            stiffness_per_mass_mn_mm_g: S::constant(per_mass),
            shift_per_mass_mm_g: S::zero(),
            damping_kg_s: S::constant(6500.0),
        }
    }

    /// The same force with other numbers.
    pub fn map<T>(&self, mut f: impl FnMut(S) -> T) -> SpringDamper<T> {
        SpringDamper {
            stiffness_mn_mm: f(self.stiffness_mn_mm),
            stiffness_per_mass_mn_mm_g: f(self.stiffness_per_mass_mn_mm_g),
            shift_per_mass_mm_g: f(self.shift_per_mass_mm_g),
            damping_kg_s: f(self.damping_kg_s),
        }
    }
}

impl<S: Scalar> ForceModel<S> for SpringDamper<S> {
    fn restoring_force_mn(&self, input: &ForceInput<S>, _work: &mut [S]) -> S {
        let total = input.mass_flexor_g + input.mass_extensor_g;
        let difference = input.mass_flexor_g - input.mass_extensor_g;
        let stiffness = self.stiffness_mn_mm + self.stiffness_per_mass_mn_mm_g * total;
        stiffness * (input.displacement_mm - self.shift_per_mass_mm_g * difference)
            + self.damping_kg_s * input.velocity_mm_s
    }
}

/// One tensor `spring_damper` of four numbers: stiffness, stiffness per mass, shift per mass, damping.
impl StoredForce for SpringDamper<f64> {
    fn scaled(&self, factor: f64) -> Option<Self> {
        Some(Self {
            shift_per_mass_mm_g: self.shift_per_mass_mm_g,
            ..self.map(|number| factor * number)
        })
    }

    fn to_parts(&self) -> ForceParts {
        let mut parts = ForceParts::default();
        parts.push_tensor(
            "spring_damper",
            vec![4],
            vec![
                self.stiffness_mn_mm,
                self.stiffness_per_mass_mn_mm_g,
                self.shift_per_mass_mm_g,
                self.damping_kg_s,
            ],
        );
        parts
    }

    fn from_parts(parts: &ForceParts) -> Result<Self, ModelError> {
        let [stiffness_mn_mm, stiffness_per_mass_mn_mm_g, shift_per_mass_mm_g, damping_kg_s] =
            parts.vector("spring_damper")?;
        Ok(Self { stiffness_mn_mm, stiffness_per_mass_mn_mm_g, shift_per_mass_mm_g, damping_kg_s })
    }

    fn describe(&self) -> String {
        "linear spring–damper".into()
    }
}
