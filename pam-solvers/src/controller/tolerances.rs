use pam_core::Scalar;

/// Relative and absolute tolerances of the error control.
///
/// The error of a step is the root mean square over the states of
/// `e_i / (atol_i + rtol · max(|y_i|, |y_i⁺|))`; a step is good below 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Tolerances {
    rtol: f64,
    atol: Vec<f64>,
}

impl Tolerances {
    /// One relative and one absolute tolerance for all states.
    #[must_use]
    pub fn new(rtol: f64, atol: f64) -> Self {
        Self { rtol, atol: vec![atol] }
    }

    /// One relative tolerance, and an absolute one for each state in its own unit.
    #[must_use]
    pub fn per_state(rtol: f64, atol: Vec<f64>) -> Self {
        Self { rtol, atol }
    }

    /// These tolerances times `factor`.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        Self { rtol: self.rtol * factor, atol: self.atol.iter().map(|a| a * factor).collect() }
    }

    /// Number of states the absolute tolerances are for, if they differ between states.
    #[must_use]
    pub fn state_len(&self) -> Option<usize> {
        (self.atol.len() != 1).then_some(self.atol.len())
    }

    /// Returns `true` if all tolerances are finite and not negative, and no state has both at zero.
    #[must_use]
    pub fn is_valid(&self) -> bool {
        let fine = |v: f64| v.is_finite() && v >= 0.0;
        fine(self.rtol)
            && !self.atol.is_empty()
            && self.atol.iter().all(|&a| fine(a) && a + self.rtol > 0.0)
    }

    /// The norm of `value` (real parts) in units of the tolerance around states `y0` and `y1`.
    pub fn norm<S: Scalar>(&self, value: &[S], y0: &[S], y1: &[S]) -> f64 {
        let mut sum = 0.0;
        for (i, ((e, a), b)) in value.iter().zip(y0).zip(y1).enumerate() {
            let atol = if self.atol.len() == 1 { self.atol[0] } else { self.atol[i] };
            let size = a.real().abs().max(b.real().abs());
            let ratio = e.real() / (atol + self.rtol * size);
            sum += ratio * ratio;
        }
        (sum / value.len().max(1) as f64).sqrt()
    }
}
