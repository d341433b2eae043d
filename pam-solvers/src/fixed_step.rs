//! Fixed steps without a solver, for small systems that step themselves.

use pam_core::Scalar;

/// One step of size `h` of the classical Runge–Kutta method of order 4 for `ẏ = f(t, y)`:
///
/// ```text
/// k_1 = f(t, y)                      k_3 = f(t + h/2, y + h/2 k_2)
/// k_2 = f(t + h/2, y + h/2 k_1)      k_4 = f(t + h, y + h k_3)
/// y⁺  = y + h/6 (k_1 + 2 (k_2 + k_3) + k_4)
/// ```
///
/// `k_1` is given, since callers often have it. `rate(half, y)` gives the other derivatives at
/// `t + half h/2`, with `half` 1, 1 and 2. A second-order system `ẍ = a(t, x, v)` has `y = [x, v]` and
/// `f = [v, a]`. Allocates nothing.
///
/// Source: W. Kutta, *Beitrag zur näherungsweisen Integration totaler Differentialgleichungen*, Zeitschrift
/// für Mathematik und Physik 46 (1901) 435–453.
///
/// ```
/// use pam_solvers::rk4_step;
///
/// let oscillate = |[x, v]: [f64; 2]| [v, -x];
/// let mut y = [1.0, 0.0];
/// for _ in 0..100 {
///     y = rk4_step(y, oscillate(y), 0.01, |_, y| oscillate(y));
/// }
/// assert!((y[0] - 1.0_f64.cos()).abs() < 1e-9);
/// ```
#[inline]
pub fn rk4_step<S: Scalar, const N: usize>(
    y: [S; N],
    k_1: [S; N],
    h: f64,
    mut rate: impl FnMut(usize, [S; N]) -> [S; N],
) -> [S; N] {
    let along = |k: [S; N], h: f64| {
        let mut end = y;
        for (end, k) in end.iter_mut().zip(k) {
            *end += k.scaled(h);
        }
        end
    };
    let k_2 = rate(1, along(k_1, 0.5 * h));
    let k_3 = rate(1, along(k_2, 0.5 * h));
    let k_4 = rate(2, along(k_3, h));
    let mut sum = k_1;
    for i in 0..N {
        sum[i] = k_1[i] + (k_2[i] + k_3[i]).scaled(2.0) + k_4[i];
    }
    along(sum, h / 6.0)
}
