//! Effects that begin, end or grow at a time.

use crate::support::joint::{K, P, driven, linear, subject};
use pam_data::models::{load_model, save_model};
use pam_data::{MassOrigin, ModelInfo, Subject};
use pam_effects::effects::{ALL, ActivityWindow, AnyEffect, by_id, timed};
use pam_effects::simulation::{Base, Nuisances, Trajectory, Trial, simulate};
use pam_effects::{ActiveEffect, EffectRecord, ExtendedModel};

fn record(text: &str) -> ActiveEffect {
    text.parse::<EffectRecord>().expect("a record").resolve(ALL).expect("an effect")
}

fn run(subject: &Subject, effects: &[ActiveEffect]) -> Trajectory<f64> {
    let model = linear();
    let trial = Trial::new(&model, subject);
    let parts: Vec<&dyn AnyEffect> = effects.iter().map(|a| a.effect as &dyn AnyEffect).collect();
    let values: Vec<f64> = effects.iter().flat_map(|a| a.values.clone()).collect();
    let mut out = Trajectory::default();
    simulate::<f64>(&trial, &Base::of(&model), &parts, &values, &Nuisances::none(), &mut out)
        .expect("in range");
    out
}

fn driven_subject(seconds: f64, force_n: f64, hertz: f64) -> Subject {
    let force = move |t: f64| force_n * (std::f64::consts::TAU * hertz * t).sin();
    subject(&linear(), driven(seconds, 0.0, force), MassOrigin::GasLaw)
}

/// Largest difference of two series.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Grid point of a time.
fn at(seconds: f64) -> usize {
    (seconds / 4e-3).round() as usize
}

/// Before an effect begins nothing of it is there (steps are cut where the joint turns if it has friction later, which moves it
/// by the error of a step); where a friction is there wholly, or has ended, what came before dies out.
#[test]
fn outside_its_times_an_effect_is_not_there() {
    let subject = driven_subject(8.0, 90.0, 1.0);
    let plain = run(&subject, &[]);
    for effect in ALL {
        let scales = pam_effects::effects::DataScales {
            force_n: 90.0,
            peak_force_n: 90.0,
            force_quantiles_n: Vec::new(),
            travel_mm: 0.7,
            reach_mm: 0.7,
            speed_mm_s: 4.0,
            stiffness_n_mm: 150.0,
            gauge_kpa: 310.0,
            duration_s: 8.0,
            samples: Vec::new(),
        };
        let Some(own) = effect.starts(&scales).pop() else { continue };
        let (parameters, switches) = own.split_at(effect.info().parameters.len());
        let late = timed(*effect, ActivityWindow::BEGINS);
        let values = [parameters, &[5.0], switches].concat();
        let found = run(&subject, &[ActiveEffect { effect: late, values }]);
        let until = at(5.0 - 0.05) - 1;
        for (channel, plain) in found.channels.iter().zip(&plain.channels) {
            let apart = apart(&channel[..until], &plain[..until]);
            assert!(apart < 2e-5, "{}: {apart}", effect.info().id);
        }
    }
    let friction = run(&subject, &[record("coulomb_friction:force_n=20")]);
    let late = run(&subject, &[record("coulomb_friction:force_n=20,onset_s=3")]);
    let early = run(&subject, &[record("coulomb_friction:force_n=20,end_s=3")]);
    let last = at(6.0)..at(7.9);
    let x = |run: &Trajectory<f64>| run.channels[0][last.clone()].to_vec();
    assert!(apart(&x(&late), &x(&friction)) < 1e-6);
    assert!(apart(&x(&early), &x(&plain)) < 2e-5);
    assert!(apart(&x(&friction), &x(&plain)) > 0.05);
}

/// A load of F that begins moves a spring to F/K, whatever the ramp; a leak that begins at a time lowers the pressure as
/// `e^(−rate (t − onset))`, since the ramp is symmetric about the onset.
#[test]
fn a_load_and_a_leak_begin_as_their_equations_say() {
    let at_rest = driven_subject(10.0, 0.0, 1.0);
    for times in ["onset_s=2", "onset_s=3,ramp_s=4"] {
        let found = run(&at_rest, &[record(&format!("constant_load:force_n=30,{times}"))]);
        let (first, last) = (found.channels[0][at(0.9)], found.channels[0][at(9.5)]);
        assert!(first.abs() < 1e-12 && (last - 30e3 / K).abs() < 1e-9, "{times}: {first} {last}");
    }
    let (rate, onset): (f64, f64) = (0.05, 4.0);
    let leak = format!("leak:flexor_rate_per_s={rate},extensor_rate_per_s={rate},onset_s={onset}");
    let found = run(&at_rest, &[record(&leak)]);
    let gauge = |k: usize| found.channels[2][k] - 101.325;
    assert!((gauge(at(3.9)) - (P - 101.325)).abs() < 1e-9);
    let expected = (P - 101.325) * (-rate * (9.0 - onset)).exp();
    assert!((gauge(at(9.0)) / expected - 1.0).abs() < 2e-4, "{} {expected}", gauge(at(9.0)));
}

/// A spring in series with a damper that begins at a time is relaxed then: under a steady load its force rises from zero to
/// what the joint moves, and does not jump.
#[test]
fn what_an_effect_remembers_begins_with_it() {
    let model = linear();
    let held = subject(&model, driven(6.0, 0.0, |_| 60.0), MassOrigin::Given);
    let plain = run(&held, &[]);
    let late = run(&held, &[record("creep:stiffness_n_mm=50,time_constant_s=20,onset_s=4")]);
    let (x, rest) = (&late.channels[0], plain.channels[0][at(3.9)]);
    assert!(x[at(4.5)..].iter().all(|v| (v - rest).abs() < 1e-6), "{} {rest}", x[at(5.0)]);
}

/// Times are values of an effect in files and on command lines.
#[test]
fn times_stand_beside_the_values_of_an_effect() {
    let friction = record("coulomb_friction:force_n=25,onset_s=35.5,ramp_s=3,end_s=60");
    assert_eq!(friction.values, [25.0, 35.5, 3.0, 60.0]);
    let names: Vec<&str> = friction.effect.info().value_names().collect();
    assert_eq!(names, ["force_n", "onset_s", "ramp_s", "end_s"]);
    assert_eq!(friction.effect.info().id, "coulomb_friction");
    let again = record("coulomb_friction:force_n=1,onset_s=35.5,ramp_s=3,end_s=60");
    assert!(std::ptr::addr_eq(friction.effect, again.effect), "made once");
    // Switches stay behind.
    let gas = record("polytropic_gas:exponent=1.2,onset_s=3");
    assert_eq!(gas.values, [1.2, 3.0, 0.0]);

    let text = r#"
        [[effect]]
        id = "late_spring"
        description = "spring with a switch"
        parameters.stiffness_n_mm = { range = [0, 100], absent = 0 }
        switches.cubic = { values = [0, 1] }
        acts.force_n = "-stiffness_n_mm * if(cubic > 0, x^3, x)"
    "#;
    let spring = pam_effects::expression::parse(text).expect("a definition")[0];
    let spring =
        ActiveEffect { effect: timed(spring, ActivityWindow::ENDS), values: vec![4.0, 7.25, 1.0] };
    let model = ExtendedModel {
        joint: linear(),
        info: ModelInfo { name: "m".into(), ..ModelInfo::default() },
        effects: vec![friction, gas, spring],
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("m.safetensors");
    save_model(&path, &model.to_saved()).expect("written");
    let back = ExtendedModel::from_saved(load_model(&path).expect("read")).expect("known effects");
    assert_eq!(back.describe_effects(), model.describe_effects());
    for (a, b) in back.effects.iter().zip(&model.effects) {
        assert_eq!(a.values, b.values);
        assert_eq!(a.effect.info(), b.effect.info());
    }

    for (text, said) in [
        ("coulomb_friction:force_n=25,ramp_s=3", "onset_s"),
        ("coulomb_friction:force_n=25,onset_s=-1", "outside"),
        ("coulomb_friction:force_n=25,onset=1", "onset_s"),
    ] {
        let refused = text.parse::<EffectRecord>().expect("a record").resolve(ALL);
        let message = refused.expect_err("refused").to_string();
        assert!(message.contains("coulomb_friction") && message.contains(said), "{message}");
    }
    assert!(by_id("coulomb_friction").expect("listed").course().is_none());
}
