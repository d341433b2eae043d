//! How far to trust a diagnosis on one rig.
//!
//! Baseline recordings, in which nothing is wrong, are simulated again with an effect in them, at multiples of its
//! [detection limit](crate::detect), and get residuals of their own back, resampled in blocks
//! ([`Synthesis`](crate::plan::Synthesis)). The whole diagnosis runs on each of these sets and on null sets without an effect ([`run_cases`]). Its answers give the confusion
//! matrix, the rate of false alarms and the detection curves with exact limits, the coverage of intervals ([`Summary`]), and
//! settings under which false alarms hold the level that was asked for, with a [`Certificate`] that later diagnoses quote.

mod case;
mod certificate;
mod report;
mod run;
mod shares;
mod summary;

pub use case::{Case, Outcome, Plan, plan};
pub use certificate::{Certificate, Trust};
pub use report::certificate_report;
pub use run::{CertifyFolder, Progress, Work, run_cases, with_baseline};
pub use shares::clopper_pearson;
pub use summary::{Confusion, Coverage, Detected, Summary, settings_file};

use crate::detect::DetectOptions;

/// What is certified.
#[derive(Debug, Clone)]
pub struct CertifyOptions {
    /// Effects, candidates and settings of the diagnosis.
    pub detect: DetectOptions,
    /// Magnitudes in multiples of the limit from which an effect is named.
    pub multiples: Vec<f64>,
    /// Sets of each effect and magnitude.
    pub repeats: usize,
    /// Null sets.
    pub nulls: usize,
    /// Rate of false alarms that the certified settings hold.
    pub level: f64,
    /// Seed of residuals and diagnoses.
    pub seed: u64,
}

impl Default for CertifyOptions {
    fn default() -> Self {
        Self {
            detect: DetectOptions::default(),
            multiples: vec![1.5, 3.0],
            repeats: 5,
            nulls: 60,
            level: 0.05,
            seed: 1,
        }
    }
}
