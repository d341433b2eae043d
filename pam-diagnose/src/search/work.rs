//! The computational cost of simulations.

use std::sync::atomic::{AtomicU64, Ordering};

/// The computational cost of simulations, counted so that it is the same on every machine and with any number of threads.
///
/// A step costs `(2 + v)(1 + d / 80)`, with the number `v` of fitted values and `d` of derivatives: a fit to measured times, in units of half
/// a step of the model without effects.
#[derive(Debug, Default)]
pub struct Work(AtomicU64);

/// Cost of a step without fitted values.
const OF_A_STEP: u64 = 2;
/// Number of derivatives that cost as much as the values themselves.
const DERIVATIVES: u64 = 80;

impl Work {
    /// A count that goes on from another one.
    #[cfg(feature = "joint")]
    pub(crate) fn starting_at(steps: f64) -> Self {
        Self(AtomicU64::new((steps * (OF_A_STEP * DERIVATIVES) as f64) as u64))
    }

    /// Counts a simulation.
    pub(crate) fn add(&self, steps: usize, values: usize, derivatives: usize) {
        let of_a_step = (OF_A_STEP + values as u64) * (DERIVATIVES + derivatives as u64);
        self.0.fetch_add(steps as u64 * of_a_step, Ordering::Relaxed);
    }

    /// Everything so far, in steps of the model without effects.
    pub(crate) fn steps(&self) -> f64 {
        self.0.load(Ordering::Relaxed) as f64 / (OF_A_STEP * DERIVATIVES) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_and_derivatives_add_to_the_work() {
        let work = Work::default();
        work.add(1000, 0, 0);
        assert_eq!(work.steps(), 1000.0);
        work.add(1000, 2, 0);
        assert_eq!(work.steps(), 3000.0);
        work.add(1000, 0, 80);
        assert_eq!(work.steps(), 5000.0);
        #[cfg(feature = "joint")]
        assert_eq!(Work::starting_at(5000.0).steps(), 5000.0);
    }
}
