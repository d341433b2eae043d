//! Lines in the spectrum of a residual: frequency and power of a known sine, and none in noise.

use crate::linear::{Experiment, Linear, coloured, white};
use pam_diagnose::DiagnosisSettings;
use pam_diagnose::data::TestSource;
use pam_diagnose::residual::{ChannelResidual, ResidualSummary};
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use std::f64::consts::TAU;

const ROW_S: f64 = 0.02;
/// Frequencies of the spectrum are one over the length of a piece (8 s) apart, up to 8 Hz.
const BIN_HZ: f64 = 0.125;

/// The residual of one run of 60 s under a sine of 1 Hz.
fn summary(residual: Vec<f64>) -> ChannelResidual {
    let excitation = (0..residual.len()).map(|k| (TAU * ROW_S * k as f64).sin()).collect();
    let one = Experiment { measured: residual, excitation, ..Experiment::default() };
    let system = Linear::new(vec![one]);
    let settings = DiagnosisSettings::default();
    let problem = system.problem(0.01, &settings);
    let base = problem.base();
    ResidualSummary::of(&problem, &base, &base, &[0.01]).channels.remove(0)
}

fn sine(amplitude: f64, hz: f64) -> Vec<f64> {
    (0..3000).map(|k| amplitude * (TAU * hz * ROW_S * k as f64 + 0.7).sin()).collect()
}

fn plus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

/// A sine of amplitude a in white noise of variance σ²: its frequency is found to half a bin wherever it lies between the
/// bins, and its share of the power below 8 Hz is a²/2 over a²/2 + σ²·8/25 (the Nyquist frequency is 25 Hz), of which a
/// main lobe of three bins shows all on a bin and 98 % between two (Hann's window: (2·0.7205 + 0.0288)/1.5).
#[test]
fn a_line_is_found_with_its_frequency_and_power() {
    let mut random = ChaCha8Rng::seed_from_u64(1);
    for offset in [0.0, 0.2, 0.5, 0.8] {
        for (amplitude, sigma) in [(1.0, 0.3), (1.0, 1.0), (0.5, 1.0)] {
            // Not at a multiple of the excitation's 1 Hz.
            let hz = (26.0 + offset) * BIN_HZ;
            let noise: Vec<f64> = white(&mut random, 3000).iter().map(|e| sigma * e).collect();
            let found = summary(plus(&sine(amplitude, hz), &noise));
            let line = found.lines[0];
            let power = 0.5 * amplitude * amplitude;
            let below = sigma * sigma * 8.0 / 25.0;
            let share = (power + below * 3.0 / 64.0) / (power + below);
            let what = format!("{hz} Hz, amplitude {amplitude}, noise {sigma}: {line:?}, {share}");
            assert!((line.frequency_hz - hz).abs() <= 0.5 * BIN_HZ + 1e-9, "{what}");
            // The line and the noise in its lobe interfere: their cross term over seven independent pieces.
            let cross = (2.0 * power * below * 3.0 / 64.0 / 7.0).sqrt() / (power + below);
            assert!((line.share - share).abs() < 3.0 * cross + 0.02, "{what}");
            assert!(line.share_of_force < 1e-3, "{what}");
            assert!(found.description.contains("something else drives it"), "{what}");
        }
    }
}

/// An error in the initial state makes a lightly damped system ring at its natural frequency, which is no foreign line; without such a
/// nuisance the same line is reported.
#[test]
fn a_ring_is_no_foreign_line() {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut experiment = || {
        let measured = plus(&sine(1.0, 3.3), &white(&mut random, 3000));
        let excitation = (0..3000).map(|k| (TAU * ROW_S * f64::from(k)).sin()).collect();
        Experiment { measured, excitation, ..Experiment::default() }
    };
    let driven = Linear::new(vec![experiment(), experiment(), experiment()]);
    // The prior does not let it take the line away.
    let ringing = driven.clone().with_local(sine(1.0, 3.3), 1e-3);
    // White, so that the noise does not take the line for its colour.
    let mut settings = DiagnosisSettings::default();
    settings.noise.order = 0;
    let lines = |system: &Linear| {
        let found = system.diagnosed(TestSource::Kept, 1.0, None, &settings, 1);
        found.anomalies.iter().filter(|a| a.kind == "line").count()
    };
    // In the data and in the test set.
    assert_eq!((lines(&driven), lines(&ringing)), (2, 0));
}

/// Two lines are distinguished in order of their power; one at the frequency of the excitation is not foreign.
#[test]
fn lines_are_ordered_and_those_of_the_excitation_are_known() {
    let settings = DiagnosisSettings::default().residual;
    let two = summary(plus(&sine(1.0, 2.5), &sine(0.5, 5.0)));
    let at: Vec<f64> = two.lines.iter().take(2).map(|l| l.frequency_hz).collect();
    assert_eq!(at, [2.5, 5.0]);
    // Powers of 4 to 1.
    assert!((two.lines[0].share - 0.8).abs() < 1e-3 && (two.lines[1].share - 0.2).abs() < 1e-3);
    let own = summary(sine(1.0, 1.0));
    assert_eq!(own.lines[0].frequency_hz, 1.0);
    assert!(own.lines[0].share_of_force > 0.99 && own.spectrum.foreign_line(&settings).is_none());
    // A joint that is not linear answers at multiples of the excitation's frequency.
    assert!(summary(sine(1.0, 3.0)).spectrum.foreign_line(&settings).is_none());
    let foreign = two.spectrum.foreign_line(&settings).expect("the excitation has 1 Hz only");
    assert_eq!(foreign.frequency_hz, 2.5);
}

/// The power is that of the series: the spectrum of white noise is flat, each of 64 bins with 1/64 of it, within what 14
/// half-overlapping pieces average (a relative standard deviation of about 1/√(0.5·14), Welch 1967).
#[test]
fn white_noise_is_flat() {
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let mut sums = [0.0; 64];
    for _ in 0..50 {
        let found = summary(white(&mut random, 3000));
        assert_eq!(found.spectrum.residual.len(), 64);
        assert_eq!(found.spectrum.frequency_hz[63], 8.0);
        sums.iter_mut().zip(&found.spectrum.residual).for_each(|(s, p)| *s += p / 50.0);
    }
    // 50 runs: 1/√(50·7) = 5 %; five times that.
    for (j, s) in sums.iter().enumerate() {
        assert!((s * 64.0 - 1.0).abs() < 0.25, "bin {j}: {s}");
    }
}

/// In white noise no line is reported as driven by something else: none in 400 runs of a minute, so at most 1 in 100 at
/// a confidence of 98 % (0.99⁴⁰⁰ < 0.02). Noise that is correlated has its power near zero, as it should.
#[test]
fn noise_has_no_line() {
    let settings = DiagnosisSettings::default().residual;
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut largest = 0.0_f64;
    for _ in 0..400 {
        let found = summary(white(&mut random, 3000));
        largest = largest.max(found.lines[0].share);
        assert!(found.spectrum.foreign_line(&settings).is_none(), "{:?}", found.lines[0]);
        assert!(!found.description.contains("something else"), "{}", found.description);
    }
    println!("largest share of a line in noise {largest}");
    let red = summary(coloured(&mut random, 3000, 0.9));
    let low: f64 = red.spectrum.residual[..16].iter().sum();
    // An autoregression of 0.9 at 50 Hz has its corner at 0.84 Hz: (2/π) atan(2/0.84) of it below 2 Hz, of that below 8 Hz.
    assert!((low - (2.0_f64 / 0.84).atan() / (8.0_f64 / 0.84).atan()).abs() < 0.15, "{low}");
}
