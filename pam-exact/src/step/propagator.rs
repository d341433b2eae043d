//! The linear oscillator in closed form.
//!
//! Inside one region the motion obeys `ẍ + ζ ẋ + κ x = w₀ + w₁ τ`. A step and its derivatives follow from two
//! functions: the impulse response `s`, with `s̈ + ζ ṡ + κ s = 0`, `s(0) = 0`, `ṡ(0) = 1`, and its convolution
//! with itself, `q = s ∗ s`, with `q̈ + ζ q̇ + κ q = s`. Let `e_k` and `q_k` be their `k`-fold integrals from
//! zero (derivatives for negative `k`). Integrating the two equations gives
//!
//! ```text
//! e_k = h^{k+1}/(k+1)! − ζ e_{k+1} − κ e_{k+2}
//! q_k = e_{k+2}        − ζ q_{k+1} − κ q_{k+2}
//! ```
//!
//! Run downwards from a `k` whose terms are below rounding, this is the Taylor series of the matrix
//! exponential in nested form (C. Moler, C. Van Loan, *Nineteen dubious ways*, 2003, method 1). Steps are so
//! short that `ρ h ≤ ½` with a bound `ρ` of the eigenvalues' moduli: nothing cancels. No discriminant enters,
//! so real, double and complex eigenvalues need no cases.

/// Largest product of a step and the spectral bound ρ of a region.
pub(crate) const MAX_SPECTRAL_STEP: f64 = 0.5;
/// Lengths of the series: a few, known at compile time, so that a step's loops are unrolled. The longest is
/// that at [`MAX_SPECTRAL_STEP`].
pub(crate) const SHORT: usize = 13;
pub(crate) const MEDIUM: usize = 16;
pub(crate) const LONGEST: usize = 18;

/// `1 / n`.
const INVERSE: [f64; LONGEST + 4] = {
    let mut inverse = [0.0; LONGEST + 4];
    let mut n = 1;
    while n < inverse.len() {
        inverse[n] = 1.0 / n as f64;
        n += 1;
    }
    inverse
};

/// The left side of `ẍ + ζ ẋ + κ x = w`.
#[derive(Debug, Clone, Copy)]
#[repr(C)]
pub(crate) struct Oscillator {
    pub(crate) kappa: f64,
    pub(crate) zeta: f64,
}

impl Oscillator {
    /// A bound on the moduli of the roots of `λ² + ζ λ + κ`.
    #[inline(always)]
    pub(crate) fn spectral_bound(&self) -> f64 {
        0.5 * (self.zeta.abs() + (self.zeta * self.zeta + 4.0 * self.kappa.abs()).sqrt())
    }

    /// `w − ζ ẋ − κ x`.
    #[inline(always)]
    pub(crate) fn acceleration(&self, [x, v]: [f64; 2], w: f64) -> f64 {
        (-self.zeta).mul_add(v, (-self.kappa).mul_add(x, w))
    }
}

/// The largest product of step and spectral bound for which the terms after the `terms − 3`rd are below
/// rounding.
const fn max_spectral_step(terms: usize) -> f64 {
    let (mut low, mut high) = (0.0, MAX_SPECTRAL_STEP);
    let mut halvings = 0;
    while halvings < 60 {
        let middle = 0.5 * (low + high);
        let (mut n, mut term) = (0, 1.0);
        while n < terms - 3 {
            n += 1;
            term *= middle / n as f64;
        }
        if term > 1e-18 {
            high = middle;
        } else {
            low = middle;
        }
        halvings += 1;
    }
    low
}

/// Length of the series for a step `h` with `ρ h = spectral_step`.
#[inline(always)]
pub(crate) fn series_terms(spectral_step: f64) -> usize {
    const LIMITS: [f64; 2] = [max_spectral_step(SHORT), max_spectral_step(MEDIUM)];
    if spectral_step <= LIMITS[0] {
        SHORT
    } else if spectral_step <= LIMITS[1] {
        MEDIUM
    } else {
        LONGEST
    }
}

/// The functions `e_k`, `k = −1 … 2`, at the end of a step: the propagator of state and forcing.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Propagator {
    /// `e_{−1} − 1`, small like the change of the state.
    pub(crate) decay: f64,
    pub(crate) impulse: f64,
    pub(crate) step: f64,
    pub(crate) ramp: f64,
}

/// The functions `q_k`, `k = −2 … 2`, at the end of a step: derivatives with respect to `κ` and `ζ` need them.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SelfConvolution {
    second_derivative: f64,
    derivative: f64,
    value: f64,
    integral: f64,
    second_integral: f64,
}

/// The recurrences on the ratios `e_k (k+1)!/h^{k+1}` and `q_k (k+3)!/h^{k+3}`, which start at one and need no
/// powers of `h`.
#[derive(Clone, Copy)]
struct Recurrence {
    /// `−ζ h`
    a: f64,
    /// `−κ h²`
    b: f64,
}

impl Recurrence {
    /// The ratio of index `k − 2`, from its first term and the ratios of the next two indices.
    #[inline(always)]
    fn ratio(self, first: f64, k: usize, one: f64, two: f64) -> f64 {
        let near = self.a * INVERSE[k];
        let far = self.b * (INVERSE[k] * INVERSE[k + 1]);
        near.mul_add(one, far.mul_add(two, first))
    }
}

impl Propagator {
    /// The propagator over a step `h`, by a series of `terms` terms (see [`series_terms`]).
    #[inline(always)]
    pub(crate) fn new(oscillator: Oscillator, h: f64, terms: usize) -> Self {
        match terms {
            SHORT => Self::by_series::<SHORT>(oscillator, h),
            MEDIUM => Self::by_series::<MEDIUM>(oscillator, h),
            _ => Self::by_series::<LONGEST>(oscillator, h),
        }
    }

    #[inline(always)]
    fn by_series<const TERMS: usize>(oscillator: Oscillator, h: f64) -> Self {
        let Oscillator { kappa, zeta } = oscillator;
        let recurrence = Recurrence { a: -zeta * h, b: -kappa * h * h };
        let (mut r1, mut r2) = (1.0, 1.0);
        for k in (3..TERMS - 2).rev() {
            (r1, r2) = (recurrence.ratio(1.0, k + 2, r1, r2), r1);
        }
        let e2 = recurrence.ratio(1.0, 4, r1, r2);
        let e1 = recurrence.ratio(1.0, 3, e2, r1);
        let e0 = recurrence.ratio(1.0, 2, e1, e2);
        Self::from_ratios(oscillator, h, [e0, e1, e2])
    }

    /// From the ratios of `e_0`, `e_1` and `e_2`.
    #[inline(always)]
    fn from_ratios(Oscillator { kappa, zeta }: Oscillator, h: f64, [e0, e1, e2]: [f64; 3]) -> Self {
        let (impulse, step) = (h * e0, 0.5 * h * h * e1);
        let ramp = h * h * h * (e2 / 6.0);
        Self { decay: (-zeta).mul_add(impulse, -kappa * step), impulse, step, ramp }
    }

    /// Displacement and velocity after the step, from those before it and the forcing `w₀ + w₁ τ`.
    #[inline(always)]
    pub(crate) fn advance(&self, kappa: f64, [x, v]: [f64; 2], [w0, w1]: [f64; 2]) -> [f64; 2] {
        let driven =
            [self.step.mul_add(w0, self.ramp * w1), self.impulse.mul_add(w0, self.step * w1)];
        [
            x + (-kappa * self.step).mul_add(x, self.impulse.mul_add(v, driven[0])),
            v + (-kappa * self.impulse).mul_add(x, self.decay.mul_add(v, driven[1])),
        ]
    }

    /// A costate `(λ_x, λ_v)` before the step from the one after it: the transpose of the propagator.
    #[inline(always)]
    pub(crate) fn pull_back(&self, kappa: f64, [lx, lv]: [f64; 2]) -> [f64; 2] {
        [
            lx + (-kappa * self.step).mul_add(lx, -kappa * self.impulse * lv),
            lv + self.impulse.mul_add(lx, self.decay * lv),
        ]
    }
}

/// A step that can be differentiated.
#[derive(Debug, Clone, Copy)]
pub(crate) struct DifferentiableStep {
    pub(crate) oscillator: Oscillator,
    pub(crate) propagator: Propagator,
    pub(crate) convolution: SelfConvolution,
}

/// Displacement and velocity at the end of a step under unit accelerations along `x(τ)` and along `ẋ(τ)`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ForcedResponses {
    pub(crate) by_x: [f64; 2],
    pub(crate) by_v: [f64; 2],
}

/// Integrals over a step of the velocity's costate `λ_v` times `1`, `τ`, `x` and `ẋ`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepMoments {
    pub(crate) one: f64,
    pub(crate) time: f64,
    pub(crate) x: f64,
    pub(crate) v: f64,
}

impl DifferentiableStep {
    /// A step `h`, by series of `terms` terms (see [`series_terms`]).
    #[inline(always)]
    pub(crate) fn new(oscillator: Oscillator, h: f64, terms: usize) -> Self {
        match terms {
            SHORT => Self::by_series::<SHORT>(oscillator, h),
            MEDIUM => Self::by_series::<MEDIUM>(oscillator, h),
            _ => Self::by_series::<LONGEST>(oscillator, h),
        }
    }

    #[inline(always)]
    fn by_series<const TERMS: usize>(oscillator: Oscillator, h: f64) -> Self {
        let Oscillator { kappa, zeta } = oscillator;
        let recurrence = Recurrence { a: -zeta * h, b: -kappa * h * h };
        // Ratios of e_{k+1}, e_{k+2}; of q_{k-1}, q_k where k − 2 is the index of the step's q.
        let (mut r1, mut r2) = (1.0, 1.0);
        let (mut s1, mut s2) = (1.0, 1.0);
        for k in (5..TERMS).rev() {
            (r1, r2) = (recurrence.ratio(1.0, k + 2, r1, r2), r1);
            (s1, s2) = (recurrence.ratio(r1, k + 2, s1, s2), s1);
        }
        // Here r1 = e_5, s1 = q_3 and so on, as ratios.
        let e4 = recurrence.ratio(1.0, 6, r1, r2);
        let e3 = recurrence.ratio(1.0, 5, e4, r1);
        let e2 = recurrence.ratio(1.0, 4, e3, e4);
        let e1 = recurrence.ratio(1.0, 3, e2, e3);
        let e0 = recurrence.ratio(1.0, 2, e1, e2);
        let q2 = recurrence.ratio(e4, 6, s1, s2);
        let q1 = recurrence.ratio(e3, 5, q2, s1);
        let q0 = recurrence.ratio(e2, 4, q1, q2);
        let q_rate = recurrence.ratio(e1, 3, q0, q1);
        let p = [h * h / 2.0, h * h * h / 6.0, h * h * h * h / 24.0, h * h * h * h * h / 120.0];
        let propagator = Propagator::from_ratios(oscillator, h, [e0, e1, e2]);
        let (value, derivative) = (p[1] * q0, p[0] * q_rate);
        let convolution = SelfConvolution {
            second_derivative: propagator.impulse - zeta * derivative - kappa * value,
            derivative,
            value,
            integral: p[2] * q1,
            second_integral: p[3] * q2,
        };
        Self { oscillator, propagator, convolution }
    }

    /// The responses to unit accelerations along the motion that starts at `[x, ẋ]` under `w₀ + w₁ τ`.
    #[inline(always)]
    pub(crate) fn forced_responses(&self, [x, v]: [f64; 2], [w0, w1]: [f64; 2]) -> ForcedResponses {
        let Oscillator { kappa, zeta } = self.oscillator;
        let q = &self.convolution;
        let by_x = [
            (q.derivative + zeta * q.value) * x
                + q.value * v
                + q.integral * w0
                + q.second_integral * w1,
            (q.second_derivative + zeta * q.derivative) * x
                + q.derivative * v
                + q.value * w0
                + q.integral * w1,
        ];
        let by_v = [
            q.derivative * v + q.value * (w0 - kappa * x) + q.integral * w1,
            q.second_derivative * v + q.derivative * (w0 - kappa * x) + q.value * w1,
        ];
        ForcedResponses { by_x, by_v }
    }

    /// The moments of the motion that starts at `state` under `w₀ + w₁ τ`, for the costate at its end.
    #[inline(always)]
    pub(crate) fn moments(
        &self,
        state: [f64; 2],
        forcing: [f64; 2],
        [lx, lv]: [f64; 2],
    ) -> StepMoments {
        let ForcedResponses { by_x, by_v } = self.forced_responses(state, forcing);
        let e = &self.propagator;
        StepMoments {
            one: lx * e.step + lv * e.impulse,
            time: lx * e.ramp + lv * e.step,
            x: lx * by_x[0] + lv * by_x[1],
            v: lx * by_v[0] + lv * by_v[1],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pam_solvers::rk4_step;

    /// RK4 in many steps of `y' = rhs(t, y)`.
    fn integrate<const N: usize>(
        mut y: [f64; N],
        h: f64,
        rhs: impl Fn(f64, &[f64; N]) -> [f64; N],
    ) -> [f64; N] {
        let steps = 4000;
        let d = h / f64::from(steps);
        for step in 0..steps {
            let t = f64::from(step) * d;
            y = rk4_step(y, rhs(t, &y), d, |half, y| rhs(t + half as f64 * d / 2.0, &y));
        }
        y
    }

    const CASES: [(f64, f64); 6] = [
        (400.0, 3.0),
        (100.0, 20.0),
        (100.0, 20.000_000_01),
        (5.0, 24.0),
        (-60.0, 1.0),
        (0.0, 0.0),
    ];

    /// The longest step of an oscillator, with its length.
    fn longest(kappa: f64, zeta: f64) -> (DifferentiableStep, f64) {
        let oscillator = Oscillator { kappa, zeta };
        let rho = oscillator.spectral_bound();
        let h = MAX_SPECTRAL_STEP / rho.max(10.0);
        (DifferentiableStep::new(oscillator, h, series_terms(rho * h)), h)
    }

    #[test]
    fn steps_solve_the_oscillator() {
        for (kappa, zeta) in CASES {
            let (x, v, w0, w1) = (0.7, -3.0, 40.0, 500.0);
            let (step, h) = longest(kappa, zeta);
            let ours = step.propagator.advance(kappa, [x, v], [w0, w1]);
            let reference =
                integrate([x, v], h, |t, y| [y[1], w0 + w1 * t - kappa * y[0] - zeta * y[1]]);
            for (a, b) in ours.iter().zip(reference) {
                assert!((a - b).abs() < 3e-13 * (1.0 + b.abs()), "{kappa} {zeta}: {a} {b}");
            }
        }
    }

    /// The moments are those of the linear forms `λᵀ δ(h)`, where `δ` is driven by 1, τ, x and ẋ.
    #[test]
    fn moments_are_responses_to_the_state() {
        for (kappa, zeta) in CASES {
            let (step, h) = longest(kappa, zeta);
            let (state, w, l) = ([0.7, -3.0], [40.0, 500.0], [0.3, -1.2]);
            let m = step.moments(state, w, l);
            let ends =
                integrate([state[0], state[1], 0., 0., 0., 0., 0., 0., 0., 0.], h, |t, y| {
                    let by = |i: usize, f: f64| [y[i + 1], f - kappa * y[i] - zeta * y[i + 1]];
                    let [a, b, c, d] = [by(2, 1.0), by(4, t), by(6, y[0]), by(8, y[1])];
                    let acceleration = w[0] + w[1] * t - kappa * y[0] - zeta * y[1];
                    [y[1], acceleration, a[0], a[1], b[0], b[1], c[0], c[1], d[0], d[1]]
                });
            for (i, ours) in [m.one, m.time, m.x, m.v].into_iter().enumerate() {
                let reference = l[0] * ends[2 + 2 * i] + l[1] * ends[3 + 2 * i];
                assert!((ours - reference).abs() < 1e-13 * (1.0 + reference.abs()), "{kappa} {i}");
            }
            let back = step.propagator.pull_back(kappa, l);
            for (i, unit) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let end = integrate(unit, h, |_, y| [y[1], -kappa * y[0] - zeta * y[1]]);
                assert!((back[i] - l[0] * end[0] - l[1] * end[1]).abs() < 1e-12);
            }
        }
    }
}
