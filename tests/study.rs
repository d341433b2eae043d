//! The confusion matrix and the detection curves of the diagnosis, printed as tables.
//!
//! `cargo run --release -p pam-tests --example study -- plant|rig|rig-ideal WHAT…` with WHAT one of
//! `all@STRENGTH`, `pairs`, `nulls`, `unlisted`, or effects as the rig's command line writes them, several
//! joined by `+`. `PAM_STUDY_SEEDS` sets the number of seeds (1), each with pressures of its own; `PAM_STUDY_SHARE`
//! the share of the published excitation's times (0.3), `PAM_STUDY_HEALTHY=0` leaves the rig's healthy recordings
//! out, `PAM_STUDY_NOISE` multiplies the noise of the plant's sensors (1), with `PAM_STUDY_SMOOTH=1` the plant's
//! force is smooth between samples, `PAM_STUDY_MODEL` is the model with which the rig's recordings are diagnosed.
//! With `PAM_STUDY_CSV=FILE` every hidden effect becomes a row of a table; `study -- tables FILE…` sums such
//! tables up.

use pam_data::{SavedModel, Subject, load_model, parse_model};
use pam_diagnose::JointDiagnosis;
use pam_diagnose::fit::Interval;
use pam_tests::diagnose::{as_text, at_strength, diagnosed, plant_runs, rig_runs, vocabulary};
use pam_tests::plant::{Hidden, Noise, excitation, hidden};
use pam_tests::tables::{Row, tables};
use std::path::Path;
use std::time::Instant;

/// Pressures (psi) of the recordings under diagnosis; every seed takes the next row.
const CONDITIONS: [[[u8; 2]; 3]; 4] = [
    [[45, 45], [30, 60], [70, 60]],
    [[40, 50], [65, 35], [55, 75]],
    [[50, 50], [25, 45], [75, 40]],
    [[35, 35], [60, 70], [45, 20]],
];
const HEALTHY: [[u8; 2]; 4] = [[45, 45], [60, 30], [60, 60], [40, 70]];

/// Pairs and triples that are hidden together.
pub const SETS: [&[&str]; 13] = [
    &["coulomb_friction", "pressure_delay"],
    &["hysteresis", "leak"],
    &["viscous_damping", "position_gain"],
    &["stiffness_scale", "backlash"],
    &["added_inertia", "pressure_gain"],
    &["creep", "actuation_delay"],
    &["constant_load", "geometry_coefficient"],
    &["force_saturation", "pressure_sensor_lag"],
    &["cogging", "stiffness_drift"],
    &["tendon_slack", "position_offset"],
    &["coulomb_friction", "leak", "backlash"],
    &["viscous_damping", "pressure_delay", "constant_load"],
    &["stiffness_scale", "pressure_bias", "cogging"],
];

fn main() {
    let mut arguments = std::env::args().skip(1);
    let source = arguments.next().expect("plant, rig, rig-ideal or tables");
    if source == "tables" {
        let rows: Vec<Row> = arguments.flat_map(|path| Row::read(Path::new(&path))).collect();
        print!("{}", tables(&rows));
        return;
    }
    let number = |name: &str, otherwise: f64| {
        std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(otherwise)
    };
    let seeds = number("PAM_STUDY_SEEDS", 1.0) as u64;
    let share = number("PAM_STUDY_SHARE", 0.3);
    let noise = noise(number("PAM_STUDY_NOISE", 1.0));
    let saved: SavedModel = if source == "plant" {
        load_model(&pam_tests::published_weights()).expect("the published weights")
    } else if let Ok(path) = std::env::var("PAM_STUDY_MODEL") {
        load_model(Path::new(&path)).expect("a model")
    } else {
        let bytes = include_bytes!("../pam-cli/models/default.safetensors");
        parse_model(Path::new("default"), bytes).expect("the default model")
    };
    let ideal = source == "rig-ideal";
    let smooth: Vec<Hidden> =
        std::env::var("PAM_STUDY_SMOOTH").iter().map(|_| hidden("smooth_command", &[])).collect();
    let healthy: Option<Vec<Subject>> = (source != "plant"
        && number("PAM_STUDY_HEALTHY", 1.0) != 0.0)
        .then(|| rig_runs(&saved, &HEALTHY, share, &[], ideal, 99));
    let mut table = std::env::var("PAM_STUDY_CSV").ok().map(Table::create);
    let mut total = 0;
    let mut right = 0;
    let mut estimates = Estimates::default();
    for what in arguments {
        for set in cases(&what) {
            for seed in 1..=seeds {
                let conditions = &CONDITIONS[(seed as usize - 1) % CONDITIONS.len()];
                let data = if source == "plant" {
                    let conditions = conditions.map(|psi| psi.map(f64::from));
                    let acting = [&set[..], &smooth].concat();
                    plant_runs(&saved, &conditions, &excitation(share), &acting, noise, seed)
                } else {
                    let texts: Vec<String> = set.iter().map(as_text).collect();
                    let texts: Vec<&str> = texts.iter().map(String::as_str).collect();
                    rig_runs(&saved, conditions, share, &texts, ideal, seed)
                };
                let start = Instant::now();
                let d = diagnosed(&saved, &data, healthy.as_deref(), seed);
                total += 1;
                right += usize::from(print(&set, &d, seed, start.elapsed().as_secs_f64()));
                estimates.count(&set, &d);
                if let Some(table) = &mut table {
                    table.write(&source, &what, &set, &d, seed);
                }
            }
        }
    }
    println!("{right} of {total} right");
    println!(
        "{} of {} parameters within 10 % or inside their interval, {} inside, {} within 10 %",
        estimates.good, estimates.all, estimates.inside, estimates.near
    );
}

/// How estimates of named effects compare with the truth.
#[derive(Default)]
struct Estimates {
    all: usize,
    good: usize,
    inside: usize,
    near: usize,
}

/// Estimates of the parameters of an effect that was hidden and named: name, truth, interval.
fn estimates<'d>(hidden: &Hidden, d: &'d JointDiagnosis) -> Vec<(&'d str, f64, Interval)> {
    let Some(cause) = d.causes.iter().find(|c| c.effect == hidden.0) else { return Vec::new() };
    cause
        .parameters
        .iter()
        .filter_map(|(name, interval)| Some((*name, *hidden.1.get(*name)?, *interval)))
        .collect()
}

fn inside(truth: f64, i: &Interval) -> bool {
    (i.ci95[0]..=i.ci95[1]).contains(&truth)
}

fn near(truth: f64, i: &Interval) -> bool {
    (i.value - truth).abs() <= 0.1 * truth.abs()
}

impl Estimates {
    fn count(&mut self, set: &[Hidden], d: &JointDiagnosis) {
        for (_, truth, i) in set.iter().flat_map(|h| estimates(h, d)) {
            self.all += 1;
            self.inside += usize::from(inside(truth, &i));
            self.near += usize::from(near(truth, &i));
            self.good += usize::from(inside(truth, &i) || near(truth, &i));
        }
    }
}

/// The table of a study, written case by case.
struct Table(csv::Writer<std::fs::File>);

impl Table {
    fn create(path: String) -> Self {
        Self(csv::Writer::from_path(path).expect("a place for the table"))
    }

    fn write(&mut self, source: &str, case: &str, set: &[Hidden], d: &JointDiagnosis, seed: u64) {
        let join = |ids: Vec<&str>| ids.join("+");
        let named = join(d.named());
        let confusable = join(
            d.causes.iter().flat_map(|c| c.confusable_with.iter().map(String::as_str)).collect(),
        );
        let g = &d.error_reduction.overall;
        let nothing = [("none".to_owned(), Default::default())];
        for hidden in if set.is_empty() { &nothing } else { set } {
            let row = Row {
                source: source.into(),
                case: case.into(),
                hidden: hidden.0.clone(),
                seed,
                over_noise: over_noise(d),
                verdict: d.verdict.to_string(),
                named: named.clone(),
                confusable: confusable.clone(),
                gain: g.error_reduction,
                gain_low: g.ci95[0],
                gain_high: g.ci95[1],
                ..Row::default()
            };
            let found = estimates(hidden, d);
            let with = |(name, truth, i): &(&str, f64, Interval)| Row {
                parameter: (*name).to_owned(),
                truth: Some(*truth),
                value: Some(i.value),
                low: Some(i.ci95[0]),
                high: Some(i.ci95[1]),
                ..row.clone()
            };
            let mut rows: Vec<Row> = found.iter().map(with).collect();
            if rows.is_empty() {
                rows.push(row);
            }
            for row in rows {
                self.0.serialize(row).expect("room for the table");
            }
        }
        self.0.flush().expect("room for the table");
    }
}

/// Residual of the plain model over what the data's noise allows, root mean square over x, P_f and P_e.
fn over_noise(d: &JointDiagnosis) -> f64 {
    let square: f64 = d.residual.channels.iter().map(|c| (c.rms / c.noise).powi(2)).sum();
    (square / d.residual.channels.len() as f64).sqrt()
}

fn noise(factor: f64) -> Noise {
    let n = Noise::default();
    Noise {
        displacement_mm: factor * n.displacement_mm,
        pressure_kpa: factor * n.pressure_kpa,
        force_n: factor * n.force_n,
    }
}

fn cases(what: &str) -> Vec<Vec<Hidden>> {
    if let Some(strength) = what.strip_prefix("all@") {
        let strength: f64 = strength.parse().expect("a strength");
        return vocabulary().iter().map(|v| vec![at_strength(v.0, strength)]).collect();
    }
    match what {
        "pairs" => SETS.iter().map(|s| s.iter().map(|id| at_strength(id, 1.0)).collect()).collect(),
        "nulls" => vec![vec![]],
        "unlisted" => vec![
            vec![hidden("periodic_disturbance", &[("force_n", 12.0), ("frequency_hz", 1.37)])],
            vec![hidden("chamber_crosstalk", &[("rate_per_s", 4e-3)])],
            vec![hidden("tendon_slip", &[("time_s", 9.0), ("slip_mm", 0.4)])],
            vec![hidden("sensor_gain_jump", &[("time_s", 8.0), ("relative", 0.06)])],
            vec![hidden("encoder_freeze", &[("period_s", 3.3), ("duration_s", 0.3)])],
            vec![hidden("valve_glitch", &[("time_s", 9.0), ("mass_mg", 6.0)])],
        ],
        _ => vec![what.split('+').map(parse).collect()],
    }
}

fn parse(text: &str) -> Hidden {
    let (id, rest) = text.split_once(':').unwrap_or((text, ""));
    let values: Vec<(&str, f64)> = rest
        .split(',')
        .filter_map(|kv| kv.split_once('='))
        .map(|(k, v)| (k, v.parse().expect("a number")))
        .collect();
    hidden(id, &values)
}

/// Prints one case and says whether it came out right: every hidden effect named or confusable with a named
/// one, or nothing named where nothing listed is hidden.
fn print(set: &[Hidden], d: &JointDiagnosis, seed: u64, seconds: f64) -> bool {
    let listed = |id: &str| vocabulary().iter().any(|v| v.0 == id);
    let exact = set.iter().all(|h| d.causes.iter().any(|c| c.effect == h.0));
    let found =
        |h: &Hidden| d.causes.iter().any(|c| c.effect == h.0 || c.confusable_with.contains(&h.0));
    let right = if set.iter().any(|h| !listed(&h.0)) {
        d.verdict != pam_diagnose::Verdict::Explained
    } else if set.is_empty() {
        d.verdict == pam_diagnose::Verdict::NothingFound
    } else {
        set.iter().all(found) && d.causes.len() == set.len()
    };
    let truth: Vec<String> = set.iter().map(as_text).collect();
    println!(
        "{} {} seed {seed} {seconds:.1} s | {} | {}",
        if !right {
            "WRONG"
        } else if exact {
            "ok   "
        } else {
            "near "
        },
        truth.join(" + "),
        d.verdict,
        d.causes
            .iter()
            .map(|c| {
                let values: Vec<String> = c
                    .parameters
                    .iter()
                    .map(|(n, i)| {
                        format!("{n} {:.4} [{:.4}, {:.4}]", i.value, i.ci95[0], i.ci95[1])
                    })
                    .collect();
                format!("{} ({}) ~{:?}", c.effect, values.join(", "), c.confusable_with)
            })
            .collect::<Vec<_>>()
            .join(" + ")
    );
    println!(
        "      removed {:.3}, any correction {:.3}, overall gain {:.2} [{:.2}, {:.2}], best alone {:?}",
        d.explainable.named,
        d.explainable.any_correction,
        d.error_reduction.overall.error_reduction,
        d.error_reduction.overall.ci95[0],
        d.error_reduction.overall.ci95[1],
        d.ranking
            .iter()
            .take(3)
            .map(|r| (r.effect.as_str(), (r.score * 100.0).round()))
            .collect::<Vec<_>>()
    );
    right
}
