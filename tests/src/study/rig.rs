//! Size of what is hidden in recordings of the virtual rig, relative to the error of the model there.
//!
//! The rig is another joint than the model, so what limits a diagnosis is the error of the model without any fault. The
//! size of a fault is `S² = Σ_c E_c / (D_c²/R)`: over the channels x, P_f, P_e, the mean square of the change of the
//! model's error by the fault, over the mean square `D_c²` of that error without it, one value for each of `R` recordings.

use pam_core::{AnyForce, JointModel};
use pam_data::{Recording, Subject};
use pam_trajectory::{Predictor, SolverSettings};
use rayon::prelude::*;

/// Errors of a model on recordings without a fault.
#[derive(Debug)]
pub struct Errors<'a> {
    model: &'a JointModel<f64, AnyForce<f64>>,
    /// For each recording and channel.
    healthy: Vec<[Vec<f64>; 3]>,
}

impl<'a> Errors<'a> {
    /// Simulates the recordings.
    #[must_use]
    pub fn of(model: &'a JointModel<f64, AnyForce<f64>>, healthy: &[Subject]) -> Self {
        Self { model, healthy: errors(model, healthy) }
    }

    /// The size of a fault that acts in these recordings, which are otherwise the same.
    ///
    /// # Panics
    /// If the recordings are others.
    #[must_use]
    pub fn size(&self, faulty: &[Subject]) -> f64 {
        let faulty = errors(self.model, faulty);
        assert_eq!(faulty.len(), self.healthy.len());
        let recordings = faulty.len() as f64;
        let each = |c: usize| {
            let (mut change, mut own) = (0.0, 0.0);
            for (with, without) in faulty.iter().zip(&self.healthy) {
                let n = with[c].len().min(without[c].len()).max(1) as f64;
                let pairs = with[c].iter().zip(&without[c]);
                change += pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>() / n / recordings;
                own += without[c].iter().map(|v| v * v).sum::<f64>() / n / recordings;
            }
            change / (own / recordings).max(f64::MIN_POSITIVE)
        };
        (0..3).map(each).sum::<f64>().sqrt()
    }
}

/// Measured minus predicted x, P_f, P_e.
fn errors(model: &JointModel<f64, AnyForce<f64>>, all: &[Subject]) -> Vec<[Vec<f64>; 3]> {
    let of = |s: &Subject| {
        let r: &Recording = &s.recording;
        let settings = SolverSettings::default();
        let seen = match model.predict(r, s.masses, &settings) {
            Ok(prediction) => prediction,
            Err(stopped) => stopped.partial,
        };
        let measured = [&r.displacement_mm, &r.pressure_flexor_kpa, &r.pressure_extensor_kpa];
        let predicted = [seen.channels.x, seen.channels.pf, seen.channels.pe];
        let mut pairs = measured.into_iter().zip(predicted);
        [(); 3].map(|()| {
            let (m, p) = pairs.next().expect("three channels");
            m.iter().zip(&p).map(|(m, p)| m - p).collect()
        })
    };
    all.par_iter().map(of).collect()
}
