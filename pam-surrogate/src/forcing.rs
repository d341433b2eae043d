//! The measured force as straight lines, and its integrals over a step.
//!
//! The force acts on the velocity through its integral, known in closed form, so that steps may span many samples: what is
//! integrated by Runge–Kutta steps is the motion without the impulse, which is smoother by two derivatives.

use pam_solvers::{ForceSignal, Interpolation};

/// A straight line of the force from a time on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Line {
    start_s: f64,
    force_mn: f64,
    rate_mn_s: f64,
}

impl Line {
    pub(crate) fn start_s(&self) -> f64 {
        self.start_s
    }

    /// `[∫ F dt, ∫∫ F dt²]` (mN s, mN s²) from the start to `s` after it.
    #[inline(always)]
    pub(crate) fn integrals(&self, s: f64) -> [f64; 2] {
        let (f, r) = (self.force_mn, self.rate_mn_s);
        [s * (f + s * r * 0.5), s * s * (f * 0.5 + s * r / 6.0)]
    }
}

/// The straight lines of a signal, in order; the first one also holds before its start.
pub(crate) fn lines_into(signal: &ForceSignal<'_>, lines: &mut Vec<Line>) {
    lines.clear();
    let f = signal.force_mn;
    let last = f.len() - 1;
    if signal.interpolation == Interpolation::Ramp && last > 0 {
        lines.push(Line { start_s: f64::NEG_INFINITY, force_mn: f[0], rate_mn_s: 0.0 });
    }
    for k in 0..=last {
        let held = signal.interpolation == Interpolation::Hold || k == last;
        let start_s = signal.knot(k);
        let rate_mn_s = if held { 0.0 } else { (f[k + 1] - f[k]) / (signal.knot(k + 1) - start_s) };
        lines.push(Line { start_s, force_mn: f[k], rate_mn_s });
    }
}

/// A line within a step.
#[derive(Debug, Clone, Copy)]
struct Piece {
    /// Start, s from the start of the step.
    from_s: f64,
    force_mn: f64,
    rate_mn_s: f64,
    /// `∫ F dt` (mN s) and `∫∫ F dt²` (mN s²) from the start of the step.
    impulse: f64,
    double: f64,
}

/// The force over one step.
#[derive(Debug, Default)]
pub(crate) struct StepForcing {
    pieces: Vec<Piece>,
}

impl StepForcing {
    /// Takes the lines between `start_s` and `end_s`. `line` is the last one that begins at or before `start_s`, or the
    /// first.
    #[inline]
    pub(crate) fn take(&mut self, lines: &[Line], line: usize, start_s: f64, end_s: f64) {
        self.pieces.clear();
        let first = lines[line];
        let since = start_s - first.start_s;
        let force_mn = if first.rate_mn_s == 0.0 || since < 0.0 {
            first.force_mn
        } else {
            first.force_mn + first.rate_mn_s * since
        };
        let rate_mn_s = if since < 0.0 { 0.0 } else { first.rate_mn_s };
        let mut piece = Piece { from_s: 0.0, force_mn, rate_mn_s, impulse: 0.0, double: 0.0 };
        let later = if since < 0.0 { line } else { line + 1 };
        for next in lines[later..].iter().take_while(|l| l.start_s < end_s) {
            self.pieces.push(piece);
            let from_s = next.start_s - start_s;
            let [impulse, double] = piece.integrals(from_s);
            piece = Piece {
                from_s,
                force_mn: next.force_mn,
                rate_mn_s: next.rate_mn_s,
                impulse,
                double,
            };
        }
        self.pieces.push(piece);
    }

    /// `[∫ F dt, ∫∫ F dt²]` (mN s, mN s²) from the start of the step to `at_s` after it.
    #[inline]
    pub(crate) fn integrals(&self, at_s: f64) -> [f64; 2] {
        let mut index = 0;
        while index + 1 < self.pieces.len() && self.pieces[index + 1].from_s <= at_s {
            index += 1;
        }
        self.pieces[index].integrals(at_s)
    }
}

impl Piece {
    #[inline]
    fn integrals(&self, at_s: f64) -> [f64; 2] {
        let s = at_s - self.from_s;
        let (f, r) = (self.force_mn, self.rate_mn_s);
        [
            self.impulse + s * (f + s * r * 0.5),
            self.double + s * (self.impulse + s * (f * 0.5 + s * r / 6.0)),
        ]
    }
}
