//! Quadratic programs in a box: `min ½ uᵀ H u + qᵀ u` with `l ≤ u ≤ h`.
//!
//! Projected Newton (Bertsekas 1982): variables held by their bounds are left out, the others take Newton's
//! step, and a line search along the projected path makes the cost fall. From the solution of a similar
//! program it ends after one or two steps. A test holds it against an interior-point library.

/// Steps before the best point so far is returned.
const MOST_STEPS: usize = 30;

/// A solver with its memory.
#[derive(Debug, Clone)]
pub struct BoxQp {
    n: usize,
    gradient: Vec<f64>,
    step: Vec<f64>,
    tried: Vec<f64>,
    factor: Vec<f64>,
    free: Vec<usize>,
}

impl BoxQp {
    /// For `n` variables.
    #[must_use]
    pub fn new(n: usize) -> Self {
        Self {
            n,
            gradient: vec![0.0; n],
            step: vec![0.0; n],
            tried: vec![0.0; n],
            factor: vec![0.0; n * n],
            free: Vec::with_capacity(n),
        }
    }

    /// Improves `u` to the solution; `h` is row by row, positive definite. Allocates nothing. Returns the
    /// number of steps.
    ///
    /// # Panics
    /// If a slice is too short.
    pub fn solve(
        &mut self,
        h: &[f64],
        q: &[f64],
        low: &[f64],
        high: &[f64],
        u: &mut [f64],
    ) -> usize {
        let n = self.n;
        for i in 0..n {
            u[i] = within(u[i], low[i], high[i]);
        }
        let mut value = cost(h, q, u);
        for steps in 0..MOST_STEPS {
            multiply(h, u, &mut self.gradient);
            (0..n).for_each(|i| self.gradient[i] += q[i]);
            self.free.clear();
            let mut worst = 0.0_f64;
            for i in 0..n {
                let g = self.gradient[i];
                let held = (u[i] <= low[i] && g > 0.0) || (u[i] >= high[i] && g < 0.0);
                if !held {
                    self.free.push(i);
                    worst = worst.max(g.abs() / h[i * n + i]);
                }
            }
            if worst <= 1e-10 || !self.newton_step(h) {
                return steps;
            }
            let mut length = 1.0;
            loop {
                for i in 0..n {
                    self.tried[i] = within(u[i] + length * self.step[i], low[i], high[i]);
                }
                let found = cost(h, q, &self.tried);
                if found < value {
                    u[..n].copy_from_slice(&self.tried);
                    value = found;
                    break;
                }
                length *= 0.5;
                if length < 1e-8 {
                    return steps;
                }
            }
        }
        MOST_STEPS
    }

    /// Newton's step of the free variables, zero for the others; false if the matrix is not positive
    /// definite.
    fn newton_step(&mut self, h: &[f64]) -> bool {
        let (n, m) = (self.n, self.free.len());
        for a in 0..m {
            for b in 0..=a {
                let mut sum = h[self.free[a] * n + self.free[b]];
                for k in 0..b {
                    sum -= self.factor[a * n + k] * self.factor[b * n + k];
                }
                if a == b {
                    if sum <= 0.0 || !sum.is_finite() {
                        return false;
                    }
                    self.factor[a * n + a] = sum.sqrt();
                } else {
                    self.factor[a * n + b] = sum / self.factor[b * n + b];
                }
            }
        }
        // `tried` holds the right side on its way through both triangles.
        for a in 0..m {
            let mut sum = -self.gradient[self.free[a]];
            for k in 0..a {
                sum -= self.factor[a * n + k] * self.tried[k];
            }
            self.tried[a] = sum / self.factor[a * n + a];
        }
        for a in (0..m).rev() {
            let mut sum = self.tried[a];
            for k in a + 1..m {
                sum -= self.factor[k * n + a] * self.tried[k];
            }
            self.tried[a] = sum / self.factor[a * n + a];
        }
        self.step.fill(0.0);
        for a in 0..m {
            self.step[self.free[a]] = self.tried[a];
        }
        true
    }
}

/// The nearest value of a range. Bounds may be NaN where a joint has diverged; the value is then kept.
fn within(value: f64, low: f64, high: f64) -> f64 {
    if value < low {
        low
    } else if value > high {
        high
    } else {
        value
    }
}

fn multiply(h: &[f64], u: &[f64], out: &mut [f64]) {
    let n = out.len();
    for (row, out) in h.chunks_exact(n).zip(out) {
        *out = row.iter().zip(u).map(|(a, b)| a * b).sum();
    }
}

fn cost(h: &[f64], q: &[f64], u: &[f64]) -> f64 {
    let n = q.len();
    let quadratic: f64 = h
        .chunks_exact(n)
        .zip(u)
        .map(|(row, u_i)| u_i * row.iter().zip(u).map(|(a, b)| a * b).sum::<f64>())
        .sum();
    0.5 * quadratic + q.iter().zip(u).map(|(a, b)| a * b).sum::<f64>()
}
