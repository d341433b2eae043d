//! Remembered numbers over a step.
//!
//! A rate `q̇ = f(q, u)` is integrated by the exponential Runge–Kutta method of second order (Cox and Matthews 2002) with
//! the diagonal `J = ∂fᵢ/∂qᵢ`, which is found by differentiating the expression:
//!
//! ```text
//! a = q + h φ₁(hJ) f(q, u₀)        q' = a + h φ₂(hJ) [f(a, u₁) − f(q, u₀) − J (a − q)]
//! ```
//!
//! It is stable for any rate that decays and exact for `f = J q + b u` while u runs straight: a low-pass is one without an
//! error of its own.

use pam_autodiff::Chunk;
use pam_core::Scalar;
use pam_expression::{Graph, Id, Program};

/// Most remembered numbers of an effect.
pub(super) const MOST: usize = 16;
/// Most of an effect whose steps take little room.
const FEW: usize = 2;

/// The laws of the remembered numbers of an effect.
#[derive(Debug, Clone)]
pub(super) struct Memory {
    pub(super) starts: Program,
    rates: Option<Rates>,
    /// Values after a step, and which numbers they are.
    steps: Option<(Program, Vec<usize>)>,
    pub(super) len: usize,
}

#[derive(Debug, Clone)]
struct Rates {
    /// Rates of the numbers `of`.
    values: Program,
    /// The same, then their slopes by the number itself.
    with_slopes: Program,
    of: Vec<usize>,
}

/// A law of a remembered number, as a node of a graph.
pub(super) enum Law {
    Rate(Id),
    Step(Id),
}

impl Memory {
    /// The laws; `first` is the input of the first number. `None` if a program is too long.
    ///
    /// # Errors
    /// The number whose rate cannot be differentiated.
    pub(super) fn new(
        graph: &mut Graph,
        starts: &[Id],
        laws: &[Law],
        first: usize,
    ) -> Result<Option<Self>, usize> {
        let (mut rates, mut slopes, mut of) = (Vec::new(), Vec::new(), Vec::new());
        let (mut steps, mut stepped) = (Vec::new(), Vec::new());
        for (k, law) in laws.iter().enumerate() {
            match law {
                Law::Rate(id) => {
                    rates.push(*id);
                    slopes.push(graph.derivative(*id, first + k).ok_or(k)?);
                    of.push(k);
                }
                Law::Step(id) => {
                    steps.push(*id);
                    stepped.push(k);
                }
            }
        }
        let build = || {
            let starts = Program::new(graph, starts)?;
            let rates = if of.is_empty() {
                None
            } else {
                let values = Program::new(graph, &rates)?;
                let both: Vec<Id> = rates.iter().chain(&slopes).copied().collect();
                Some(Rates { values, with_slopes: Program::new(graph, &both)?, of: of.clone() })
            };
            let steps = if stepped.is_empty() {
                None
            } else {
                Some((Program::new(graph, &steps)?, stepped.clone()))
            };
            Some(Self { starts, rates, steps, len: laws.len() })
        };
        Ok(build())
    }

    /// Hands on the numbers after a step of `step_s` from `old`. `evaluate` runs a program with given numbers at the start of
    /// the step, or at its end.
    #[inline]
    pub(super) fn advance<S: Scalar, R>(
        &self,
        step_s: f64,
        old: &[S],
        evaluate: &impl Fn(&[S], bool, &Program, &mut [S]),
        then: impl FnOnce(&[S]) -> R,
    ) -> R {
        if self.len <= FEW {
            then(&self.advanced::<FEW, S>(step_s, old, evaluate)[..self.len])
        } else {
            then(&self.advanced::<MOST, S>(step_s, old, evaluate)[..self.len])
        }
    }

    fn advanced<const N: usize, S: Scalar>(
        &self,
        step_s: f64,
        old: &[S],
        evaluate: &impl Fn(&[S], bool, &Program, &mut [S]),
    ) -> [S; N] {
        let mut new = [S::zero(); N];
        new[..self.len].copy_from_slice(old);
        // A step of no length changes nothing.
        if let Some((program, of)) = self.steps.as_ref().filter(|_| step_s > 0.0) {
            let mut values = [S::zero(); N];
            evaluate(old, false, program, &mut values[..of.len()]);
            for (&k, value) in of.iter().zip(values) {
                new[k] = value;
            }
        }
        let Some(Rates { values, with_slopes, of }) = self.rates.as_ref().filter(|_| step_s > 0.0)
        else {
            return new;
        };
        let count = of.len();
        // Rates, then slopes.
        let mut first = [[S::zero(); N]; 2];
        evaluate(old, true, with_slopes, &mut first.as_flattened_mut()[..2 * count]);
        let first = first.as_flattened();
        let mut factors = [S::zero(); N];
        for (j, &k) in of.iter().enumerate() {
            let [one, two] = phi(first[count + j].scaled(step_s));
            new[k] = old[k] + (one * first[j]).scaled(step_s);
            factors[j] = two.scaled(step_s);
        }
        let mut second = [S::zero(); N];
        evaluate(&new[..self.len], false, values, &mut second[..count]);
        for (j, &k) in of.iter().enumerate() {
            let linear = first[j] + first[count + j] * (new[k] - old[k]);
            second[j] -= linear;
        }
        for (j, &k) in of.iter().enumerate() {
            new[k] += factors[j] * second[j];
        }
        new
    }
}

/// `φ₁(z) = (eᶻ − 1)/z` and `φ₂(z) = (φ₁(z) − 1)/z`.
fn phi<S: Scalar>(z: S) -> [S; 2] {
    if S::HAS_SEVERAL_SLOPES {
        // The values and slopes once for all derivatives.
        let at = Chunk::<1>::variable(z.real(), 0);
        return phi(at).map(|f| S::with_slopes(f.value, [&z], f.derivatives));
    }
    let one = S::constant(1.0);
    if z.real().abs() < 1e-2 {
        // Terms to z⁵: the next one is below rounding.
        let mut sum = one;
        for k in (3..8).rev() {
            sum = (sum * z).scaled(1.0 / f64::from(k)) + one;
        }
        let second = sum.scaled(0.5);
        return [second * z + one, second];
    }
    let reciprocal = z.recip();
    let first = z.exp_m1() * reciprocal;
    [first, (first - one) * reciprocal]
}
