//! Magnitudes of the recordings, from which fits start.

use std::f64::consts::TAU;

/// The joint at one sample, with the force that the base model lacks there.
#[derive(Debug, Clone, Copy)]
pub struct ScaleSample {
    /// Measured displacement, mm.
    pub displacement_mm: f64,
    /// Force missing from the base model's balance on the measured motion, N; positive towards +x.
    pub missing_n: f64,
}

/// Magnitudes of the recordings.
#[derive(Debug, Clone)]
pub struct DataScales {
    /// Typical amplitude of the commanded force (95th percentile of its size), N.
    pub force_n: f64,
    /// Largest commanded force without what may be noise of its sensor, N.
    pub peak_force_n: f64,
    /// Quantiles of the size of this force, evenly spaced from the smallest to the largest one, N.
    pub force_quantiles_n: Vec<f64>,
    /// Typical amplitude of the motion (95th percentile of the distance from its middle), mm.
    pub travel_mm: f64,
    /// Typical largest displacement to either side (95th percentile of its size), mm: more than the travel where the motion is
    /// about another middle than zero.
    pub reach_mm: f64,
    /// Typical speed (95th percentile), mm/s.
    pub speed_mm_s: f64,
    /// Slope of force over displacement, N/mm.
    pub stiffness_n_mm: f64,
    /// Mean gauge pressure of both chambers when they were sealed, kPa.
    pub gauge_kpa: f64,
    /// Duration of the longest recording, s.
    pub duration_s: f64,
    /// Samples spread over all recordings.
    pub samples: Vec<ScaleSample>,
}

impl DataScales {
    /// The `count` pitches (mm) at which a force periodic in position fits the missing force best, with the
    /// amplitude of `sin(2π x/pitch)` (N), best first. Pitches between 2 % and the whole of the travel are
    /// searched on a grid that is even in 1/pitch and fine enough for the whole range of motion.
    #[must_use]
    pub fn periodic_pitches_mm(&self, count: usize) -> Vec<(f64, f64)> {
        let range = 2.0 * self.travel_mm;
        if range <= 0.0 || self.samples.len() < 8 {
            return Vec::new();
        }
        let (lowest, highest, spacing) = (0.7 / range, 25.0 / range, 0.15 / range);
        let steps = ((highest - lowest) / spacing) as usize;
        let fits: Vec<(f64, f64, f64)> = (0..=steps)
            .map(|k| {
                let per_mm = lowest + spacing * k as f64;
                let (amplitude, gain) = self.sine_fit(per_mm);
                (1.0 / per_mm, amplitude, gain)
            })
            .collect();
        let mut peaks: Vec<(f64, f64, f64)> = (0..fits.len())
            .filter(|&k| {
                let near = &fits[k.saturating_sub(1)..(k + 2).min(fits.len())];
                near.iter().all(|f| f.2 <= fits[k].2)
            })
            .map(|k| fits[k])
            .collect();
        peaks.sort_by(|a, b| b.2.total_cmp(&a.2));
        peaks.truncate(count);
        peaks.into_iter().map(|(pitch, amplitude, _)| (pitch, amplitude)).collect()
    }

    /// Amplitude (N) and explained sum of squares of `sin(2π x · per_mm)`, together with a constant, a
    /// straight line and a cube in x for the smooth part.
    fn sine_fit(&self, per_mm: f64) -> (f64, f64) {
        let columns = |x: f64| {
            let u = x / self.travel_mm;
            [1.0, u, u * u * u, (TAU * x * per_mm).sin()]
        };
        let mut normal = [[0.0; 4]; 4];
        let mut right = [0.0; 4];
        for s in &self.samples {
            let c = columns(s.displacement_mm);
            for i in 0..4 {
                right[i] += c[i] * s.missing_n;
                for j in 0..4 {
                    normal[i][j] += c[i] * c[j];
                }
            }
        }
        // Elimination down to the last unknown leaves its amplitude and what it explains.
        for i in 0..3 {
            let pivot = normal[i][i];
            if pivot <= 0.0 {
                return (0.0, 0.0);
            }
            for j in i + 1..4 {
                let factor = normal[j][i] / pivot;
                let pivot_row = normal[i];
                normal[j].iter_mut().zip(pivot_row).for_each(|(n, p)| *n -= factor * p);
                right[j] -= factor * right[i];
            }
        }
        if normal[3][3] <= 1e-9 * self.samples.len() as f64 {
            return (0.0, 0.0);
        }
        (right[3] / normal[3][3], right[3] * right[3] / normal[3][3])
    }
}
