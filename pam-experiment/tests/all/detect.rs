use crate::common::{clean, diagnosis, model, noise, noisy, protocol};
use pam_diagnose::{RecordingSets, diagnose};
use pam_experiment::detect::{
    DetectOptions, LimitTrial, TriedLimit, detect, needed_noncentrality, noncentral_chi_square_sf,
};
use pam_experiment::plan::{noise_from_toml, sensor_view};
use pam_numerics::statistics::root_mean_square;
use pam_rig::sensors::SensorParameters;
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rand_distr::StandardNormal;

const IDS: [&str; 5] =
    ["coulomb_friction", "viscous_damping", "constant_load", "position_offset", "backlash"];

/// Power of a χ² test at 5 % with one degree of freedom is 0.8 at λ = 7.849 and 0.9 at λ = 10.507 (Cohen 1988, table 12.4: w² N of
/// 7.85 and 10.51).
#[test]
fn power_is_that_of_published_tables() {
    let critical = 3.841_459;
    for (power, noncentrality) in [(0.8, 7.849), (0.9, 10.507)] {
        let found = needed_noncentrality(critical, 1.0, power);
        assert!((found - noncentrality).abs() < 0.01, "{found}");
        assert!((noncentral_chi_square_sf(critical, 1.0, noncentrality) - power).abs() < 1e-3);
    }
    // 4 degrees of freedom: 11.935 for 80 %.
    assert!((needed_noncentrality(9.487_729, 4.0, 0.8) - 11.935).abs() < 0.01);
}

/// Trials below the limit, or in which nothing was named, say nothing of confusions.
#[test]
fn confusions_are_those_of_trials_at_the_limit() {
    let trial = |magnitude: f64, names: &[&str]| LimitTrial {
        value: magnitude,
        magnitude,
        named: !names.is_empty(),
        names: names.iter().map(|n| (*n).to_owned()).collect(),
    };
    let of = |trials: Vec<LimitTrial>| {
        TriedLimit { trials, interval: [0.5, 2.0], magnitude: 1.0 }.confusions("backlash", 1.0)
    };
    assert_eq!(of(vec![trial(0.8, &["creep"]), trial(1.2, &[])]), None);
    let both = trial(1.5, &["creep", "backlash"]);
    assert_eq!(of(vec![trial(0.8, &["creep"]), trial(1.2, &["creep"]), both]), Some([1, 2]));
}

/// The noise of the measured force moves all channels together, so that what one shares with the others is correlated: the
/// standard deviation that is reported is still that of rows that are drawn from the noise.
#[test]
fn deviations_are_those_of_drawn_noise() {
    let (model, sensors) = (model(), SensorParameters::default());
    let recordings = clean(&model, &protocol(8.0));
    let view = sensor_view(&model, &recordings, &sensors, &diagnosis(&IDS)).expect("a noise");
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let drawn = view.noise.drawn(200_000, || random.sample(StandardNormal));
    for (channel, rows) in drawn.iter().enumerate() {
        let ratio = root_mean_square(rows) / view.noise.deviation(channel);
        assert!((ratio - 1.0).abs() < 0.05, "channel {channel}: {ratio}");
    }
}

/// The limit of a linear effect grows with the noise, and a play is seen from a width on that grows with it; effects
/// that stand for each other are nearly parallel.
#[test]
fn limits_grow_with_the_noise() {
    let (model, recordings) = (model(), clean(&model(), &protocol(8.0)));
    let options =
        DetectOptions { diagnosis: diagnosis(&IDS), trials: Some(0), ..DetectOptions::default() };
    let of = |size: f64| {
        detect(&model, &recordings, Some(&noise(size).into()), &options, &|_, _| {})
            .expect("limits")
    };
    let (quiet, loud) = (of(1.0), of(3.0));
    for id in ["viscous_damping", "position_offset"] {
        let value = |d: &pam_experiment::detect::Detection| {
            d.of(id).and_then(|l| l.familywise).map(|l| l.value)
        };
        let ratio = value(&loud).zip(value(&quiet)).map(|(l, q)| l / q).expect("limits");
        // Priors of nuisances do not grow with the noise.
        assert!((2.0..3.4).contains(&ratio), "{id}: {ratio}");
    }
    for l in &quiet.limits {
        let values = [l.familywise, l.listed, l.named].map(|l| l.map(|l| l.magnitude));
        assert!(values[0] <= values[1] && values[1] <= values[2], "{values:?}");
    }
    // Dry friction and play of the same joint are not the same signature.
    let pair = |a: &str, b: &str| {
        let found = quiet.pairs.iter().find(|p| p.effect == a && p.other == b);
        found.map(|p| p.cosine).expect("a pair")
    };
    assert!(pair("constant_load", "position_offset") > 0.9);
    assert!(pair("backlash", "constant_load") < 0.5);
}

/// A diagnosis names an effect at twice its foretold limit, and not at a third of it.
#[test]
fn a_diagnosis_agrees_with_its_limit() {
    let (model, protocol) = (model(), protocol(12.0));
    let options = DetectOptions {
        diagnosis: diagnosis(&IDS),
        effects: vec!["coulomb_friction".parse().expect("an effect")],
        trials: Some(4),
        ..DetectOptions::default()
    };
    let null = noisy(&model, &protocol, None, 1);
    let detection = detect(&model, &null, None, &options, &|_, _| {}).expect("limits");
    let limit = detection.limits[0].value().expect("friction is seen");
    let tried = detection.limits[0].tried.as_ref().expect("trials");
    assert_eq!(tried.trials.len(), 4);
    assert!(tried.interval[0] < limit && limit < tried.interval[1], "{tried:?}");
    let named = |multiple: f64| {
        let data = noisy(&model, &protocol, Some(("coulomb_friction", multiple * limit)), 2);
        let sets = RecordingSets { data: &data, ..RecordingSets::default() };
        let found = diagnose(&model, &sets, &options.diagnosis, &|_, _| {}).expect("a diagnosis");
        found.named().contains(&"coulomb_friction")
    };
    assert!(named(2.0), "at twice {limit} N");
    assert!(!named(0.33), "at a third of {limit} N");
}

#[test]
fn wrong_noise_is_named_with_its_field() {
    let text = "x_mm = { deviation = -1 }\npressure_flexor_kpa = { deviation = 1 }\npressure_extensor_kpa = { deviation = 1 }";
    let message = noise_from_toml(text, "n.toml", 0.02).expect_err("negative").to_string();
    assert!(message.contains("n.toml") && message.contains("x_mm"), "{message}");
    assert!(noise_from_toml("x = 1", "n.toml", 0.02).is_err());
}
