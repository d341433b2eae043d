use pam_core::Scalar;
use std::f64::consts::PI;

/// A first-order Butterworth low-pass, run forward and back so that it shifts no phase.
///
/// The filter is the bilinear transform of `1/(1 + s/ω_c)`; the ends are extended by an odd
/// reflection of six samples and the recursion starts in its steady state, which is what
/// `scipy.signal.filtfilt(*butter(1, cutoff, fs=rate), x)` computes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LowPass {
    /// Both feed-forward coefficients.
    b: f64,
    /// Feedback coefficient a₁.
    a: f64,
    /// Samples by which the ends are extended.
    padding: usize,
}

impl LowPass {
    /// Samples by which the ends of recordings are extended.
    pub const PADDING: usize = 6;

    /// A filter with cutoff `cutoff_hz` for data sampled at `rate_hz`; `None` unless
    /// `0 < cutoff < rate/2`.
    #[must_use]
    pub fn new(cutoff_hz: f64, rate_hz: f64) -> Option<Self> {
        Self::like(cutoff_hz, rate_hz, rate_hz)
    }

    /// The filter for data sampled at `own_rate_hz` that approximates one with cutoff `cutoff_hz` at the sampling rate `rate_hz`;
    /// `None` unless `0 < cutoff < rate/2`.
    ///
    /// Its response matches `1/(1 + (tan(π f/rate)/tan(π cutoff/rate))²)` to second order in the frequency `f`: because of the frequency
    /// warping of the bilinear transform, a cutoff of 20 Hz at 100 samples per second corresponds to 23 Hz at a high rate. The ends
    /// are extended by the same duration, by at most [`PADDING`](Self::PADDING) samples.
    #[must_use]
    pub fn like(cutoff_hz: f64, rate_hz: f64, own_rate_hz: f64) -> Option<Self> {
        let valid = cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz && rate_hz.is_finite();
        valid.then(|| {
            let w = (PI * cutoff_hz / rate_hz).tan() * rate_hz / own_rate_hz;
            let padding = (Self::PADDING as f64 * own_rate_hz / rate_hz).round();
            let padding = padding.clamp(0.0, Self::PADDING as f64) as usize;
            Self { b: w / (1.0 + w), a: (w - 1.0) / (w + 1.0), padding }
        })
    }

    /// The fewest samples that can be filtered.
    #[must_use]
    pub fn shortest() -> usize {
        Self::PADDING + 1
    }

    /// Samples after which nothing of a value is left: by as many an early end changes none before it.
    #[must_use]
    pub fn memory(&self) -> usize {
        Self::PADDING + (f64::EPSILON.powi(2).ln() / self.a.abs().ln()).ceil().max(0.0) as usize
    }

    /// `values` filtered forward and back.
    ///
    /// # Panics
    /// If there are fewer than [`shortest`](LowPass::shortest) samples.
    #[must_use]
    #[inline(always)]
    pub fn forward_backward<S: Scalar>(&self, values: &[S]) -> Vec<S> {
        let (n, pad) = (values.len(), self.padding);
        assert!(n >= Self::shortest(), "{n} samples are too few to filter");
        let (first, last) = (values[0], values[n - 1]);
        let mut extended = Vec::with_capacity(n + 2 * pad);
        extended.extend((1..=pad).rev().map(|i| first.scaled(2.0) - values[i]));
        extended.extend_from_slice(values);
        extended.extend((1..=pad).map(|i| last.scaled(2.0) - values[n - 1 - i]));
        self.run(extended.iter_mut());
        self.run(extended.iter_mut().rev());
        extended.truncate(pad + n);
        extended.drain(..pad);
        extended
    }

    /// The transpose of [`forward_backward`](Self::forward_backward), which is linear: from the derivative of
    /// a number by the filtered values to that by the values.
    ///
    /// # Panics
    /// If there are fewer than [`shortest`](Self::shortest) values.
    #[must_use]
    pub fn transposed(&self, by_filtered: &[f64]) -> Vec<f64> {
        let (n, pad) = (by_filtered.len(), self.padding);
        assert!(n >= Self::shortest(), "{n} samples are too few to filter");
        let mut by_extended = vec![0.0; n + 2 * pad];
        by_extended[pad..pad + n].copy_from_slice(by_filtered);
        self.run_transposed(by_extended.iter_mut().rev());
        self.run_transposed(by_extended.iter_mut());
        let mut by = by_extended[pad..pad + n].to_vec();
        for i in 1..=pad {
            let (front, back) = (by_extended[pad - i], by_extended[pad + n - 1 + i]);
            by[0] += 2.0 * front;
            by[i] -= front;
            by[n - 1] += 2.0 * back;
            by[n - 1 - i] -= back;
        }
        by
    }

    /// The transpose of [`run`](Self::run) over the same order of values.
    fn run_transposed<'a>(&self, values: impl DoubleEndedIterator<Item = &'a mut f64>) {
        let Self { b, a, .. } = *self;
        let mut by_state = 0.0;
        let mut first = None;
        for v in values.rev() {
            let by_y = *v - a * by_state;
            *v = b * (by_y + by_state);
            by_state = by_y;
            first = Some(v);
        }
        if let Some(v) = first {
            *v += (1.0 - b) * by_state;
        }
    }

    /// One pass in place, started in the steady state of the first value.
    #[inline(always)]
    fn run<'a, S: Scalar + 'a>(&self, mut values: impl Iterator<Item = &'a mut S>) {
        let Self { b, a, .. } = *self;
        // In the steady state, the first value is let through.
        let Some(first) = values.next() else { return };
        let mut state = S::combination([first, first], [b, -a]);
        for v in values {
            let y = S::combination([v, &state], [b, 1.0]);
            state = S::combination([v, &y], [b, -a]);
            *v = y;
        }
    }
}
