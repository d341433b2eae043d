//! The power spectrum of a measured motion.

use pam_numerics::fourier::power_of_pieces;
use std::f64::consts::TAU;

/// Highest frequency that is resolved, Hz: the published loader reaches 8 Hz. Power above it is counted at this frequency.
const HIGHEST_HZ: f64 = 10.0;
/// Width of a band of frequencies, Hz.
const BAND_HZ: f64 = 0.25;
/// Points of the pieces whose powers are averaged: 16 s of points of 4 ms.
const PIECE: usize = 4096;
/// Share of the power below which a band is empty: even errors as large as the motion in it would be 10⁻⁵ of the whole motion.
const EMPTY: f64 = 1e-10;

/// The power of the measured displacement about its mean, by bands of frequency.
#[derive(Debug, Clone)]
pub(crate) struct MotionSpectrum {
    bands: Vec<Band>,
}

/// A band of frequencies.
#[derive(Debug, Clone, Copy)]
pub(super) struct Band {
    /// Its upper end, rad/s.
    pub(super) rate: f64,
    /// Its share of the power.
    pub(super) share: f64,
}

impl MotionSpectrum {
    /// The spectrum of displacements at points `step_s` apart, from samples `sample_s` apart. All of the power is at the highest frequency
    /// if the joint does not move in them: nothing is known of the motion then.
    pub(super) fn new(displacement_mm: &[f64], step_s: f64, sample_s: f64) -> Self {
        let highest_hz = HIGHEST_HZ.min(0.5 / sample_s);
        let count = (highest_hz / BAND_HZ).ceil().max(1.0) as usize;
        let mut powers = vec![0.0; count];
        for spectrum in power_of_pieces(displacement_mm, PIECE.min(displacement_mm.len())) {
            let hz_of = |j: usize| 0.5 * j as f64 / (spectrum.len() - 1).max(1) as f64 / step_s;
            for (j, power) in spectrum.iter().enumerate() {
                powers[((hz_of(j) / BAND_HZ) as usize).min(count - 1)] += power;
            }
        }
        let total: f64 = powers.iter().sum();
        let rate = |k: usize| TAU * (BAND_HZ * (k + 1) as f64).min(highest_hz);
        let bands = powers
            .iter()
            .enumerate()
            .map(|(k, power)| Band { rate: rate(k), share: power / total });
        let bands: Vec<Band> = bands.filter(|band| band.share > EMPTY).collect();
        if bands.is_empty() {
            return Self { bands: vec![Band { rate: rate(count - 1), share: 1.0 }] };
        }
        Self { bands }
    }

    pub(super) fn bands(&self) -> &[Band] {
        &self.bands
    }

    /// The mean frequency by power, Hz.
    pub(super) fn mean_hz(&self) -> f64 {
        self.bands.iter().map(|band| band.share * band.rate / TAU).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shares(x: &[f64], step_s: f64) -> Vec<(f64, f64)> {
        let spectrum = MotionSpectrum::new(x, step_s, step_s);
        spectrum.bands().iter().map(|b| (b.rate / TAU, b.share)).collect()
    }

    /// Two sines have their powers in the bands that hold their frequencies.
    #[test]
    fn the_power_of_two_sines_is_in_two_bands() {
        let at = |k: usize| 4e-3 * k as f64;
        let x: Vec<f64> = (0..5000)
            .map(|k| 5.0 + (TAU * 1.5 * at(k)).sin() + 0.1 * (TAU * 6.5 * at(k)).sin())
            .collect();
        let shares = shares(&x, 4e-3);
        let of = |hz: f64| shares.iter().find(|s| (s.0 - hz).abs() < 1e-9).map_or(0.0, |s| s.1);
        assert!((of(1.5) + of(1.75) - 1.0 / 1.01).abs() < 1e-4, "{shares:?}");
        assert!((of(6.5) + of(6.75) - 0.01 / 1.01).abs() < 1e-4, "{shares:?}");
        let mean_hz = MotionSpectrum::new(&x, 4e-3, 4e-3).mean_hz();
        assert!((mean_hz - (1.5 + 0.01 * 6.5) / 1.01).abs() < BAND_HZ, "{mean_hz}");
    }

    /// Of a joint that rests, or of too few points, nothing is known.
    #[test]
    fn motion_that_is_unknown_is_fast() {
        for x in [vec![3.0; 1000], vec![0.0; 2], vec![f64::NAN; 100]] {
            assert_eq!(shares(&x, 4e-3), [(10.0, 1.0)]);
        }
        assert_eq!(shares(&vec![0.0; 100], 0.1), [(5.0, 1.0)]);
    }
}
