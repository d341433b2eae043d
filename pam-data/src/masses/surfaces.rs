//! Force and pressure surfaces of a single muscle over air mass and stretch.

use crate::error::DataError;
use crate::formats::mat;
use crate::preprocess::gradient;
use crate::recording::Recording;
use pam_core::SealedMasses;
use std::path::{Path, PathBuf};

/// Recordings are at equilibrium where the external force is below this, mN.
const EQUILIBRIUM_FORCE_MN: f64 = 1000.0;
/// Air masses that the surfaces were measured for, g.
const MASS_LIMIT_G: f64 = 0.2;

/// A polynomial `Σ c · m^i · s^j` with its derivative in m.
#[derive(Debug, Clone, PartialEq)]
struct Surface {
    terms: Vec<(f64, i32, i32)>,
}

impl Surface {
    /// Value and derivative in m at mass `m` (g) and stretch `s` (m).
    fn value_and_slope(&self, m: f64, s: f64) -> (f64, f64) {
        self.terms.iter().fold((0.0, 0.0), |(value, slope), &(c, i, j)| {
            let along = c * s.powi(j);
            let rise = if i == 0 { 0.0 } else { f64::from(i) * m.powi(i - 1) };
            (value + along * m.powi(i), slope + along * rise)
        })
    }

    fn value(&self, m: f64, s: f64) -> f64 {
        self.value_and_slope(m, s).0
    }
}

/// Pressure (kPa absolute) and force (N) of one branch of a single muscle.
#[derive(Debug, Clone, PartialEq)]
struct Branch {
    pressure: Surface,
    force: Surface,
}

/// The published fits to single-muscle tests, loading and unloading branch
/// (`poly44_all_fits.mat`): force (N) and pressure (kPa absolute) as fourth-degree polynomials of
/// mass (g) and stretch (m). That the pressures are absolute shows at m = 0, where the fits give
/// −0.6 kPa and not −101.
#[derive(Debug, Clone, PartialEq)]
pub struct MuscleSurfaces {
    path: PathBuf,
    loading: Branch,
    unloading: Branch,
}

impl MuscleSurfaces {
    /// Reads the published fits.
    ///
    /// # Errors
    /// [`DataError::File`] if an array is missing or of the wrong length.
    pub fn read(path: impl AsRef<Path>) -> Result<Self, DataError> {
        Self::read_at(path.as_ref())
    }

    /// One instance, whatever the path is given as.
    fn read_at(path: &Path) -> Result<Self, DataError> {
        let arrays = mat::read(path)?;
        let purpose = "single-muscle surfaces (powers, coeffs_fF_loadingP, …)";
        let powers = mat::take(path, &arrays, "powers", purpose)?;
        let count = powers.len() / 2;
        let surface = |name: &str| {
            let coefficients = mat::take(path, &arrays, name, purpose)?;
            if coefficients.len() != count || powers.len() != 2 * count {
                return Err(DataError::file(
                    path,
                    format!("`{name}` has {} coefficients for {count} powers", coefficients.len()),
                ));
            }
            let terms = (0..count)
                .map(|k| (coefficients[k], powers[k] as i32, powers[count + k] as i32))
                .collect();
            Ok(Surface { terms })
        };
        Ok(Self {
            path: path.to_owned(),
            loading: Branch {
                pressure: surface("coeffs_fP_loadingP")?,
                force: surface("coeffs_fF_loadingP")?,
            },
            unloading: Branch {
                pressure: surface("coeffs_fP_unloadingP")?,
                force: surface("coeffs_fF_unloadingP")?,
            },
        })
    }

    /// Pressure (kPa absolute) and force (N) of a muscle with air mass `mass_g` at `stretch_mm`,
    /// on the loading or the unloading branch.
    #[must_use]
    pub fn pressure_and_force(&self, loading: bool, mass_g: f64, stretch_mm: f64) -> (f64, f64) {
        let branch = if loading { &self.loading } else { &self.unloading };
        let s = stretch_mm * 1e-3;
        (branch.pressure.value(mass_g, s), branch.force.value(mass_g, s))
    }

    /// Sealed masses of a recording: `P(m_f, −x) = P_f` and `P(m_e, +x) = P_e` in the least-squares
    /// sense with equal forces, once with the flexor loading and the extensor unloading at the mean
    /// x of |F_e| ≤ 1 N with falling force, once with the branches swapped at the mean x with rising
    /// force; the two are averaged.
    ///
    /// # Errors
    /// [`DataError::File`] if there is no equilibrium within the masses the surfaces were measured
    /// for.
    pub fn masses(&self, recording: &Recording) -> Result<SealedMasses, DataError> {
        let rest = recording.reading_at_rest();
        let pressures = [rest.pressure_flexor_kpa, rest.pressure_extensor_kpa];
        let slopes = gradient(&recording.force_mn, 1.0);
        let mean_x_mm = |sign: f64| {
            let (sum, count) = recording
                .force_mn
                .iter()
                .zip(&slopes)
                .zip(&recording.displacement_mm)
                .filter(|((f, df), _)| f.abs() <= EQUILIBRIUM_FORCE_MN && sign * **df > 0.0)
                .fold((0.0, 0_usize), |(s, n), (_, x)| (s + x, n + 1));
            if count == 0 { 0.0 } else { sum / count as f64 }
        };
        let falling =
            equilibrium([&self.loading, &self.unloading], pressures, mean_x_mm(-1.0) * 1e-3);
        let rising =
            equilibrium([&self.unloading, &self.loading], pressures, mean_x_mm(1.0) * 1e-3);
        match (falling, rising) {
            (Some(a), Some(b)) => {
                Ok(SealedMasses { flexor_g: 0.5 * (a[0] + b[0]), extensor_g: 0.5 * (a[1] + b[1]) })
            }
            _ => Err(DataError::file(
                &recording.source,
                format!(
                    "the surfaces of {} have no equilibrium at {:.1} and {:.1} kPa between 0 and \
                     {MASS_LIMIT_G} g; use the gas law",
                    self.path.display(),
                    pressures[0],
                    pressures[1]
                ),
            )),
        }
    }
}

/// Masses of flexor and extensor that minimise `|P(m) − pressures|` under equal forces, at
/// displacement `x` (m): Gauss–Newton steps on the equality-constrained least squares, started from
/// the masses that meet each pressure alone.
fn equilibrium(branches: [&Branch; 2], pressures: [f64; 2], x: f64) -> Option<[f64; 2]> {
    let stretch = [-x, x];
    let mut m = [0.0; 2];
    for i in 0..2 {
        m[i] = mass_at_pressure(&branches[i].pressure, pressures[i], stretch[i])?;
    }
    for _ in 0..200 {
        let (mut slope, mut wanted, mut pull) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        let mut imbalance = 0.0;
        for i in 0..2 {
            let (p, dp) = branches[i].pressure.value_and_slope(m[i], stretch[i]);
            let (f, df) = branches[i].force.value_and_slope(m[i], stretch[i]);
            let sign = if i == 0 { 1.0 } else { -1.0 };
            imbalance += sign * f;
            pull[i] = sign * df;
            slope[i] = dp;
            wanted[i] = (pressures[i] - p) / dp;
        }
        let weight = |i: usize| pull[i] / (slope[i] * slope[i]);
        let reach = pull[0] * weight(0) + pull[1] * weight(1);
        let multiplier = (imbalance + pull[0] * wanted[0] + pull[1] * wanted[1]) / reach;
        let step = [wanted[0] - multiplier * weight(0), wanted[1] - multiplier * weight(1)];
        let size = step[0].abs().max(step[1].abs());
        if !size.is_finite() {
            return None;
        }
        // Far steps leave the range in which the polynomials mean something.
        let damp = (0.02 / size).min(1.0);
        for i in 0..2 {
            m[i] = (m[i] + damp * step[i]).clamp(0.0, MASS_LIMIT_G);
        }
        if size < 1e-13 {
            let inside = m.iter().all(|&v| v > 0.0 && v < MASS_LIMIT_G);
            return inside.then_some(m);
        }
    }
    None
}

/// The smallest mass at which the pressure surface reaches `pressure`, by scan and bisection.
fn mass_at_pressure(surface: &Surface, pressure: f64, stretch: f64) -> Option<f64> {
    let miss = |m: f64| surface.value(m, stretch) - pressure;
    let steps = 200;
    let at = |k: usize| MASS_LIMIT_G * k as f64 / steps as f64;
    let k = (0..steps).find(|&k| miss(at(k)) <= 0.0 && miss(at(k + 1)) > 0.0)?;
    let (mut low, mut high) = (at(k), at(k + 1));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if miss(middle) <= 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}
