//! A rate-independent loop with memory.

use crate::effects::{DataScales, Effect, EffectInfo, Hooks, Point, entry};
use pam_core::Scalar;
use pam_core::units::MN_PER_N;

/// A force that saturates at `force_n` after about `slip_mm` of travel, in one of four shapes that the
/// switch chooses:
///
/// * 0: Maxwell slip, very many elements of equal limit whose slip distances are spread evenly from 0 to `slip_mm`
///   (Iwan 1966); their sum is a Gauss–Legendre quadrature of twelve points;
/// * 1 or 2: Bouc–Wen with this exponent and β = γ = ½, `dz/dx = (1 − |z|ⁿ [z dx > 0]) / slip_mm`
///   (Wen 1976), solved exactly between reversals;
/// * from 10: the limit of a large exponent, one element that is elastic up to `slip_mm` and then slips (Prandtl 1928).
#[derive(Debug, Clone, Copy)]
pub struct Hysteresis;

/// Elements of the Maxwell shape: slip distance relative to the largest, and share of the force. They are the points and weights of the
/// Gauss–Legendre quadrature on [0, 1] (Golub and Welsch 1969).
const ELEMENTS: [[f64; 2]; 12] = [
    [0.0092196828766404, 0.0235876681932557],
    [0.0479413718147626, 0.0534696629976595],
    [0.1150486629028477, 0.0800391642716732],
    [0.2063410228566913, 0.1015837133615329],
    [0.3160842505009099, 0.1167462682691773],
    [0.4373832957442655, 0.1245735229067013],
    [0.5626167042557344, 0.1245735229067013],
    [0.6839157494990901, 0.1167462682691773],
    [0.7936589771433087, 0.1015837133615329],
    [0.8849513370971523, 0.0800391642716732],
    [0.9520586281852375, 0.0534696629976595],
    [0.9907803171233596, 0.0235876681932557],
];

/// Exponent from which the loop counts as that of one element.
const ELASTIC: f64 = 10.0;

impl Effect for Hysteresis {
    fn info(&self) -> &'static EffectInfo {
        const { entry("hysteresis") }
    }

    fn hooks(&self) -> Hooks {
        Hooks { force: true, advance: true, ..Hooks::NONE }
    }

    fn starts(&self, scales: &DataScales) -> Vec<Vec<f64>> {
        let slips = [0.06, 0.4].map(|share| share * scales.travel_mm);
        let shapes = [0.0, 1.0, 2.0, 100.0];
        let force = 0.12 * scales.force_n;
        shapes.iter().flat_map(|&shape| slips.map(|slip| vec![force, slip, shape])).collect()
    }

    fn stands(&self, values: &[f64], scales: &DataScales) -> bool {
        // A loop that saturates at once is dry friction; one that never does is a spring.
        (0.05..10.0).contains(&(values[1] / scales.travel_mm))
    }

    fn memory_len(&self) -> usize {
        ELEMENTS.len()
    }

    fn force_mn<S: Scalar>(&self, p: &[S], at: &Point<'_, S>, memory: &[S]) -> S {
        let travel = at.displacement_mm - at.step_start.displacement_mm;
        let share = if p[2].real() < 0.5 {
            let elements = stretch(p, travel, memory).zip(ELEMENTS);
            elements.fold(S::zero(), |sum, (z, [_, share])| sum + z.scaled(share))
        } else {
            bouc_wen(p, travel, memory[0])
        };
        -(p[0] * share).scaled(MN_PER_N)
    }

    fn advance<S: Scalar>(&self, p: &[S], end: &Point<'_, S>, memory: &mut [S]) {
        let travel = end.displacement_mm - end.step_start.displacement_mm;
        if p[2].real() < 0.5 {
            let mut after = [S::zero(); ELEMENTS.len()];
            for (new, z) in after.iter_mut().zip(stretch(p, travel, memory)) {
                *new = z;
            }
            memory.copy_from_slice(&after);
        } else {
            memory[0] = bouc_wen(p, travel, memory[0]);
        }
    }
}

/// The elements' share of their limit, −1 to 1, after `travel` (mm) from `memory`.
fn stretch<'a, S: Scalar>(p: &[S], travel: S, memory: &'a [S]) -> impl Iterator<Item = S> + 'a {
    let first = travel / p[1];
    let one = S::constant(1.0);
    let elements = memory.iter().zip(ELEMENTS);
    elements.map(move |(&z, [slip, _])| (z + first.scaled(1.0 / slip)).clamped(-one, one))
}

/// The variable z of Bouc and Wen after `travel` (mm) from `z`.
fn bouc_wen<S: Scalar>(p: &[S], travel: S, z: S) -> S {
    let way = travel / p[1];
    let forward = way.real() >= 0.0;
    // In the direction of travel: unloading is a straight line to zero, then the loop saturates.
    let (way, z) = if forward { (way, z) } else { (-way, -z) };
    let one = S::constant(1.0);
    let (start, left) = if z.real() < 0.0 {
        let straight = z + way;
        if straight.real() <= 0.0 {
            return if forward { straight } else { -straight };
        }
        (S::zero(), straight)
    } else {
        (z, way)
    };
    let after = if p[2].real() >= ELASTIC {
        (start + left).minimum(one)
    } else if p[2].real() < 1.5 {
        one - (one - start) * (-left).exp()
    } else {
        // tanh(artanh(start) + left), written without the inverse.
        let t = left.tanh();
        (start + t) / (one + start * t)
    };
    if forward { after } else { -after }
}
