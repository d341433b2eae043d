//! The force over equal intervals between samples.

use crate::forcing::{Line, StepForcing};

/// Intervals may differ by this share of their mean.
const UNEQUAL: f64 = 1e-9;
/// Fewest samples for which equal steps are worth their start.
const FEWEST: usize = 64;

/// Weights of the impulses of five intervals in the integral, over the middle one, of a smooth curve through their sums, less
/// its start: Adams' method of sixth order around the middle.
const CENTRED: [f64; 5] =
    [-11.0 / 1440.0, 82.0 / 1440.0, 720.0 / 1440.0, -82.0 / 1440.0, 11.0 / 1440.0];

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
    // A sum in place of an early exit: the loop is vectorised.
    let equal = times_s.iter().enumerate().fold(true, |all, (k, t)| {
        all & ((t - start_s - mean * (k as u32 + 1) as f64).abs() <= UNEQUAL * mean)
    });
    first > start_s && equal
}

impl SampleForcing {
    /// Takes the force between the start and each of the times, which are equally far apart.
    #[inline(always)]
    pub(crate) fn take(
        &mut self,
        lines: &[Line],
        start_s: f64,
        times_s: &[f64],
        forcing: &mut StepForcing,
    ) {
        let count = times_s.len();
        self.interval_s = (times_s[count - 1] - start_s) / count as f64;
        self.integrate(lines, start_s, times_s, forcing);
        let per_interval = self.interval_s.recip();
        self.excess.clear();
        self.excess.resize(count + 1, 0.0);
        // Of the intervals before and after a sample, from the fourth sample on.
        let inner = count - 5;
        let (excess, double) = (&mut self.excess[3..3 + inner], &self.double[2..3 + inner]);
        let impulse = &self.impulse[..inner + 5];
        for k in 0..inner {
            let mut curve = 0.0;
            for (i, weight) in CENTRED.iter().enumerate() {
                curve += weight * (impulse[k + i] + impulse[k + i + 1]);
            }
            excess[k] = 0.5 * ((double[k] + double[k + 1]) * per_interval - curve);
        }
        let (early, late) = (self.excess[3], self.excess[2 + inner]);
        self.excess[..3].fill(early);
        self.excess[3 + inner..].fill(late);
        self.total.clear();
        self.total.reserve(count + 1);
        let mut sum = 0.0;
        for (impulse, excess) in self.impulse.iter().zip(&self.excess) {
            self.total.push(sum + excess);
            sum += impulse;
        }
        self.total.push(sum + late);
    }

    /// Integrals over each interval.
    #[inline(always)]
    fn integrate(
        &mut self,
        lines: &[Line],
        start_s: f64,
        times_s: &[f64],
        forcing: &mut StepForcing,
    ) {
        let dt = self.interval_s;
        for values in [&mut self.impulse, &mut self.double] {
            values.clear();
            values.reserve(times_s.len());
        }
        let mut line = lines.partition_point(|l| l.start_s() <= start_s).saturating_sub(1);
        let own = &lines[line..];
        let begins = std::iter::once(&start_s).chain(times_s);
        let one_each = own.len() >= times_s.len()
            && own.iter().zip(begins).fold(true, |all, (l, t)| all & (l.start_s() == *t));
        if one_each {
            self.impulse.extend(own[..times_s.len()].iter().map(|l| l.integrals(dt)[0]));
            self.double.extend(own[..times_s.len()].iter().map(|l| l.integrals(dt)[1]));
            return;
        }
        let mut from = start_s;
        for &to in times_s {
            while line + 1 < lines.len() && lines[line + 1].start_s() <= from {
                line += 1;
            }
            forcing.take(lines, line, from, to);
            let [impulse, double] = forcing.integrals(to - from);
            self.impulse.push(impulse);
            self.double.push(double);
            from = to;
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
