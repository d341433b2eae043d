//! The equilibrium-point model: position from the difference of the pressures, stiffness from their sum.
//!
//! ```text
//! x0 = α1 (P_f − P_e) + α0        K = β1 (P_f + P_e) + β0
//! ```
//!
//! (Wang and Realmuto 2026, section V-E). It is fitted to the equilibria and stiffnesses of recordings with
//! sealed muscles, and inverted to commands in closed form.

use crate::error::ControlError;
use crate::execution::Commands;
use crate::synthesis::Target;
use pam_core::units::MN_PER_N;
use pam_data::Recording;
use pam_numerics::least_squares;
use serde::Serialize;

/// Stiffness and equilibrium that one recording shows at its pressures.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Observation {
    /// The recording.
    pub name: String,
    /// Pressures at rest, flexor and extensor, kPa absolute.
    pub pressures_kpa: [f64; 2],
    /// Equilibrium position, mm.
    pub equilibrium_mm: f64,
    /// Stiffness, N/mm.
    pub stiffness_n_mm: f64,
}

/// The model.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct EquilibriumPoint {
    /// α1, mm/kPa.
    pub position_per_kpa: f64,
    /// α0, mm.
    pub position_mm: f64,
    /// β1, N/(mm·kPa).
    pub stiffness_per_kpa: f64,
    /// β0, N/mm.
    pub stiffness_n_mm: f64,
    /// R² of both lines.
    pub r2: [f64; 2],
}

/// Equilibrium and stiffness of a recording: the least-squares fit of
/// `M ẍ + B ẋ + K (x − x0) = F_e` with M, B, K and x0 free.
///
/// # Errors
/// [`ControlError::Insufficient`] if the recording does not move.
pub fn observe(recording: &Recording) -> Result<Observation, ControlError> {
    let (x, v, t) = (&recording.displacement_mm, &recording.velocity_mm_s, &recording.time_s);
    let reach = 10;
    let rows = (reach..x.len().saturating_sub(reach)).map(|k| {
        let acceleration = (v[k + reach] - v[k - reach]) / (t[k + reach] - t[k - reach]);
        ([acceleration, v[k], x[k], 1.0], recording.force_mn[k])
    });
    let insufficient = || {
        ControlError::Insufficient(format!(
            "recording {} does not move enough to show its stiffness",
            recording.name
        ))
    };
    let [_, _, stiffness, offset] = least_squares(rows, 0.0).ok_or_else(insufficient)?;
    let rest = recording.reading_at_rest();
    if !(stiffness.is_finite() && stiffness > 0.0) {
        return Err(insufficient());
    }
    Ok(Observation {
        name: recording.name.clone(),
        pressures_kpa: [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa],
        equilibrium_mm: -offset / stiffness,
        stiffness_n_mm: stiffness / MN_PER_N,
    })
}

impl EquilibriumPoint {
    /// The model of least squares.
    ///
    /// # Errors
    /// [`ControlError::Insufficient`] for fewer than three observations, or pressures that do not vary.
    pub fn fit(observations: &[Observation]) -> Result<Self, ControlError> {
        let pairs = |x: &dyn Fn([f64; 2]) -> f64, y: &dyn Fn(&Observation) -> f64| {
            line(&observations.iter().map(|o| [x(o.pressures_kpa), y(o)]).collect::<Vec<_>>())
        };
        let [position_per_kpa, position_mm, r2_position] =
            pairs(&|[f, e]| f - e, &|o| o.equilibrium_mm);
        let [stiffness_per_kpa, stiffness_n_mm, r2_stiffness] =
            pairs(&|[f, e]| f + e, &|o| o.stiffness_n_mm);
        let usable = position_per_kpa.is_finite()
            && position_per_kpa != 0.0
            && stiffness_per_kpa.is_finite()
            && stiffness_per_kpa != 0.0;
        if observations.len() < 3 || !usable {
            return Err(ControlError::Insufficient(format!(
                "{} recordings give no equilibrium-point model: sums and differences of their pressures \
                 must vary",
                observations.len()
            )));
        }
        Ok(Self {
            position_per_kpa,
            position_mm,
            stiffness_per_kpa,
            stiffness_n_mm,
            r2: [r2_position, r2_stiffness],
        })
    }

    /// The pressures for a position and a stiffness, kPa absolute.
    #[must_use]
    pub fn pressures_kpa(&self, displacement_mm: f64, stiffness_n_mm: f64) -> [f64; 2] {
        let difference = (displacement_mm - self.position_mm) / self.position_per_kpa;
        let sum = (stiffness_n_mm - self.stiffness_n_mm) / self.stiffness_per_kpa;
        [0.5 * (sum + difference), 0.5 * (sum - difference)]
    }

    /// Commands for targets at equal times.
    #[must_use]
    pub fn commands(&self, targets: &[Target]) -> Commands {
        let step_s = match targets {
            [a, b, ..] => b.time_s - a.time_s,
            _ => crate::execution::SAMPLE_S,
        };
        Commands {
            step_s,
            displacement_mm: targets.iter().map(|t| t.displacement_mm).collect(),
            stiffness_n_mm: targets.iter().map(|t| t.stiffness_n_mm).collect(),
            pressures_kpa: targets
                .iter()
                .map(|t| self.pressures_kpa(t.displacement_mm, t.stiffness_n_mm))
                .collect(),
        }
    }
}

/// Least-squares line `y = slope · x + offset`, with R².
fn line(points: &[[f64; 2]]) -> [f64; 3] {
    let n = points.len() as f64;
    let mean = |i: usize| points.iter().map(|p| p[i]).sum::<f64>() / n;
    let (mx, my) = (mean(0), mean(1));
    let sum = |f: &dyn Fn(&[f64; 2]) -> f64| points.iter().map(f).sum::<f64>();
    let xy = sum(&|p| (p[0] - mx) * (p[1] - my));
    let xx = sum(&|p| (p[0] - mx).powi(2));
    let yy = sum(&|p| (p[1] - my).powi(2));
    let slope = xy / xx;
    [slope, my - slope * mx, xy * xy / (xx * yy)]
}
