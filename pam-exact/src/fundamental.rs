//! The linear oscillator in closed form.
//!
//! Inside one pattern the motion obeys `ẍ + ζ ẋ + κ x = w₀ + w₁ τ`. Everything that a step and its
//! derivatives need follows from two functions: the impulse response `s`, with
//! `s̈ + ζ ṡ + κ s = 0`, `s(0) = 0`, `ṡ(0) = 1`, and its convolution with itself, `q = s ∗ s`, with
//! `q̈ + ζ q̇ + κ q = s`. Let `e_k` and `q_k` be their `k`-fold integrals from zero (derivatives for
//! negative `k`). Integrating the two equations gives
//!
//! ```text
//! e_k = h^{k+1}/(k+1)! − ζ e_{k+1} − κ e_{k+2}
//! q_k = e_{k+2}        − ζ q_{k+1} − κ q_{k+2}
//! ```
//!
//! Run downwards from a `k` whose terms are below rounding, this is the matrix exponential by its
//! series in nested form. Real, double and complex eigenvalues are the same to it, nothing cancels, and
//! nothing is divided by a discriminant; steps are kept so short that the roots' moduli times the step
//! stay below one half.

/// Largest product of a step and the spectral bound ρ of a pattern.
pub(crate) const REACH: f64 = 0.5;
/// Lengths that a series may have: a few, known when the program is compiled, so that a step's loops have
/// no end that must be guessed. The longest is that at [`REACH`].
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

/// A bound on the moduli of the roots of `λ² + ζ λ + κ`.
#[inline(always)]
pub(crate) fn spectral_bound(kappa: f64, zeta: f64) -> f64 {
    0.5 * (zeta.abs() + (zeta * zeta + 4.0 * kappa.abs()).sqrt())
}

/// The largest product of step and spectral bound for which the terms after the `terms − 3`rd are below
/// rounding.
const fn reach_of(terms: usize) -> f64 {
    let (mut low, mut high) = (0.0, REACH);
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

/// Length of the series for a step with `rho · h = reach`.
#[inline(always)]
pub(crate) fn terms(reach: f64) -> usize {
    const REACHES: [f64; 2] = [reach_of(SHORT), reach_of(MEDIUM)];
    if reach <= REACHES[0] {
        SHORT
    } else if reach <= REACHES[1] {
        MEDIUM
    } else {
        LONGEST
    }
}

/// The functions `e_k`, `k = −1 … 2`, at one step.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Response {
    /// `e_{−1} − 1`: a step changes a state by little, and so is this.
    pub(crate) decay: f64,
    pub(crate) impulse: f64,
    pub(crate) step: f64,
    pub(crate) ramp: f64,
}

/// The functions `q_k`, `k = −2 … 2`, at one step: what the moments of costate and state need.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Squared {
    pub(crate) curve: f64,
    pub(crate) rate: f64,
    pub(crate) value: f64,
    pub(crate) once: f64,
    pub(crate) twice: f64,
}

/// One step down a recurrence: the ratio of index `k − 2` from what it starts at and those of the next two
/// indices, with `a = −ζ h` and `b = −κ h²`.
#[inline(always)]
fn ratio((a, b): (f64, f64), start: f64, k: usize, (one, two): (f64, f64)) -> f64 {
    let near = a * INVERSE[k];
    let far = b * (INVERSE[k] * INVERSE[k + 1]);
    near.mul_add(one, far.mul_add(two, start))
}

impl Response {
    /// The functions `e_k` alone, at a step of length `h`, by a series of a length from [`terms`].
    #[inline(always)]
    pub(crate) fn new(kappa: f64, zeta: f64, h: f64, terms: usize) -> Self {
        match terms {
            SHORT => Self::by::<SHORT>(kappa, zeta, h),
            MEDIUM => Self::by::<MEDIUM>(kappa, zeta, h),
            _ => Self::by::<LONGEST>(kappa, zeta, h),
        }
    }

    /// Both families at a step of length `h`, by series of a length from [`terms`].
    #[inline(always)]
    pub(crate) fn with_square(kappa: f64, zeta: f64, h: f64, terms: usize) -> (Self, Squared) {
        match terms {
            SHORT => Self::both_by::<SHORT>(kappa, zeta, h),
            MEDIUM => Self::both_by::<MEDIUM>(kappa, zeta, h),
            _ => Self::both_by::<LONGEST>(kappa, zeta, h),
        }
    }

    #[inline(always)]
    fn by<const TERMS: usize>(kappa: f64, zeta: f64, h: f64) -> Self {
        let (a, b) = (-zeta * h, -kappa * h * h);
        let (mut r1, mut r2) = (1.0, 1.0);
        for k in (3..TERMS - 2).rev() {
            (r1, r2) = (ratio((a, b), 1.0, k + 2, (r1, r2)), r1);
        }
        let e2 = ratio((a, b), 1.0, 4, (r1, r2));
        let e1 = ratio((a, b), 1.0, 3, (e2, r1));
        let e0 = ratio((a, b), 1.0, 2, (e1, e2));
        Self::of(kappa, zeta, h, [e0, e1, e2])
    }

    /// From the ratios of `e_0`, `e_1` and `e_2`.
    #[inline(always)]
    fn of(kappa: f64, zeta: f64, h: f64, [e0, e1, e2]: [f64; 3]) -> Self {
        let (impulse, step) = (h * e0, 0.5 * h * h * e1);
        let ramp = h * h * h * (e2 / 6.0);
        Self { decay: (-zeta).mul_add(impulse, -kappa * step), impulse, step, ramp }
    }

    /// The recurrences run on the ratios `e_k (k+1)!/h^{k+1}` and `q_k (k+3)!/h^{k+3}`, which start at one
    /// and need no powers of `h`.
    #[inline(always)]
    fn both_by<const TERMS: usize>(kappa: f64, zeta: f64, h: f64) -> (Self, Squared) {
        let ab = (-zeta * h, -kappa * h * h);
        // Ratios of e_{k+1}, e_{k+2}; of q_{k-1}, q_k where k − 2 is the index of the step's q.
        let (mut r1, mut r2) = (1.0, 1.0);
        let (mut s1, mut s2) = (1.0, 1.0);
        for k in (5..TERMS).rev() {
            (r1, r2) = (ratio(ab, 1.0, k + 2, (r1, r2)), r1);
            (s1, s2) = (ratio(ab, r1, k + 2, (s1, s2)), s1);
        }
        // Here r1 = e_5, s1 = q_3 and so on, as ratios.
        let e4 = ratio(ab, 1.0, 6, (r1, r2));
        let e3 = ratio(ab, 1.0, 5, (e4, r1));
        let e2 = ratio(ab, 1.0, 4, (e3, e4));
        let e1 = ratio(ab, 1.0, 3, (e2, e3));
        let e0 = ratio(ab, 1.0, 2, (e1, e2));
        let q2 = ratio(ab, e4, 6, (s1, s2));
        let q1 = ratio(ab, e3, 5, (q2, s1));
        let q0 = ratio(ab, e2, 4, (q1, q2));
        let q_rate = ratio(ab, e1, 3, (q0, q1));
        let p = [h * h / 2.0, h * h * h / 6.0, h * h * h * h / 24.0, h * h * h * h * h / 120.0];
        let response = Self::of(kappa, zeta, h, [e0, e1, e2]);
        let (value, rate) = (p[1] * q0, p[0] * q_rate);
        let curve = response.impulse - zeta * rate - kappa * value;
        (response, Squared { curve, rate, value, once: p[2] * q1, twice: p[3] * q2 })
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

/// What unit accelerations along `x(τ)`, and along `ẋ(τ)`, do to displacement and velocity at the end of
/// a step.
#[inline(always)]
pub(crate) fn responses(
    q: &Squared,
    (kappa, zeta): (f64, f64),
    [x, v]: [f64; 2],
    [w0, w1]: [f64; 2],
) -> ([f64; 2], [f64; 2]) {
    let by_x = [
        (q.rate + zeta * q.value) * x + q.value * v + q.once * w0 + q.twice * w1,
        (q.curve + zeta * q.rate) * x + q.rate * v + q.value * w0 + q.once * w1,
    ];
    let by_v = [
        q.rate * v + q.value * (w0 - kappa * x) + q.once * w1,
        q.curve * v + q.rate * (w0 - kappa * x) + q.value * w1,
    ];
    (by_x, by_v)
}

/// Integrals over a step of the velocity's costate `λ_v` times `1`, `τ`, `x` and `ẋ`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct StepMoments {
    pub(crate) one: f64,
    pub(crate) time: f64,
    pub(crate) x: f64,
    pub(crate) v: f64,
}

impl StepMoments {
    /// For the state `[x, ẋ]` and forcing `w₀ + w₁ τ` from the step's start and the costate at its end.
    #[inline(always)]
    pub(crate) fn new(
        (e, q): (&Response, &Squared),
        (kappa, zeta): (f64, f64),
        [x, v]: [f64; 2],
        [w0, w1]: [f64; 2],
        [lx, lv]: [f64; 2],
    ) -> Self {
        let (by_x, by_v) = responses(q, (kappa, zeta), [x, v], [w0, w1]);
        Self {
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

    /// RK4 in many steps of `y' = rhs(t, y)`.
    fn integrate<const N: usize>(
        mut y: [f64; N],
        h: f64,
        rhs: impl Fn(f64, &[f64; N]) -> [f64; N],
    ) -> [f64; N] {
        let steps = 4000;
        let d = h / f64::from(steps);
        let add = |y: &[f64; N], k: &[f64; N], s: f64| std::array::from_fn(|i| y[i] + s * k[i]);
        for step in 0..steps {
            let t = f64::from(step) * d;
            let k1 = rhs(t, &y);
            let k2 = rhs(t + d / 2.0, &add(&y, &k1, d / 2.0));
            let k3 = rhs(t + d / 2.0, &add(&y, &k2, d / 2.0));
            let k4 = rhs(t + d, &add(&y, &k3, d));
            y = std::array::from_fn(|i| {
                y[i] + d / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i])
            });
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

    #[test]
    fn steps_solve_the_oscillator() {
        for (kappa, zeta) in CASES {
            let h = REACH / spectral_bound(kappa, zeta).max(10.0);
            let (x, v, w0, w1) = (0.7, -3.0, 40.0, 500.0);
            let terms = terms(spectral_bound(kappa, zeta) * h);
            let (e, _) = Response::with_square(kappa, zeta, h, terms);
            let ours = e.advance(kappa, [x, v], [w0, w1]);
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
            let h = REACH / spectral_bound(kappa, zeta).max(10.0);
            let terms = terms(spectral_bound(kappa, zeta) * h);
            let (e, q) = Response::with_square(kappa, zeta, h, terms);
            let (state, w, l) = ([0.7, -3.0], [40.0, 500.0], [0.3, -1.2]);
            let m = StepMoments::new((&e, &q), (kappa, zeta), state, w, l);
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
            let back = e.pull_back(kappa, l);
            for (i, unit) in [[1.0, 0.0], [0.0, 1.0]].into_iter().enumerate() {
                let end = integrate(unit, h, |_, y| [y[1], -kappa * y[0] - zeta * y[1]]);
                assert!((back[i] - l[0] * end[0] - l[1] * end[1]).abs() < 1e-12);
            }
        }
    }
}
