//! The force over equal intervals between samples.

use crate::forcing::{Line, StepForcing};

/// Intervals may differ by this share of their mean.
const UNEQUAL: f64 = 1e-9;
/// Fewest samples for which equal steps are worth their start.
const FEWEST: usize = 64;

/// Weights, at two points before an interval to two after it, of the integral over the interval (Adams' method of sixth order
/// around the middle).
const CENTRED: [f64; 6] = [11.0, -93.0, 802.0, 802.0, -93.0, 11.0];
const CENTRED_SUM: f64 = 1440.0;

/// Integrals of the force over equal intervals.
#[derive(Debug, Default)]
pub(crate) struct SampleForcing {
    /// Length of an interval, s.
    pub(crate) interval_s: f64,
    /// `∫ F dt` (mN s) and `∫∫ F dt²` (mN s²) of each interval from its start.
    pub(crate) impulse: Vec<f64>,
    pub(crate) double: Vec<f64>,
    /// By how much the impulse in the middle of the intervals around a sample exceeds a smooth curve through its values at the
    /// samples, mN s: a held force leaves such a mean, lines do not.
    pub(crate) excess: Vec<f64>,
    /// Impulse since the first sample with the excess, mN s.
    pub(crate) total: Vec<f64>,
}

/// Whether times are equally far apart, and many.
pub(crate) fn equal_intervals(start_s: f64, times_s: &[f64]) -> bool {
    let (Some(&first), Some(&last)) = (times_s.first(), times_s.last()) else { return false };
    if times_s.len() < FEWEST {
        return false;
    }
    let mean = (last - start_s) / times_s.len() as f64;
    let far = |(k, t): (usize, &f64)| (t - start_s - mean * (k + 1) as f64).abs();
    let worst = times_s.iter().enumerate().map(far).fold(0.0, f64::max);
    first > start_s && worst <= UNEQUAL * mean
}

impl SampleForcing {
    /// Takes the force between the start and each of the times, which are equally far apart.
    pub(crate) fn take(
        &mut self,
        lines: &[Line],
        start_s: f64,
        times_s: &[f64],
        forcing: &mut StepForcing,
    ) {
        let count = times_s.len();
        self.interval_s = (times_s[count - 1] - start_s) / count as f64;
        let dt = self.interval_s;
        for values in [&mut self.impulse, &mut self.double] {
            values.clear();
            values.reserve(count);
        }
        let mut from = start_s;
        let mut line = lines.partition_point(|l| l.start_s() <= start_s).saturating_sub(1);
        for &to in times_s {
            while line + 1 < lines.len() && lines[line + 1].start_s() <= from {
                line += 1;
            }
            let within = lines[line].start_s() == from
                && lines.get(line + 1).is_none_or(|next| next.start_s() >= to);
            let [impulse, double] = if within {
                lines[line].integrals(dt)
            } else {
                forcing.take(lines, line, from, to);
                forcing.integrals(to - from)
            };
            self.impulse.push(impulse);
            self.double.push(double);
            from = to;
        }
        self.total.clear();
        self.total.reserve(count + 1);
        let mut sum = 0.0;
        self.total.push(0.0);
        for impulse in &self.impulse {
            sum += impulse;
            self.total.push(sum);
        }
        // ∫ of the impulse over an interval beyond that of the curve.
        self.excess.clear();
        self.excess.resize(count + 1, 0.0);
        let mut before = 0.0;
        for k in 2..count - 2 {
            let window = &self.total[k - 2..k + 4];
            let curve: f64 = CENTRED.iter().zip(window).map(|(w, c)| w * (c - window[2])).sum();
            let beyond = self.double[k] / dt - curve / CENTRED_SUM;
            self.excess[k] = 0.5 * if k == 2 { 2.0 * beyond } else { before + beyond };
            before = beyond;
        }
        let (early, late) = (self.excess[2], before);
        self.excess[..2].fill(early);
        self.excess[count - 2..].fill(late);
        for (total, excess) in self.total.iter_mut().zip(&self.excess) {
            *total += excess;
        }
    }

    /// `[∫ F dt, ∫∫ F dt²]` over intervals from one sample on.
    #[inline(always)]
    pub(crate) fn over(&self, first: usize, count: usize) -> [f64; 2] {
        let (mut impulse, mut double) = (0.0, 0.0);
        let intervals = self.impulse[first..first + count].iter().zip(&self.double[first..]);
        for (own, own_double) in intervals {
            double += self.interval_s * impulse + own_double;
            impulse += own;
        }
        [impulse, double]
    }
}
