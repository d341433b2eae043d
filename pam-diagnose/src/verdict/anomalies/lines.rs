//! Lines of the spectrum that the excitation does not have.

use super::{Anomaly, Channel};
use crate::fit::{Hypothesis, Problem};
use crate::residual::{Line, Spectrum};
use crate::search::Candidates;
use pam_core::units::significant;
use pam_numerics::statistics::{chi_square_quantile, mean, root_mean_square};

impl<C: Candidates + ?Sized> Channel<'_, C> {
    /// The strongest line of all recordings together that the excitation does not have.
    pub(super) fn line(&self) -> Option<Anomaly> {
        let problem = self.of.problem;
        let settings = problem.settings;
        let excitations = &self.of.excitations;
        if excitations.iter().all(Vec::is_empty) || problem.is_empty() {
            return None;
        }
        let all = || self.of.rows.iter().flatten();
        let white: Vec<&[f64]> = all().map(|rows| rows.white[self.index].as_slice()).collect();
        let row_s = problem.row_s(0);
        let spectrum = Spectrum::new(row_s, &white, excitations, &settings.residual);
        let piece = (settings.residual.spectrum_piece_s / row_s) as usize;
        let pieces: usize = white.iter().map(|w| 2 * w.len() / piece.max(1)).sum();
        // The power of a lobe of three lines of white noise is distributed as χ², with three degrees of freedom for each
        // independent piece (pieces overlap by half).
        let lobes = spectrum.frequency_hz.len().max(3) as f64;
        let freedom = 3.0 * (0.55 * pieces as f64).max(1.0);
        let tail = (1.0 - settings.verdict.event_probability) / lobes;
        let by_chance = 3.0 / lobes * chi_square_quantile(1.0 - tail, freedom) / freedom;
        // In units of the noise: the largest part of next to nothing is nothing.
        let squares = white.iter().flat_map(|w| w.iter()).map(|v| v * v);
        let level = squares.sum::<f64>() / self.of.count.max(1) as f64;
        let least = by_chance.max(settings.residual.foreign_line_share);
        let size = |l: &Line| {
            let plain: Vec<&[f64]> = all().map(|rows| rows.plain[self.index].as_slice()).collect();
            let lobe = Spectrum::new(row_s, &plain, &[], &settings.residual).lobe(l.frequency_hz);
            (lobe * root_mean_square(&centred(&plain)).powi(2)).sqrt()
        };
        // The error of an integration step at a kink of the force depends on the phase within the step, which beats with the
        // excitation: the simulation has lines of its own.
        let smallest = self.own.max(settings.noise.relative * problem.variation(self.place));
        let clear = |l: &Line| l.share > by_chance && l.share * level > least && size(l) > smallest;
        let line = spectrum.foreign_line(&settings.residual).filter(clear)?;
        (!rings(problem, self.of.hypothesis, self.index, line.frequency_hz)).then(|| {
            let text = format!(
                "{:.0} % of the residual power of the {} is at {} Hz, a frequency that the excitation does not contain: something \
                 else drives it",
                100.0 * line.share,
                self.output.name,
                significant(line.frequency_hz, 3)
            );
            Anomaly { frequency_hz: Some(line.frequency_hz), ..self.anomaly("line", text) }
        })
    }
}

/// The rows of several series, each less its mean.
fn centred(series: &[&[f64]]) -> Vec<f64> {
    let of = |rows: &&[f64]| {
        let centre = mean(rows);
        rows.iter().map(move |r| r - centre).collect::<Vec<_>>()
    };
    series.iter().flat_map(of).collect()
}

/// Whether an error in a nuisance of an experiment, such as the initial state, produces a line at this frequency in a channel: a lightly
/// damped system rings at its natural frequency.
fn rings<C: Candidates + ?Sized>(
    problem: &Problem<'_, C>,
    hypothesis: &Hypothesis,
    channel: usize,
    frequency_hz: f64,
) -> bool {
    let settings = &problem.settings.residual;
    (0..problem.len()).any(|i| {
        let Ok(s) = problem.whitened_sensitivities(hypothesis, i) else { return false };
        let first = s.columns.len().saturating_sub(hypothesis.locals[i].len());
        s.columns[first..].iter().any(|column| {
            let rows = column.get(channel).map_or(&[][..], Vec::as_slice);
            let spectrum = Spectrum::new(problem.row_s(i), &[rows], &[], settings);
            spectrum.lobe(frequency_hz) > settings.foreign_line_share
        })
    })
}
