//! Polynomials in θ without constant term: entry `p` is the coefficient of `θ^(p+1)`.

/// The product of polynomials given with constant terms, lowest power first.
pub(super) fn product(factors: &[&[f64]]) -> Vec<f64> {
    factors.iter().fold(vec![1.0], |acc, factor| {
        let mut out = vec![0.0; acc.len() + factor.len() - 1];
        for (i, x) in acc.iter().enumerate() {
            for (j, y) in factor.iter().enumerate() {
                out[i + j] += x * y;
            }
        }
        out
    })
}

/// Interpolation weights of the cubic Hermite interpolant through both ends of a step and their
/// derivatives: `y_0 + h_01 (y_1 − y_0) + h_10 h k_1 + h_11 h k_{s+1}` with `y_1 − y_0 = h Σ b_i k_i`.
/// Third order for any method of order three or more.
pub(super) fn hermite(b: &[f64]) -> Vec<Vec<f64>> {
    let mut weights: Vec<Vec<f64>> = b.iter().map(|&bi| vec![0.0, 3.0 * bi, -2.0 * bi]).collect();
    for (w, h10) in weights[0].iter_mut().zip([1.0, -2.0, 1.0]) {
        *w += h10;
    }
    weights.push(vec![0.0, -1.0, 1.0]);
    weights
}
