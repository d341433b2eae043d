//! The motion within a step as a power series in the time since its start.

use super::closed_form::Step;
use super::propagator::LONGEST;

/// Displacement and velocity as polynomials with `N` coefficients.
///
/// The derivatives follow from the equation of motion, `d_{n+2} = −ζ d_{n+1} − κ d_n` beyond the forcing, so
/// one series serves any time within the step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TaylorSeries<const N: usize> {
    pub(crate) x: [f64; N],
    pub(crate) v: [f64; N],
}

impl<const N: usize> TaylorSeries<N> {
    #[inline(always)]
    pub(crate) fn new(step: &Step) -> Self {
        let Step { oscillator, from: [x, v], a, w: [_, rate], .. } = *step;
        let (kappa, zeta) = (oscillator.kappa, oscillator.zeta);
        let (mut x, mut v) = ([x; N], [v; N]);
        let jerk = (-kappa).mul_add(v[0], (-zeta).mul_add(a, rate));
        // The derivatives of order n and n + 1.
        let (mut lower, mut upper) = (a, jerk);
        (x[1], v[1]) = (v[0], a);
        for n in 2..N {
            x[n] = INVERSE_FACTORIAL[n] * lower;
            v[n] = INVERSE_FACTORIAL[n] * upper;
            (lower, upper) = (upper, (-zeta).mul_add(upper, -kappa * lower));
        }
        Self { x, v }
    }

    /// Displacement and velocity after `t`.
    #[inline(always)]
    pub(crate) fn at(&self, t: f64) -> [f64; 2] {
        [polynomial(self.x, t), polynomial(self.v, t)]
    }
}

/// The value of a polynomial by Estrin's scheme, whose terms are independent of each other.
#[inline(always)]
fn polynomial<const N: usize>(mut c: [f64; N], t: f64) -> f64 {
    const { assert!(N <= 32) };
    // Written out, so that all lengths are known at compile time.
    let (t2, t4) = (t * t, (t * t) * (t * t));
    let t8 = t4 * t4;
    pairs(&mut c, N, t);
    pairs(&mut c, N.div_ceil(2), t2);
    pairs(&mut c, N.div_ceil(4), t4);
    pairs(&mut c, N.div_ceil(8), t8);
    pairs(&mut c, N.div_ceil(16), t8 * t8);
    c[0]
}

/// Combines pairs of the first `len` coefficients.
#[inline(always)]
fn pairs<const N: usize>(c: &mut [f64; N], len: usize, power: f64) {
    for i in 0..len / 2 {
        c[i] = c[2 * i + 1].mul_add(power, c[2 * i]);
    }
    if len % 2 == 1 {
        c[len / 2] = c[len - 1];
    }
}

/// `1 / n!`.
const INVERSE_FACTORIAL: [f64; LONGEST] = {
    let mut inverse = [1.0; LONGEST];
    let mut n = 1;
    while n < inverse.len() {
        inverse[n] = inverse[n - 1] / n as f64;
        n += 1;
    }
    inverse
};
