//! Pieces of long recordings that cover the motion.

use crate::data::OpenPart;
use crate::settings::RemainderSettings;
use pam_effects::simulation::Trial;
use std::ops::Range;

/// A piece of a recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Piece {
    /// Index of the recording.
    pub(super) recording: usize,
    /// Its grid points.
    pub(super) points: Range<usize>,
}

/// Cells of the displacement, and of the velocity, in which the motion is counted.
const CELLS: usize = 8;
/// Starts of pieces that are compared, per length of a piece.
const STARTS: usize = 4;

/// Substeps of a step of the grid at which the lengths of the settings hold.
const SUBSTEPS: f64 = 2.0;

/// Pieces of the open parts of recordings that have [`RemainderSettings::most_s`] together, and
/// [`RemainderSettings::most_of_one_s`] of each recording, both shorter in proportion where there are more than two `substeps`; `None`
/// if the parts are no longer.
/// Each recording, whose pressures no other one has, keeps its share of the time. Its pieces are chosen one after the other:
/// the next is the one that adds most to the sum of `ln(1 + n)` over cells of displacement and velocity in which the motion has
/// `n` points.
pub(super) fn pieces(
    trials: &[&Trial],
    open: &[OpenPart],
    settings: &RemainderSettings,
    substeps: usize,
) -> Option<Vec<Piece>> {
    let shorter = (SUBSTEPS / substeps as f64).min(1.0);
    let divided = |s: f64| (s * shorter).max(settings.piece_s.min(s));
    let [most_s, most_of_one_s] = [settings.most_s, settings.most_of_one_s].map(divided);
    let in_part = |part: &OpenPart| trials[part.experiment].record.points_within(part.end_s);
    let points: Vec<usize> = open.iter().map(in_part).collect();
    let length_s = |part: &OpenPart| open_s(trials, part);
    let whole_s: f64 = open.iter().map(length_s).sum();
    let longest_s = open.iter().map(length_s).fold(0.0, f64::max);
    if whole_s <= most_s && longest_s <= most_of_one_s {
        return None;
    }
    let share = (most_s / whole_s).min(1.0);
    let mut all = Vec::new();
    for (part, &points) in open.iter().zip(&points) {
        let record = &trials[part.experiment].record;
        let most = most_of_one_s / record.step_s;
        let kept = (share * points as f64).min(most) as usize;
        let count = ((kept as f64 * record.step_s / settings.piece_s) as usize).max(1);
        let length = (kept / count).max(2).min(points);
        let own = covering(&record.measured[..2], points, length, count);
        let piece = |from: usize| Piece { recording: part.experiment, points: from..from + length };
        all.extend(own.into_iter().map(piece));
    }
    Some(all)
}

/// Time of the open parts of recordings, s, longer in proportion where there are more than two `substeps`.
pub(super) fn integrated_s(trials: &[&Trial], open: &[OpenPart], substeps: usize) -> f64 {
    let longer = (substeps as f64 / SUBSTEPS).max(1.0);
    open.iter().map(|part| open_s(trials, part)).sum::<f64>() * longer
}

/// Length of an open part, s.
fn open_s(trials: &[&Trial], part: &OpenPart) -> f64 {
    let record = &trials[part.experiment].record;
    record.step_s * record.points_within(part.end_s).saturating_sub(1) as f64
}

/// The first points of pieces of a length that cover displacement and velocity, in ascending order.
fn covering(motion: &[Vec<f64>], points: usize, length: usize, count: usize) -> Vec<usize> {
    let cell = |series: &[f64]| -> Vec<usize> {
        let low = series.iter().copied().fold(f64::INFINITY, f64::min);
        let high = series.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let per = CELLS as f64 / (high - low).max(f64::MIN_POSITIVE);
        series.iter().map(|u| (((u - low) * per) as usize).min(CELLS - 1)).collect()
    };
    let (x, v) = (cell(&motion[0][..points]), cell(&motion[1][..points]));
    let cells: Vec<usize> = x.iter().zip(&v).map(|(x, v)| CELLS * x + v).collect();
    let mut counts = vec![0.0_f64; CELLS * CELLS];
    let mut starts: Vec<usize> = Vec::new();
    let stride = (length / STARTS).max(1);
    for _ in 0..count {
        let mut best: Option<(f64, usize)> = None;
        for from in (0..=points - length).step_by(stride) {
            if starts.iter().any(|s| from < s + length && *s < from + length) {
                continue;
            }
            let mut with = counts.clone();
            cells[from..from + length].iter().for_each(|&c| with[c] += 1.0);
            let covered: f64 = with.iter().map(|n| n.ln_1p()).sum();
            if best.is_none_or(|(most, _)| covered > most) {
                best = Some((covered, from));
            }
        }
        let Some((_, from)) = best else { break };
        cells[from..from + length].iter().for_each(|&c| counts[c] += 1.0);
        starts.push(from);
    }
    starts.sort_unstable();
    starts
}
