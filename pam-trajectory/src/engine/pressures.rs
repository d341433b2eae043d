//! Pressures of sealed chambers along a motion, and their cotangents.

use pam_core::{JointModel, MuscleGeometry, PhysicalParameters, SealedMasses};

/// The gas of one recording: `P_i(t) = P_i(0) + C m_i [1/V_i(x(t)) − 1/V_i(x(0))]`, the exact integral
/// of the model's pressure equation with closed valves.
#[derive(Debug, Clone, Copy)]
pub struct SealedGas {
    geometry: MuscleGeometry,
    physical: PhysicalParameters,
    masses: [f64; 2],
    start_mm: f64,
    start_kpa: [f64; 2],
}

/// Cotangents of what the pressures depend on besides the motion.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct GasCotangents {
    /// Of the gas coefficient C.
    pub gas_coefficient: f64,
    /// Of the deformation coefficient ν.
    pub deformation: f64,
    /// Of the masses of flexor and extensor.
    pub masses: [f64; 2],
    /// Of the initial pressures of flexor and extensor.
    pub start_kpa: [f64; 2],
    /// Of the initial displacement.
    pub start_mm: f64,
}

/// `1/V` of both chambers with its derivatives.
#[derive(Clone, Copy)]
struct Inverse {
    value: [f64; 2],
    by_x: [f64; 2],
    by_deformation: [f64; 2],
}

impl SealedGas {
    /// The gas of a recording that starts at `initial_state`.
    pub fn new<F>(
        model: &JointModel<f64, F>,
        masses: SealedMasses,
        initial_state: [f64; 4],
    ) -> Self {
        Self {
            geometry: model.geometry,
            physical: model.physical(),
            masses: [masses.flexor_g, masses.extensor_g],
            start_mm: initial_state[0],
            start_kpa: [initial_state[2], initial_state[3]],
        }
    }

    #[inline]
    fn inverse_volumes(&self, x: f64) -> Inverse {
        let v = self.geometry.volumes(x, self.physical.deformation);
        let by_deformation =
            self.geometry.volume_slopes_by_deformation(x, self.physical.deformation);
        let value = [1.0 / v.flexor_mm3, 1.0 / v.extensor_mm3];
        let squares = [value[0] * value[0], value[1] * value[1]];
        Inverse {
            value,
            by_x: [-v.flexor_slope_mm2 * squares[0], -v.extensor_slope_mm2 * squares[1]],
            by_deformation: [-by_deformation[0] * squares[0], -by_deformation[1] * squares[1]],
        }
    }

    /// Writes `[x, ẋ, P_f, P_e]` for a motion `[times, (x, ẋ)]`.
    pub fn complete(&self, motion: &[f64], states: &mut [[f64; 4]]) {
        let c = self.physical.gas_coefficient;
        let then = self.geometry.volumes(self.start_mm, self.physical.deformation);
        let then = [1.0 / then.flexor_mm3, 1.0 / then.extensor_mm3];
        for (state, motion) in states.iter_mut().zip(motion.chunks_exact(2)) {
            let v = self.geometry.volumes(motion[0], self.physical.deformation);
            let now = [1.0 / v.flexor_mm3, 1.0 / v.extensor_mm3];
            let p = |i: usize| self.start_kpa[i] + c * self.masses[i] * (now[i] - then[i]);
            *state = [motion[0], motion[1], p(0), p(1)];
        }
    }

    /// Pulls cotangents of the full states back: adds to those of the motion, and returns those of
    /// everything else.
    pub fn pull_back(
        &self,
        motion: &[f64],
        states: &[[f64; 4]],
        motion_cotangents: &mut [f64],
    ) -> GasCotangents {
        let c = self.physical.gas_coefficient;
        let then = self.inverse_volumes(self.start_mm);
        // Of each muscle, sums of the pressure's cotangent p times 1, 1/V and its derivative by ν, the
        // latter two less what they are at the start.
        let (mut one, mut by_volume, mut by_deformation) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for ((motion, w), sum) in
            motion.chunks_exact(2).zip(states).zip(motion_cotangents.chunks_exact_mut(2))
        {
            let now = self.inverse_volumes(motion[0]);
            let mut along_x = w[0];
            for i in 0..2 {
                let p = w[i + 2];
                along_x += p * c * self.masses[i] * now.by_x[i];
                one[i] += p;
                by_volume[i] += p * (now.value[i] - then.value[i]);
                by_deformation[i] += p * (now.by_deformation[i] - then.by_deformation[i]);
            }
            sum[0] += along_x;
            sum[1] += w[1];
        }
        let mut sums = GasCotangents { start_kpa: one, ..GasCotangents::default() };
        for (i, mass) in self.masses.into_iter().enumerate() {
            sums.start_mm -= c * mass * then.by_x[i] * one[i];
            sums.deformation += c * mass * by_deformation[i];
            sums.gas_coefficient += mass * by_volume[i];
            sums.masses[i] = c * by_volume[i];
        }
        sums
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_relative_eq;
    use pam_core::SpringDamper;

    /// Every cotangent against a central difference of the forward map.
    #[test]
    fn cotangents_match_differences() {
        let model = JointModel::datasheet(SpringDamper::<f64>::published());
        let masses = SealedMasses::new(0.05, 0.08).unwrap();
        let start = [0.3, 1.0, 390.0, 420.0];
        let motion = [0.3, 1.0, -0.7, 2.0, 1.4, -3.0];
        let w = [[0.1, -0.2, 0.3, 0.5], [0.7, 0.2, -0.4, 0.6], [-0.3, 0.9, 0.8, -0.1]];
        let value = |gas: &SealedGas, motion: &[f64]| {
            let mut states = [[0.0; 4]; 3];
            gas.complete(motion, &mut states);
            states.iter().flatten().zip(w.iter().flatten()).map(|(s, w)| s * w).sum::<f64>()
        };
        let gas = SealedGas::new(&model, masses, start);
        let mut back = [0.0; 6];
        let sums = gas.pull_back(&motion, &w, &mut back);
        let central = |change: &dyn Fn(&mut SealedGas, &mut [f64; 6], f64), h: f64| {
            let at = |h: f64| {
                let (mut gas, mut motion) = (gas, motion);
                change(&mut gas, &mut motion, h);
                value(&gas, &motion)
            };
            (at(h) - at(-h)) / (2.0 * h)
        };
        for i in 0..6 {
            let fd = central(&|_, m, h| m[i] += h, 1e-4);
            assert_relative_eq!(back[i], fd, max_relative = 1e-6);
        }
        let check = |exact: f64, fd: f64| assert_relative_eq!(exact, fd, max_relative = 1e-6);
        check(sums.gas_coefficient, central(&|g, _, h| g.physical.gas_coefficient += h, 1e3));
        check(sums.deformation, central(&|g, _, h| g.physical.deformation += h, 1e-4));
        check(sums.start_mm, central(&|g, _, h| g.start_mm += h, 1e-4));
        for i in 0..2 {
            check(sums.masses[i], central(&|g, _, h| g.masses[i] += h, 1e-5));
            check(sums.start_kpa[i], central(&|g, _, h| g.start_kpa[i] += h, 1e-2));
        }
    }
}
