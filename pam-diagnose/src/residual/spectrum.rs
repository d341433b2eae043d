//! Power spectra of a residual and of the excitation.

use crate::settings::ResidualSettings;
use serde::Serialize;
use std::f64::consts::TAU;

/// A spectral line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Line {
    /// Frequency of the nearest bin, Hz: bins are one over the length of a piece apart.
    pub frequency_hz: f64,
    /// Share of the residual's power up to the highest frequency of the spectrum in it, 0 to 1.
    pub share: f64,
    /// Share of the excitation's power at the same frequency.
    pub share_of_force: f64,
}

/// Mean spectra of a residual and of the excitation over all recordings.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Spectrum {
    /// Frequencies, Hz.
    pub frequency_hz: Vec<f64>,
    /// Power of the residual, normalised to a sum of one.
    pub residual: Vec<f64>,
    /// Power of the excitation, normalised to a sum of one.
    pub excitation: Vec<f64>,
}

impl Spectrum {
    /// Spectra of rows that are `row_s` apart, by averaged periodograms of overlapping pieces with Hann's window
    /// (Welch 1967). Series shorter than a piece have no spectrum.
    pub(crate) fn new(
        row_s: f64,
        residuals: &[&[f64]],
        excitations: &[Vec<f64>],
        settings: &ResidualSettings,
    ) -> Self {
        let piece_s = settings.spectrum_piece_s;
        let piece = ((piece_s / row_s).round() as usize).max(2);
        // Not beyond the Nyquist frequency.
        let lines =
            ((settings.spectrum_highest_hz * piece_s * (1.0 + 1e-12)) as usize).min(piece / 2);
        let table: Vec<(f64, f64)> = (0..piece)
            .map(|k| {
                let angle = TAU * k as f64 / piece as f64;
                (angle.cos(), angle.sin())
            })
            .collect();
        let power = |series: &[&[f64]]| -> Vec<f64> {
            let mut sum = vec![0.0; lines];
            for s in series {
                for part in s.windows(piece).step_by((piece / 2).max(1)) {
                    let mean = part.iter().sum::<f64>() / piece as f64;
                    let windowed: Vec<f64> = part
                        .iter()
                        .zip(&table)
                        .map(|(v, (c, _))| (v - mean) * 0.5 * (1.0 - c))
                        .collect();
                    for (j, out) in sum.iter_mut().enumerate() {
                        let (mut re, mut im) = (0.0, 0.0);
                        let mut at = 0;
                        for v in &windowed {
                            re += v * table[at].0;
                            im -= v * table[at].1;
                            at = (at + j + 1) % piece;
                        }
                        *out += re * re + im * im;
                    }
                }
            }
            let total: f64 = sum.iter().sum();
            sum.iter().map(|v| if total > 0.0 { v / total } else { 0.0 }).collect()
        };
        let excitations: Vec<&[f64]> = excitations.iter().map(Vec::as_slice).collect();
        Self {
            frequency_hz: (1..=lines).map(|j| j as f64 / piece_s).collect(),
            residual: power(residuals),
            excitation: power(&excitations),
        }
    }

    /// The share of the residual's power in the bin of a frequency and its neighbours.
    #[must_use]
    pub fn lobe(&self, frequency_hz: f64) -> f64 {
        let bin_hz = self.frequency_hz.first().copied().unwrap_or(f64::INFINITY);
        let at = (frequency_hz / bin_hz).round() as usize;
        let from = at.saturating_sub(2).min(self.residual.len());
        self.residual[from..(at + 1).min(self.residual.len())].iter().sum()
    }

    /// The strongest lines of the residual, each with its neighbours (a window's main lobe).
    #[must_use]
    pub fn lines(&self, count: usize) -> Vec<Line> {
        let n = self.residual.len();
        let lobe = |p: &[f64], j: usize| p[j.saturating_sub(1)..(j + 2).min(n)].iter().sum::<f64>();
        let mut peaks: Vec<Line> = (0..n)
            .filter(|&j| {
                let near = &self.residual[j.saturating_sub(1)..(j + 2).min(n)];
                self.residual[j] > 0.0 && near.iter().all(|v| *v <= self.residual[j])
            })
            .map(|j| Line {
                frequency_hz: self.frequency_hz[j],
                share: lobe(&self.residual, j),
                share_of_force: lobe(&self.excitation, j),
            })
            .collect();
        peaks.sort_by(|a, b| b.share.total_cmp(&a.share));
        peaks.truncate(count);
        peaks
    }

    /// The strongest line at a frequency that the excitation hardly has, and that is no multiple of one that it has much
    /// of: a joint that is not linear answers at those as well.
    #[must_use]
    pub fn foreign_line(&self, settings: &ResidualSettings) -> Option<Line> {
        let bin_hz = self.frequency_hz.first().copied().unwrap_or(0.0);
        self.lines(settings.foreign_lines).into_iter().find(|l| {
            // Slower ones cannot be told from a drift, nor from slow noise of the force.
            l.frequency_hz > SLOWEST_LINE_BINS * bin_hz
                && l.share > settings.foreign_line_share
                && l.share_of_force < settings.foreign_line_excitation * l.share
                && !self.is_harmonic(l.frequency_hz, settings)
        })
    }

    fn is_harmonic(&self, frequency_hz: f64, settings: &ResidualSettings) -> bool {
        let bin_hz = self.frequency_hz.first().copied().unwrap_or(0.0);
        let mut excited = (0..self.excitation.len())
            .filter(|&j| self.excitation[j] > settings.foreign_line_share);
        excited.any(|j| {
            let excited_hz = self.centre_hz(j);
            let multiple = (frequency_hz / excited_hz).round();
            let off_hz = (frequency_hz - multiple * excited_hz).abs();
            // Half a bin of the line, and what the excitation's centre is uncertain by.
            multiple >= 2.0 && off_hz < (0.5 + CENTRE_BINS * multiple) * bin_hz
        })
    }

    /// The centre of the excitation's power around a bin: its line is between bins, and a multiple of it is further from one.
    fn centre_hz(&self, bin: usize) -> f64 {
        let near = bin.saturating_sub(2)..(bin + 3).min(self.excitation.len());
        let power: f64 = self.excitation[near.clone()].iter().sum();
        near.map(|j| self.excitation[j] * self.frequency_hz[j]).sum::<f64>() / power
    }
}

/// Half the width of a line under Hann's window, in bins: a slower one reaches to zero.
const SLOWEST_LINE_BINS: f64 = 2.0 + 1e-9;
/// Bins by which the centre of the power of one line under Hann's window may be off.
const CENTRE_BINS: f64 = 0.1;
