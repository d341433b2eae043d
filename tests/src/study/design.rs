//! The seeded design of the full study.
//!
//! Every factor is drawn in balance: within a kind each of its levels occurs equally often, in an order of its own (a
//! Latin hypercube of categorical factors, McKay, Beckman and Conover 1979). The design depends on nothing but its
//! seed and the vocabulary.

use super::case::{Case, Factors, Fault, Kind, ModelError, Shape, Source, Strength};
use crate::magnitudes;
use crate::plant::{Colour, Hidden, Noise};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// Seed of the design whose results are checked in.
pub const SEED: u64 = 20_260;

/// Added to the seeds of the data for each design after that, so that no noise, model or condition repeats.
const DESIGN_STEP: u64 = 10_000_000;

/// Number of cases of each kind that has no natural number.
const NULLS: usize = 184;
const SINGLES: usize = 160;
const PAIRS: usize = 80;
const ONSETS: usize = 30;
const UNLISTED: usize = 24;
const RIG_NULLS: usize = 16;

/// Duration of a recording of the rig, s.
const RIG_S: f64 = 21.0;

/// Every how many null sets, singles and pairs are repeated with another seed of the diagnosis.
const REPEATED: usize = 8;

/// Longest sum of the durations of a case, s: the full grid would be ten recordings of 70 s.
const LONGEST_S: f64 = 210.0;

/// Lowest rate at which the 20 Hz low-pass of the published loader is applied, Hz.
const FILTERED_FROM_HZ: f64 = 100.0;

/// Sampling rates of the design, Hz.
pub const RATES_HZ: [f64; 7] = [25.0, 50.0, 100.0, 200.0, 500.0, 1000.0, 2000.0];
const LOUDNESS: [f64; 3] = [0.3, 1.0, 3.0];
const COLOURS: [Colour; 3] = [Colour::White, Colour::LowPassed(30.0), Colour::Correlated(0.5)];
const FORCE_NOISE: [Noise; 5] = [
    Noise { deviation: 0.0, colour: Colour::White },
    Noise { deviation: 0.5, colour: Colour::White },
    Noise { deviation: 5.0, colour: Colour::White },
    Noise { deviation: 1.0, colour: Colour::LowPassed(20.0) },
    Noise { deviation: 3.0, colour: Colour::LowPassed(5.0) },
];
const ENCODER_MM: [f64; 4] = [0.010_546, 0.010_546, 0.002, 0.000_5];
const RECORDINGS: [usize; 3] = [1, 3, 10];
const DURATIONS_S: [f64; 5] = [3.0, 10.0, 20.0, 40.0, 70.0];
/// No error in half of the cases.
const MODEL_ERRORS: [ModelError; 4] =
    [ModelError::None, ModelError::None, ModelError::Force(0.01), ModelError::Force(0.03)];
/// Sines are as frequent as the four other shapes; their frequency is drawn.
const SHAPES: [Shape; 6] = [
    Shape::Sine(0.0),
    Shape::Sine(0.0),
    Shape::Published,
    Shape::Chirp,
    Shape::Steps,
    Shape::Noise,
];
const SINE_HZ: [f64; 2] = [0.5, 8.0];

/// Levels that occur equally often, in random order.
struct Balanced<'a>(&'a mut ChaCha8Rng, usize);

impl Balanced<'_> {
    fn draw<T: Clone>(&mut self, levels: &[T]) -> Vec<T> {
        let mut drawn: Vec<T> = (0..self.1).map(|k| levels[k % levels.len()].clone()).collect();
        for k in (1..drawn.len()).rev() {
            drawn.swap(k, self.0.random_range(0..=k));
        }
        drawn
    }
}

fn factors(count: usize, random: &mut ChaCha8Rng) -> Vec<Factors> {
    let mut balanced = Balanced(random, count);
    let rates = balanced.draw(&RATES_HZ);
    let loudness = balanced.draw(&LOUDNESS);
    let colours = balanced.draw(&COLOURS);
    let force_noise = balanced.draw(&FORCE_NOISE);
    let encoders = balanced.draw(&ENCODER_MM);
    let smooth = balanced.draw(&[false, true]);
    let filtered = balanced.draw(&[true, true, false]);
    let recordings = balanced.draw(&RECORDINGS);
    let durations = balanced.draw(&DURATIONS_S);
    let shapes = balanced.draw(&SHAPES);
    let errors = balanced.draw(&MODEL_ERRORS);
    let baselines = balanced.draw(&[true, false]);
    // A model with an error mostly comes with baseline recordings, without which nothing tells the error from a fault.
    let shown = balanced.draw(&[true, true, true, false]);
    let levels = balanced.draw(&(0..count).collect::<Vec<usize>>());
    (0..count)
        .map(|k| {
            let share = levels[k] as f64 / count.max(1) as f64;
            let sine = SINE_HZ[0] * (SINE_HZ[1] / SINE_HZ[0]).powf(share);
            let filter = filtered[k] && rates[k] >= FILTERED_FROM_HZ;
            Factors {
                rate_hz: rates[k],
                loudness: loudness[k],
                pressure_colour: colours[k],
                force_noise: force_noise[k],
                encoder_mm: encoders[k],
                smooth_force: smooth[k],
                cutoff_hz: if filter { 20.0 } else { 0.0 },
                recordings: recordings[k],
                duration_s: durations[k].min(LONGEST_S / recordings[k] as f64),
                shape: match shapes[k] {
                    Shape::Sine(_) => Shape::Sine((10.0 * sine).round() / 10.0),
                    other => other,
                },
                model_error: errors[k],
                baseline: if errors[k] == ModelError::None { baselines[k] } else { shown[k] },
                ..Factors::default()
            }
        })
        .collect()
}

/// Cases of a kind from the faults of each.
fn kind(
    kind: Kind,
    name: &str,
    faults: Vec<Vec<Fault>>,
    (random, first): (&mut ChaCha8Rng, u64),
) -> Vec<Case> {
    let factors = factors(faults.len(), random);
    factors
        .into_iter()
        .zip(faults)
        .enumerate()
        .map(|(k, (factors, faults))| Case {
            id: format!("{name}-{k:03}"),
            kind,
            factors,
            faults,
            conditions: Vec::new(),
            seed: first + 1 + k as u64 + 10_000 * (kind as u64 + 1),
            diagnosis_seed: 1,
            repeats: None,
        })
        .collect()
}

/// The cases of the full study, in order of kind and number.
#[must_use]
pub fn full() -> Vec<Case> {
    of_seed(SEED)
}

/// The cases of a design with another seed: with other draws, and data of their own.
#[must_use]
pub fn of_seed(seed: u64) -> Vec<Case> {
    let labels = magnitudes::labels();
    let seeds = seed.wrapping_sub(SEED).wrapping_mul(DESIGN_STEP);
    let stream = |n: u64| ChaCha8Rng::seed_from_u64(seed + n);
    let nulls = kind(Kind::Null, "nulls", vec![Vec::new(); NULLS], (&mut stream(0), seeds));
    let singles = {
        let random = &mut stream(1);
        let levels = [Strength::Weak, Strength::Medium, Strength::Medium, Strength::Strong];
        // Every label at every strength before any repeats.
        let faults: Vec<Vec<Fault>> = (0..SINGLES.max(4 * labels.len()))
            .map(|k| {
                let strength = levels[(k / labels.len() + k) % levels.len()];
                vec![Fault::drawn(labels[k % labels.len()], strength)]
            })
            .collect();
        kind(Kind::Single, "singles", faults, (random, seeds))
    };
    let pairs = {
        let random = &mut stream(2);
        let first = Balanced(random, PAIRS).draw(&labels);
        let second = Balanced(random, PAIRS).draw(&labels);
        let faults: Vec<Vec<Fault>> = (0..PAIRS)
            .map(|k| {
                // Two variants of one effect are no pair.
                let apart = |other: &&&str| id_of(other) != id_of(first[k]);
                let other = second[k..].iter().chain(&second).find(apart).expect("other effects");
                [first[k], other].map(|label| Fault::drawn(label, Strength::Medium)).to_vec()
            })
            .collect();
        kind(Kind::Pair, "pairs", faults, (random, seeds))
    };
    let onsets = {
        let random = &mut stream(3);
        let drawn = Balanced(random, ONSETS).draw(&labels);
        let shares = Balanced(random, ONSETS).draw(&[0.3, 0.5, 0.7]);
        let faults = (0..ONSETS).map(|k| {
            // One in five acts from the second recording on, instead of from a time.
            let partly = k % 5 == 4;
            vec![Fault::Drawn {
                label: drawn[k].to_owned(),
                strength: Strength::Strong,
                onset: if partly { 0.0 } else { shares[k] },
                only: partly.then(|| (1..10).collect()),
            }]
        });
        let mut cases = kind(Kind::Onset, "onset", faults.collect(), (random, seeds));
        for case in &mut cases {
            let partly = matches!(&case.faults[0], Fault::Drawn { only: Some(_), .. });
            case.factors.recordings = case.factors.recordings.max(if partly { 3 } else { 1 });
            case.factors.duration_s = case.factors.duration_s.max(10.0);
        }
        cases
    };
    let unlisted = {
        let random = &mut stream(4);
        let faults = Balanced(random, UNLISTED).draw(&magnitudes::unlisted());
        let faults = faults.into_iter().map(|h| vec![Fault::Given(h)]).collect();
        let mut cases = kind(Kind::Unlisted, "unlisted", faults, (random, seeds));
        // Events at 8 and 9 s are within the recording.
        cases.iter_mut().for_each(|c| c.factors.duration_s = c.factors.duration_s.max(20.0));
        cases
    };
    let mut all = [nulls, singles, pairs, onsets, unlisted, rig(&labels, seeds)].concat();
    let repeated: Vec<Case> = all
        .iter()
        .filter(|c| matches!(c.kind, Kind::Null | Kind::Single | Kind::Pair))
        .filter(|c| c.factors.source == Source::Plant)
        .step_by(REPEATED)
        .map(|c| Case {
            id: format!("seeds-{}", c.id),
            diagnosis_seed: c.diagnosis_seed + 1,
            repeats: Some(c.id.clone()),
            ..c.clone()
        })
        .collect();
    all.extend(repeated);
    all
}

/// Cases of the virtual rig, with its own sensors: three recordings of 0.3 of the published times beside baseline recordings.
fn rig(labels: &[&str], first: u64) -> Vec<Case> {
    let factors =
        Factors { source: Source::Rig, duration_s: RIG_S, baseline: true, ..Factors::default() };
    let case = |kind: Kind, name: &str, k: usize, faults: Vec<Fault>| Case {
        id: format!("rig-{name}-{k:03}"),
        kind,
        factors: factors.clone(),
        faults,
        conditions: Vec::new(),
        seed: first + 1 + k as u64 + 10_000 * (kind as u64 + 8),
        diagnosis_seed: 1,
        repeats: None,
    };
    let nulls = (0..RIG_NULLS).map(|k| case(Kind::Null, "nulls", k, Vec::new()));
    let singles = labels.iter().enumerate().map(|(k, label)| {
        case(Kind::Single, "singles", k, vec![Fault::drawn(label, Strength::Medium)])
    });
    let known = |h: &Hidden| h.text().parse::<pam_rig::Effect>().is_ok();
    let unlisted = magnitudes::unlisted().into_iter().filter(known).enumerate();
    let unlisted =
        unlisted.map(|(k, h)| case(Kind::Unlisted, "unlisted", k, vec![Fault::Given(h)]));
    nulls.chain(singles).chain(unlisted).collect()
}

/// The effect of a label: what stands before ` of the `.
fn id_of(label: &str) -> &str {
    label.split(' ').next().unwrap_or(label)
}
