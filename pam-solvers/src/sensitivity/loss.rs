/// A scalar function of the observed states that knows its derivative.
///
/// Any closure `|times_s, states, cotangents| -> value` is one:
///
/// ```
/// use pam_solvers::sensitivity::Loss;
///
/// /// Half the squared first state, summed over the observations.
/// fn energy(_times_s: &[f64], states: &[f64], cotangents: &mut [f64]) -> f64 {
///     let mut value = 0.0;
///     for (y, w) in states.chunks_exact(2).zip(cotangents.chunks_exact_mut(2)) {
///         value += 0.5 * y[0] * y[0];
///         w[0] = y[0];
///     }
///     value
/// }
///
/// let mut cotangents = [0.0; 4];
/// let loss: &mut dyn Loss = &mut energy;
/// let value = loss.value_and_cotangents(&[0.0, 1.0], &[3.0, 9.0, 4.0, 9.0], &mut cotangents);
/// assert_eq!((value, cotangents), (12.5, [3.0, 0.0, 4.0, 0.0]));
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no loss of observed states",
    note = "write a closure with all types: \
            `|times_s: &[f64], states: &[f64], cotangents: &mut [f64]| -> f64`, and pass `&mut` of it"
)]
pub trait Loss {
    /// Returns the loss of `states` (row-major `[times, states]`) at `times_s` (s) and writes its
    /// derivative with respect to every state to `cotangents`, which has the same shape and holds
    /// zeros.
    ///
    /// The value must depend on nothing but the states, or finite differences mean nothing.
    fn value_and_cotangents(
        &mut self,
        times_s: &[f64],
        states: &[f64],
        cotangents: &mut [f64],
    ) -> f64;
}

impl<L: FnMut(&[f64], &[f64], &mut [f64]) -> f64> Loss for L {
    fn value_and_cotangents(
        &mut self,
        times_s: &[f64],
        states: &[f64],
        cotangents: &mut [f64],
    ) -> f64 {
        self(times_s, states, cotangents)
    }
}

/// The value of `loss`; its cotangents go to `cotangents`, whose memory is reused.
pub(super) fn evaluate(
    loss: &mut dyn Loss,
    times_s: &[f64],
    states: &[f64],
    cotangents: &mut Vec<f64>,
) -> f64 {
    cotangents.clear();
    cotangents.resize(states.len(), 0.0);
    loss.value_and_cotangents(times_s, states, cotangents)
}
