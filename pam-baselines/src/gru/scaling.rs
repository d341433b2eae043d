//! Min–max scaling to [−1, 1].

use pam_data::{Channel, Recording, Subject};
use pam_numerics::statistics::mean;

use super::parameters::{INPUTS, OUTPUTS};

/// Smallest and largest value of x, ẋ, P_f, P_e and F (mm, mm/s, kPa, kPa, mN).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scaling {
    /// Smallest values.
    pub low: [f64; INPUTS],
    /// Largest values.
    pub high: [f64; INPUTS],
}

impl Scaling {
    /// The range of all samples of the recordings; a column that does not vary gets a width of one.
    #[must_use]
    pub fn of(subjects: &[Subject]) -> Self {
        let mut scaling = Self { low: [f64::INFINITY; INPUTS], high: [f64::NEG_INFINITY; INPUTS] };
        for s in subjects {
            let r = &s.recording;
            let columns = Channel::ALL.map(|c| r.channel(c)).into_iter().chain([&r.force_mn[..]]);
            for (c, column) in columns.enumerate() {
                for v in column {
                    scaling.low[c] = scaling.low[c].min(*v);
                    scaling.high[c] = scaling.high[c].max(*v);
                }
            }
        }
        for c in 0..INPUTS {
            if scaling.high[c] <= scaling.low[c] {
                scaling.high[c] = scaling.low[c] + 1.0;
            }
        }
        scaling
    }

    /// Sample `k` of a recording, scaled.
    #[must_use]
    pub fn input(&self, r: &Recording, k: usize) -> [f64; INPUTS] {
        let [x, v, pf, pe] = Channel::ALL.map(|c| r.channel(c)[k]);
        let values = [x, v, pf, pe, r.force_mn[k]];
        std::array::from_fn(|c| self.scale(c, values[c]))
    }

    /// The same with the mean of the force over this sample and those after it, `samples` in all: what acts
    /// until the next step of a network that does not read every sample.
    #[must_use]
    pub fn input_over(&self, r: &Recording, k: usize, samples: usize) -> [f64; INPUTS] {
        let mut input = self.input(r, k);
        input[OUTPUTS] = self.force_over(r, k, samples);
        input
    }

    /// The mean force over samples `k..k + samples` (as many as there are), scaled.
    #[must_use]
    pub fn force_over(&self, r: &Recording, k: usize, samples: usize) -> f64 {
        let held = &r.force_mn[k..(k + samples).min(r.len())];
        self.scale(OUTPUTS, mean(held))
    }

    /// One value, scaled.
    #[must_use]
    pub fn scale(&self, column: usize, value: f64) -> f64 {
        2.0 * (value - self.low[column]) / (self.high[column] - self.low[column]) - 1.0
    }

    /// A scaled state in its units.
    #[must_use]
    pub fn state(&self, scaled: [f64; OUTPUTS]) -> [f64; OUTPUTS] {
        std::array::from_fn(|c| {
            0.5 * (scaled[c] + 1.0) * (self.high[c] - self.low[c]) + self.low[c]
        })
    }
}
