use super::{ActiveEffect, ExtendedModel};
use crate::simulation::observation::place;
use crate::simulation::{Nuisances, ResampledRecord, Trajectory, Trial, range_of, simulate};
use pam_core::SealedMasses;
use pam_data::Subject;
use pam_data::{Channel, MassOrigin, Recording};
use pam_solvers::{Interpolation, Statistics};
use pam_trajectory::{PerChannel, PredictError, Prediction, Predictor, SolverSettings, predict};

/// How often the table of the force is widened for a motion that leaves it.
const WIDENINGS: usize = 8;

/// Without effects the model is solved as the settings say. With effects it takes the steps of
/// [`simulate`] (at most 4 ms, fourth order, sticking friction); of the settings only the reading of the force counts.
impl Predictor for ExtendedModel {
    fn predict(
        &self,
        recording: &Recording,
        masses: SealedMasses,
        settings: &SolverSettings,
    ) -> Result<Prediction, Box<PredictError>> {
        if self.effects.is_empty() {
            return predict(&self.joint, recording, masses, settings);
        }
        // Masses that follow from the sealed reading change with effects of its sensors.
        let law = self.joint.gas_law_masses(
            recording.reading_at_rest().displacement_mm,
            [
                recording.reading_at_rest().pressure_flexor_kpa,
                recording.reading_at_rest().pressure_extensor_kpa,
            ],
        );
        let same = |a: f64, b: f64| (a - b).abs() <= 1e-9 * b.abs();
        let by_law = recording.given_masses.is_none()
            && same(law.flexor_g, masses.flexor_g)
            && same(law.extensor_g, masses.extensor_g);
        let origin = if by_law { MassOrigin::GasLaw } else { MassOrigin::Given };
        let subject = Subject { recording: recording.clone(), masses, origin };
        if let Err(e) = ResampledRecord::check(&subject) {
            let partial =
                Prediction { channels: PerChannel::default(), statistics: Statistics::default() };
            let (name, why) = (recording.name.clone(), e.to_string());
            return Err(Box::new(PredictError { name, why, partial }));
        }
        let (effects, values) = ActiveEffect::split(&self.effects);
        // Straight lines between samples lead a held force by half a sample.
        let lead_samples = match settings.interpolation {
            Interpolation::Hold | Interpolation::Ramp => 0.0,
            Interpolation::Linear | Interpolation::Cubic => 0.5,
        };
        let nuisances = Nuisances { lead_samples, ..Nuisances::none() };
        let mut out = Trajectory::default();
        let base = self.base();
        let mut ranges = [Channel::X, Channel::V].map(|c| range_of(recording.channel(c)));
        let mut left = WIDENINGS;
        // Where the motion goes is not known if it was not measured: the table grows until it is inside.
        let (trial, reached) = loop {
            let trial = Trial::over(&self.joint, &subject, ranges);
            let reached = simulate::<f64>(&trial, &base, &effects, &values, &nuisances, &mut out);
            let mut inside = true;
            for (range, channel) in ranges.iter_mut().zip(&out.channels) {
                let [low, high] = range_of(channel);
                let margin = 0.2 * (range[1] - range[0]) + 0.4;
                inside &= range[0] - margin <= low && high <= range[1] + margin;
                *range = [range[0].min(low), range[1].max(high)];
            }
            left -= 1;
            if inside || left == 0 || ranges.iter().flatten().any(|v| !v.is_finite()) {
                break (trial, reached);
            }
        };
        let t0 = recording.time_s[0];
        let end = match reached {
            Ok(()) => f64::INFINITY,
            Err(diverged) => diverged.time_s,
        };
        let times: Vec<f64> =
            recording.time_s.iter().map(|t| t - t0).take_while(|&t| t < end).collect();
        let column = |c: usize| -> Vec<f64> {
            let values = &out.channels[c];
            let value = |t: &f64| {
                let (k, share) = place(values.len(), trial.record.step_s, *t);
                values[k] + share * (values[(k + 1).min(values.len() - 1)] - values[k])
            };
            times.iter().map(value).collect()
        };
        let channels = PerChannel { x: column(0), v: column(1), pf: column(2), pe: column(3) };
        let steps = trial.record.points().saturating_sub(1);
        let statistics =
            Statistics { accepted: steps, evaluations: 4 * steps, ..Statistics::default() };
        let prediction = Prediction { channels, statistics };
        match reached {
            Ok(()) => Ok(prediction),
            Err(e) => Err(Box::new(PredictError {
                name: recording.name.clone(),
                why: format!("{e}; the force, the model or its effects are not of this joint"),
                partial: prediction,
            })),
        }
    }
}
