//! Effects as expressions against the built-in ones, and against equations.

use crate::support::extended::smooth;
use crate::support::published::{exact_run, weights};
use crate::support::values::medium;
use pam_core::Scalar;
use pam_data::models::{load_model, save_model};
use pam_data::{MassOrigin, ModelInfo};
use pam_effects::effects::{
    AnyEffect, DataScales, Derivatives, EffectHooks, FixedState, Observed, by_id,
};
use pam_effects::simulation::{Base, Nuisances, SimulationScalar, Trajectory, Trial, simulate};
use pam_effects::{ActiveEffect, EffectError, EffectRecord, ExtendedModel, expression};
use pam_trajectory::loss::AnyLoss;
use std::f64::consts::TAU;
use std::path::Path;

/// The built-in effects as expressions.
const BUILT_IN: &str = include_str!("built_in.toml");

fn effect(id: &str) -> &'static dyn AnyEffect {
    let all = expression::parse(BUILT_IN).expect("it can be read");
    all.into_iter().find(|e| e.info().id == format!("x_{id}")).expect("one for each built-in")
}

fn run<S: SimulationScalar>(trial: &Trial, effect: &dyn AnyEffect, values: &[S]) -> Trajectory<S> {
    let base = Base::of(&weights());
    let mut out = Trajectory::default();
    simulate::<S>(trial, &base, &[effect], values, &Nuisances::none(), &mut out).expect("in range");
    out
}

/// A recording whose air masses follow from its sealed pressures.
fn with_masses_of_the_gas_law() -> Trial {
    let model = weights();
    let mut subject = exact_run(&model, [30.0, 60.0], 0.06);
    subject.origin = MassOrigin::GasLaw;
    Trial::new(&model, &subject)
}

/// Variation of the channels in these runs: mm, mm/s, kPa, kPa.
const UNITS: [f64; 4] = [2.0, 20.0, 30.0, 30.0];

/// Trajectories and their derivatives by every parameter are those of the effect in Rust.
#[test]
fn every_built_in_effect_can_be_an_expression() {
    let trial = with_masses_of_the_gas_law();
    for (id, values) in medium() {
        let count = by_id(id).expect("an id").info().parameters.len();
        let seeded: Vec<Derivatives> = (0..values.len())
            .map(|k| match k < count {
                true => Derivatives::variable(values[k], k),
                false => Derivatives::constant(values[k]),
            })
            .collect();
        let built_in = run(&trial, by_id(id).expect("an id"), &seeded);
        let with_derivatives = run(&trial, effect(id), &seeded);
        let plain = run(&trial, effect(id), &values);
        for (c, unit) in UNITS.into_iter().enumerate() {
            for (k, expected) in built_in.channels[c].iter().enumerate() {
                let own = &with_derivatives.channels[c][k];
                for value in [own.value, plain.channels[c][k]] {
                    let off = (value - expected.value).abs();
                    assert!(off < 1e-9 * unit, "{id}, channel {c}, point {k}: {off:e}");
                }
                for (p, value) in values[..count].iter().enumerate() {
                    let [own, expected] = [own, expected].map(|v| v.derivatives[p] * value);
                    let off = (own - expected).abs();
                    assert!(off < 1e-7 * unit, "{id}, channel {c}, point {k}, by {p}: {off:e}");
                }
            }
        }
    }
}

/// Gradients on tapes through the network are those of the effect in Rust.
#[test]
fn expressions_are_trained_like_built_in_effects() {
    let joint = smooth();
    let subject = exact_run(&joint, [45.0, 45.0], 0.02);
    for (id, values) in medium() {
        let gradient = |effect| {
            let plain = ExtendedModel {
                joint: joint.clone(),
                info: ModelInfo::default(),
                effects: vec![ActiveEffect { effect, values: values.clone() }],
            };
            plain
                .value_and_gradient(std::slice::from_ref(&subject), &AnyLoss::default())
                .expect("a network")
        };
        let [built_in, own] = [by_id(id).expect("an id"), effect(id)].map(gradient);
        let near = |a: f64, b: f64, unit: f64| (a - b).abs() <= 1e-7 * unit.abs() + 1e-12;
        assert!(near(own.value, built_in.value, built_in.value), "{id}");
        for (k, (a, b)) in own.effects.iter().zip(&built_in.effects).enumerate() {
            assert!(near(*a, *b, b.abs() + built_in.value / values[k]), "{id} {k}: {a} {b}");
        }
        let largest = built_in.force.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        assert!(own.force.iter().zip(&built_in.force).all(|(a, b)| near(*a, *b, largest)), "{id}");
    }
}

/// A saved model carries its expressions: another process needs no file of effects.
#[test]
fn a_saved_model_carries_its_expressions() {
    let text = "[[effect]]\nid = \"only_in_this_test\"\ndescription = \"spring that hardens\"\n\
                parameters.stiffness_n_mm3 = { range = [0, 10], absent = 0 }\n\
                acts.force_n = \"-stiffness_n_mm3 * x^3\"\n";
    let effect = expression::parse(text).expect("it can be read")[0];
    let model = ExtendedModel {
        joint: smooth(),
        info: ModelInfo::default(),
        effects: vec![ActiveEffect { effect, values: vec![1.0 / 3.0] }],
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("model.safetensors");
    save_model(&path, &model.to_saved()).expect("written");
    let saved = load_model(&path).expect("read");
    assert!(by_id("only_in_this_test").is_none(), "it was never registered");
    let record = &EffectRecord::all_of(&saved.info).expect("one effect")[0];
    let definition = record.definition.clone().expect("it is an expression");
    assert!(definition.contains("-stiffness_n_mm3 * x^3"), "{definition}");
    let back = ExtendedModel::from_saved(saved).expect("it brings its definition");
    assert_eq!(back.effects[0].values, [1.0 / 3.0]);
    // One definition is one effect in a process.
    assert!(std::ptr::eq(back.effects[0].effect.info(), effect.info()));
    // What was saved is read as a file, too.
    assert!(std::ptr::eq(
        expression::parse(&definition).expect("it can be read")[0].info(),
        effect.info()
    ));
}

/// A bound between two parameters is read, whichever comes first, and saved.
#[test]
fn a_parameter_may_be_a_lower_bound_of_another_one() {
    let file = |bound: &str| {
        format!(
            "[[effect]]\nid = \"bounded\"\ndescription = \"friction that is higher at rest\"\n\
             parameters.static_n = {{ range = [0, 100], absent = 0, not_below = \"{bound}\" }}\n\
             parameters.coulomb_n = {{ range = [0, 100], absent = 0 }}\n\
             acts.dry_friction_n = \"coulomb_n + (static_n - coulomb_n) * exp(-abs(v))\"\n"
        )
    };
    let effect = expression::parse(&file("coulomb_n")).expect("it can be read")[0];
    let bounds = effect.info().parameters.iter().map(|p| p.not_below);
    assert!(bounds.eq([Some(1), None]));
    let saved = effect.definition().expect("it is an expression");
    assert!(std::ptr::eq(
        expression::parse(saved).expect("it can be read")[0].info(),
        effect.info()
    ));
    for (wrong, words) in [("coulombs_n", "did you mean `coulomb_n`"), ("static_n", "is none")] {
        let message = expression::parse(&file(wrong)).expect_err("no such parameter").to_string();
        assert!(message.contains("line 4, column 67") && message.contains(words), "{message}");
    }
}

/// The files that come with the project.
fn shipped() -> Vec<&'static dyn AnyEffect> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/effects");
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("there").map(|e| e.expect("an entry").path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    assert!(paths.len() >= 8, "{paths:?}");
    paths.iter().flat_map(|path| expression::load(path).expect("it can be read")).collect()
}

/// Each shipped effect runs from its starting values, does something there, and nothing where it is absent.
#[test]
fn shipped_effects_run() {
    let model = weights();
    let subject = exact_run(&model, [30.0, 60.0], 0.06);
    let trial = Trial::new(&model, &subject);
    let scales = DataScales {
        force_n: 130.0,
        peak_force_n: 200.0,
        force_quantiles_n: Vec::new(),
        travel_mm: 1.5,
        reach_mm: 1.5,
        speed_mm_s: 8.0,
        stiffness_n_mm: 150.0,
        gauge_kpa: 310.0,
        duration_s: 10.0,
        samples: Vec::new(),
    };
    let mut out = Trajectory::default();
    simulate::<f64>(&trial, &Base::of(&model), &[], &[], &Nuisances::none(), &mut out)
        .expect("in range");
    let without = out;
    let distance = |run: &Trajectory<f64>| {
        let channel = |c: usize| {
            let off = run.channels[c].iter().zip(&without.channels[c]).map(|(a, b)| (a - b).abs());
            off.fold(0.0, f64::max) / UNITS[c]
        };
        (0..4).map(channel).fold(0.0, f64::max)
    };
    for effect in shipped() {
        let info = effect.info();
        let starts = effect.starts(&scales);
        assert!(!starts.is_empty() && starts.iter().all(|s| s.len() == info.value_len()));
        let moved: Vec<f64> = starts.iter().map(|s| distance(&run(&trial, effect, s))).collect();
        // An amplitude that starts at zero does nothing yet.
        let from_zero = info
            .parameters
            .iter()
            .enumerate()
            .all(|(k, p)| p.off.is_some_and(|off| starts[0][k] == off));
        let most = moved.iter().copied().fold(0.0, f64::max);
        assert!(most.is_finite() && (most > 1e-4 || from_zero), "{}: {most}", info.id);
        let mut absent = starts[0].clone();
        for (value, p) in absent.iter_mut().zip(info.parameters) {
            *value = p.off.unwrap_or(*value);
        }
        if info.parameters.iter().any(|p| p.off.is_some()) {
            let left = distance(&run(&trial, effect, &absent));
            assert!(left < 1e-9, "{}: {left} where it is absent", info.id);
        }
    }
}

/// A force that hardens is the Duffing oscillator's; a lag is the low-pass's answer to a sine.
#[test]
fn expressions_are_the_equations_that_they_say() {
    let shipped = shipped();
    let by_id = |id: &str| *shipped.iter().find(|e| e.info().id == id).expect("a shipped one");
    let mut joint = FixedState::at_rest([400.0, 300.0]);
    joint.motion.displacement_mm = 2.0;
    joint.motion.velocity_mm_s = -3.0;
    let force = |id: &str, p: &[f64]| {
        let hooks: &dyn EffectHooks<f64> = by_id(id);
        hooks.force_mn(p, &joint.point(), &[])
    };
    assert!((force("hardening_spring", &[0.5]) + 4e3).abs() < 1e-9);
    assert!((force("asymmetric_viscosity", &[700.0, 200.0]) - 600.0).abs() < 1e-9);
    let friction: &dyn EffectHooks<f64> = by_id("pressure_friction");
    let level = friction.dry_friction_mn(&[3.0, 0.05], &joint.point(), &[]);
    assert!((level - 1e3 * (3.0 + 0.05 * (700.0 - 2.0 * 101.325))).abs() < 1e-9);

    // A sensor that feels the drive.
    let text = "[[effect]]\nid = \"sag\"\ndescription = \"\"\nparameters.c = { range = [0, 1], absent = 0 }\n\
                acts.pressure_flexor_kpa = \"pf - c * abs(force)\"";
    let sag: &dyn EffectHooks<f64> = expression::parse(text).expect("it can be read")[0];
    let forces: Vec<f64> = (0..20).map(|k| 1e3 * (f64::from(k) - 8.0)).collect();
    let ([mut x, mut v], [mut pf, mut pe]) = ([[0.0; 10]; 2], [[400.0; 10]; 2]);
    let mut seen = Observed {
        start_s: 0.0,
        step_s: 1e-3,
        half_step_forces_mn: &forces,
        displacement_mm: &mut x,
        velocity_mm_s: &mut v,
        pressures_kpa: [&mut pf, &mut pe],
        before: None,
    };
    sag.observe(&[0.5], &mut seen);
    for (k, p) in pf.into_iter().enumerate() {
        assert_eq!(p, 400.0 - 0.5 * (2.0 * k as f64 - 8.0).abs(), "{k}");
    }
    assert_eq!(pe, [400.0; 10]);

    // 1/(1 + iωτ) of a sine of 2 Hz through 20 ms, once the beginning has died out.
    let (rate, tau, step_s) = (TAU * 2.0, 0.02, 1e-3);
    let count = 2000;
    let mut x: Vec<f64> = (0..count).map(|k| (rate * step_s * f64::from(k)).sin()).collect();
    let mut v: Vec<f64> = (0..count).map(|k| rate * (rate * step_s * f64::from(k)).cos()).collect();
    let (mut pf, mut pe) = (vec![400.0; x.len()], vec![400.0; x.len()]);
    let mut seen = Observed {
        start_s: 0.0,
        step_s,
        half_step_forces_mn: &vec![0.0; 2 * x.len()],
        displacement_mm: &mut x,
        velocity_mm_s: &mut v,
        pressures_kpa: [&mut pf, &mut pe],
        before: None,
    };
    let lag: &dyn EffectHooks<f64> = by_id("position_lag");
    lag.observe(&[1e3 * tau], &mut seen);
    let (gain, late) = ((1.0 + (rate * tau).powi(2)).sqrt().recip(), (rate * tau).atan());
    for k in 1000..count {
        let angle = rate * step_s * f64::from(k) - late;
        assert!((x[k as usize] - gain * angle.sin()).abs() < 1e-4);
        assert!((v[k as usize] - gain * rate * angle.cos()).abs() < 1e-3);
    }
}

/// A sum of terms whose coefficients are all zero is differentiated by these with memory states that have no derivatives. The derivatives
/// are those of plain runs, of a force and of a flow of air.
#[test]
fn derivatives_by_coefficients_that_are_zero_need_none_of_what_is_remembered() {
    let definitions = r#"
        [[effect]]
        id = "force_that_remembers"
        description = ""
        parameters.a_n_mm = { range = [-100, 100], absent = 0 }
        parameters.b_n_s_mm = { range = [-100, 100], absent = 0 }
        memory.slow_mm = { start = "x", rate = "(x - slow_mm) / 0.7" }
        memory.tired = { start = "0", rate = "abs(v) - tired / 2" }
        acts.force_n = "a_n_mm * slow_mm + b_n_s_mm * v * tanh(tired)"

        [[effect]]
        id = "air_that_remembers"
        description = ""
        parameters.c_g_s_kpa = { range = [-1, 1], absent = 0 }
        memory.before_kpa = { start = "pf", rate = "(pf - before_kpa) / 0.3" }
        acts.air_flexor_g_s = "c_g_s_kpa * (pf - before_kpa)"
    "#;
    let effects = expression::parse(definitions).expect("it can be read");
    let trial = with_masses_of_the_gas_law();
    for (which, k, scale) in [(0, 0, 1.0), (0, 1, 1e-2), (1, 0, 1e-5)] {
        let effect = effects[which];
        let count = effect.info().parameters.len();
        let seeded: Vec<Derivatives> = (0..count).map(|k| Derivatives::variable(0.0, k)).collect();
        let with = run(&trial, effect, &seeded);
        // A kink of the network that lies within a change spoils that difference: the best one of four.
        let relative = [1e-2, 1e-3, 1e-4, 1e-5].map(|share| {
            let moved = |sign: f64| {
                let mut values = vec![0.0; count];
                values[k] = sign * share * scale;
                run(&trial, effect, &values)
            };
            let (up, down) = (moved(1.0), moved(-1.0));
            let (mut miss, mut size) = (0.0, 0.0);
            for (c, unit) in UNITS.into_iter().enumerate() {
                for (point, own) in with.channels[c].iter().enumerate() {
                    let change = up.channels[c][point] - down.channels[c][point];
                    let by_difference = change / (2.0 * share * scale);
                    miss += ((by_difference - own.derivatives[k]) / unit).powi(2);
                    size += (by_difference / unit).powi(2);
                }
            }
            (miss / size).sqrt()
        });
        let best = relative.into_iter().fold(f64::INFINITY, f64::min);
        assert!(best < 1e-6, "{} {k}: {relative:?}", effect.info().id);
    }
}

/// A spring between the pressure and a memory that begins at it and stays is one between the pressure and its first value.
#[test]
fn a_memory_may_begin_at_a_pressure() {
    let text = r#"
[[effect]]
id = "from_the_start"
description = "force that follows the change of a pressure"
parameters.c_n_kpa = { range = [0, 10], absent = 0 }
memory.first_kpa = { start = "pf + pe", rate = "0" }
acts.force_n = "-c_n_kpa * (pf + pe - first_kpa)"

[[effect]]
id = "from_a_number"
description = "the same with the number"
parameters.c_n_kpa = { range = [0, 10], absent = 0 }
parameters.first_kpa = { range = [0, 2000] }
acts.force_n = "-c_n_kpa * (pf + pe - first_kpa)"
"#;
    let effects = expression::parse(text).expect("definitions");
    let model = weights();
    let trial = Trial::new(&model, &exact_run(&model, [30.0, 60.0], 0.06));
    let with_memory = run(&trial, effects[0], &[2.0]);
    let first_kpa = with_memory.channels[2][0] + with_memory.channels[3][0];
    let with_number = run(&trial, effects[1], &[2.0, first_kpa]);
    let distance = |a: &Trajectory<f64>, b: &Trajectory<f64>| {
        let rows = a.channels[0].iter().zip(&b.channels[0]);
        rows.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let off = distance(&with_memory, &with_number);
    assert!(off < 1e-6, "{off:e}");
    let plain = run(&trial, effects[0], &[0.0]);
    assert!(distance(&with_memory, &plain) > 1e-3, "the force is felt");
}

#[test]
fn faults_of_a_file_are_named_with_line_and_column() {
    let file = |acts: &str| {
        format!(
            "[[effect]]\nid = \"mine\"\ndescription = \"\"\n\
             parameters.gain_n = {{ range = [0, 1], absent = 0 }}\n{acts}\n"
        )
    };
    let cases = [
        ("acts.force_n = \"gain_m * x\"", "line 5, column 17", "did you mean `gain_n`"),
        ("acts.force_n = \"gain_n * (x\"", "line 5, column 28", "`)` is expected"),
        ("acts.force_n = \"gain_n * tanhh(x)\"", "line 5, column 26", "did you mean `tanh`"),
        ("acts.force_m = \"gain_n\"", "line 5, column 6", "did you mean `force_n`"),
        ("acts.command_n = \"gain_n * x\"", "line 5, column 28", "there are force, t"),
        ("acts.force_n = \"gain_n * dx\"", "line 5, column 26", "`step` of a memory"),
        ("acts.inertia_kg = \"gain_n * x\"", "line 5, column 29", "the parameters alone"),
        ("acts.force_n = \"min(gain_n)\"", "line 5, column 17", "at least 2 arguments"),
        ("acts.force_n = \"\"\"\ngain_n *\n  y\"\"\"", "line 7, column 3", "no name `y`"),
        (
            "memory.q = { start = \"v\", rate = \"q\" }\nacts.force_n = \"q\"",
            "line 5, column 23",
            "`v` is not known at the beginning; there are x, pf, pe",
        ),
        (
            "memory.q = { start = \"x\" }\nacts.force_n = \"q\"",
            "line 5, column 8",
            "`rate` or `step`",
        ),
        ("acts.force_n = 3", "line 5, column 16", "string"),
    ];
    for (acts, place, words) in cases {
        let text = file(acts);
        let message = expression::parse(&text).expect_err(acts).to_string();
        assert!(message.contains(place) && message.contains(words), "{acts}: {message}");
    }
    let taken = file("acts.force_n = \"gain_n\"").replace("mine", "leak");
    let error = expression::parse(&taken).expect_err("a built-in id");
    assert!(matches!(&error, EffectError::File { message, .. } if message.contains("built-in")));
    // Each part is twice the one before: 2^60 operations if they were written out.
    let mut parts = String::from("let.a0 = \"x + x\"\n");
    for k in 1..60 {
        parts += &format!("let.a{k} = \"a{} + a{}\"\n", k - 1, k - 1);
    }
    let text = file(&format!("{parts}acts.force_n = \"a59\""));
    let message = expression::parse(&text).expect_err("exponential growth").to_string();
    assert!(message.contains("line 15, column") && message.contains("written out"), "{message}");
    let missing = expression::load("no/such/file.toml").expect_err("no file").to_string();
    assert!(missing.starts_with("no/such/file.toml: "), "{missing}");
}
