//! A rate-independent loop with memory.

use crate::effects::{Effect, EffectInfo, Evidence, Group, ParameterInfo, Point};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

const INFO: EffectInfo = EffectInfo {
    id: "hysteresis",
    group: Group::Mechanics,
    what: "loop with memory that does not depend on the rate",
    parameters: &[
        ParameterInfo::linear("force_n", [0.0, 1e3]),
        ParameterInfo::scale("slip_mm", [5e-3, 20.0]),
    ],
    switches: &[],
    excited_by: "motion of several amplitudes, with inner loops",
};

/// Maxwell slip: elements of equal limit, `force_n` together, whose slip distances are spread evenly up to
/// `slip_mm` (Iwan 1966). Saturates after `slip_mm` of travel from the virgin state.
#[derive(Debug, Clone, Copy)]
pub struct Hysteresis;

impl Effect for Hysteresis {
    fn info(&self) -> &'static EffectInfo {
        &INFO
    }

    fn starts(&self, evidence: &Evidence) -> Vec<Vec<f64>> {
        let travel = evidence.travel_mm;
        let slips = [0.03, 0.15, 0.6];
        slips.map(|s| vec![0.12 * evidence.force_n, s * travel]).to_vec()
    }

    fn memory_len(&self) -> usize {
        ELEMENTS
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let travel = at.displacement_mm - at.step_start_mm;
        let sum = stretch(p, travel, memory).fold(S::zero(), |sum, z| sum + z);
        -(p[0] * sum).scaled(MN_PER_N / ELEMENTS as f64)
    }

    fn advance<S: Scalar>(&self, p: &[S], _step_s: f64, from: S, to: S, memory: &mut [S]) {
        let mut after = [S::zero(); ELEMENTS];
        for (new, z) in after.iter_mut().zip(stretch(p, to - from, memory)) {
            *new = z;
        }
        memory.copy_from_slice(&after);
    }
}

/// Number of elements.
const ELEMENTS: usize = 8;

/// The elements' share of their limit, −1 to 1, after `travel` (mm) from `memory`.
fn stretch<'a, S: Scalar>(p: &[S], travel: S, memory: &'a [S]) -> impl Iterator<Item = S> + 'a {
    let first = travel / p[1];
    let one = S::constant(1.0);
    memory
        .iter()
        .enumerate()
        .map(move |(j, &z)| (z + first.scaled(ELEMENTS as f64 / (j + 1) as f64)).clamped(-one, one))
}
