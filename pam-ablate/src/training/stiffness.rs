//! Stiffness of a trained model by the exact derivative or by differences.
//!
//! | metric | |
//! |---|---|
//! | `stiffness_error_percent` | mean of `100 |K − K_shown|/K_shown` over recordings: K at rest of the model, K_shown of the recording's motion (least squares of `M ẍ + B ẋ + K (x − x0) = F`) |
//! | `stiffness_from_exact_n_mm` | RMS difference from the exact derivative of the same network, over the line of the next row |
//! | `stiffness_step_n_mm` | mean change of K over 0.01 mm, x from −2.5 to 2.5 mm at rest |
//! | `stiffness_mean_n_mm` | mean of K over the recordings at rest |
//!
//! The recordings are the held-out ones, or those trained on if none is held out. The time
//! `stiffness_s` is that of one value.

use crate::experiment::{Measurements, Problem};
use num_dual::Dual64;
use pam_autodiff::finite_difference::{
    Central, DifferenceScheme, Forward, FourPointSmoothed, Richardson,
};
use pam_autodiff::{stiffness_by_difference_n_mm, stiffness_exact_n_mm};
use pam_control::equilibrium_point::observe;
use pam_core::{ForceInput, NetworkForce, Scalar, SealedMasses};
use pam_data::{MassChoice, Recording, resolve_masses};
use pam_numerics::statistics::mean;
use pam_train::curriculum::Curriculum;
use pam_trajectory::engine::NetworkJoint;
use serde::{Deserialize, Serialize};
use std::time::Instant;

/// How stiffness is taken from a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StiffnessProbe {
    /// `exact` (dual numbers), `forward`, `central`, `published` (the source's four points) or
    /// `richardson`.
    pub scheme: String,
    /// Step of a difference, mm.
    pub step_mm: f64,
}

impl Default for StiffnessProbe {
    fn default() -> Self {
        Self { scheme: "exact".into(), step_mm: 1.0 }
    }
}

/// Where the line of x ends, mm, and the distance of its points.
const LINE: (f64, f64) = (2.5, 0.01);

/// The recordings whose stiffness is compared.
pub(super) fn subjects(recordings: &[Recording], curriculum: &Curriculum) -> Vec<Recording> {
    let data = &curriculum.data;
    let found = data.split(Vec::from(recordings)).held_out;
    if found.is_empty() { recordings.to_vec() } else { found }
}

impl StiffnessProbe {
    /// Says whether scheme and step make sense.
    pub(super) fn check(&self) -> Result<(), String> {
        if !(self.step_mm.is_finite() && self.step_mm > 0.0) {
            return Err("stiffness.step_mm must be positive".into());
        }
        self.difference().map(|_| ())
    }

    /// The scheme; none for the exact derivative.
    fn difference(&self) -> Result<Option<Box<dyn DifferenceScheme>>, String> {
        let h = self.step_mm;
        Ok(match self.scheme.as_str() {
            "exact" => None,
            "forward" => Some(Box::new(Forward { h })),
            "central" => Some(Box::new(Central { h })),
            "published" => Some(Box::new(FourPointSmoothed { h })),
            "richardson" => Some(Box::new(Richardson { h, ..Richardson::default() })),
            other => {
                return Err(format!(
                    "`{other}` is no scheme of stiffness: exact, forward, central, published, richardson"
                ));
            }
        })
    }

    /// Adds what it finds.
    pub(super) fn measure(
        &self,
        model: &NetworkJoint,
        recordings: &[Recording],
        found: &mut Measurements,
    ) -> Result<(), Problem> {
        let scheme = self.difference()?;
        let force = &model.force;
        let dual: NetworkForce<Dual64> = force.map(Dual64::constant);
        let stiffness = |at: &ForceInput<f64>| match &scheme {
            None => stiffness_exact_n_mm(&dual, at),
            Some(scheme) => stiffness_by_difference_n_mm(force, at, scheme.as_ref()),
        };
        let (mut errors, mut all) = (Vec::new(), Vec::new());
        let (mut squares, mut steps) = (Vec::new(), Vec::new());
        let mut seconds = 0.0;
        for r in recordings {
            let (masses, _) = resolve_masses(r, model, true, MassChoice::Auto, None)
                .map_err(|e| Problem::new(e.to_string()))?;
            let k = stiffness(&at_rest(r.reading_at_rest().displacement_mm, masses));
            all.push(k);
            // A recording that hardly moves shows no stiffness.
            if let Ok(shown) = observe(r) {
                errors.push(100.0 * (k - shown.stiffness_n_mm).abs() / shown.stiffness_n_mm);
            }
            let count = (LINE.0 / LINE.1).round() as i32;
            let line: Vec<ForceInput<f64>> =
                (-count..=count).map(|i| at_rest(LINE.1 * f64::from(i), masses)).collect();
            let begun = Instant::now();
            let values: Vec<f64> = line.iter().map(&stiffness).collect();
            seconds += begun.elapsed().as_secs_f64() / line.len() as f64;
            steps.extend(values.windows(2).map(|p| (p[1] - p[0]).abs()));
            squares.extend(
                line.iter()
                    .zip(&values)
                    .map(|(at, v)| (v - stiffness_exact_n_mm(&dual, at)).powi(2)),
            );
        }
        found.metrics.extend([
            ("stiffness_error_percent".into(), mean(&errors)),
            ("stiffness_from_exact_n_mm".into(), mean(&squares).sqrt()),
            ("stiffness_step_n_mm".into(), mean(&steps)),
            ("stiffness_mean_n_mm".into(), mean(&all)),
        ]);
        found.times.push(("stiffness_s".into(), seconds / recordings.len() as f64));
        Ok(())
    }
}

fn at_rest(displacement_mm: f64, masses: SealedMasses) -> ForceInput<f64> {
    ForceInput {
        displacement_mm,
        velocity_mm_s: 0.0,
        mass_flexor_g: masses.flexor_g,
        mass_extensor_g: masses.extensor_g,
    }
}
