//! Effects of a file in the rig, against its own effects, which are other code.

use crate::common::{plain, sealed, sine};
use pam_rig::effects::expression;
use pam_rig::plant::DryFriction;
use pam_rig::{Frame, RigParameters};
use std::path::Path;

const FILE: &str = r#"
[[effect]]
id = "e_viscous"
description = ""
parameters.coefficient_ns_m = { range = [0, 1e5], absent = 0 }
acts.force_n = "-coefficient_ns_m * v / 1000"

[[effect]]
id = "e_coulomb"
description = ""
parameters.force_n = { range = [0, 1000], absent = 0 }
acts.dry_friction_n = "force_n"

[[effect]]
id = "e_creep"
description = ""
parameters.stiffness_n_mm = { range = [0, 1000], absent = 0 }
parameters.time_constant_s = { range = [0.02, 1000], log = true }
memory.q = { start = "x", rate = "(x - q) / time_constant_s" }
acts.force_n = "-stiffness_n_mm * (x - q)"

[[effect]]
id = "e_drift"
description = ""
parameters.relative_per_min = { range = [-0.9, 10], absent = 0 }
acts.force_factor = "1 + relative_per_min * t / 60"

[[effect]]
id = "e_gain"
description = ""
parameters.relative = { range = [-0.9, 5], absent = 0 }
acts.command_n = "force * (1 + relative)"

[[effect]]
id = "e_lag"
description = ""
parameters.cutoff_hz = { range = [0.05, 200], log = true }
memory.real_n = { start = "force", rate = "2 * pi * cutoff_hz * (force - real_n)" }
acts.command_n = "real_n"

[[effect]]
id = "e_delay"
description = ""
parameters.delay_ms = { range = [0, 500], absent = 0 }
acts.position_delay_s = "delay_ms / 1000"

[[effect]]
id = "e_play"
description = ""
parameters.gap_mm = { range = [0, 20], absent = 0 }
memory.encoder_mm = { start = "x", step = "clamp(encoder_mm, x - gap_mm / 2, x + gap_mm / 2)" }
acts.position_mm = "encoder_mm"

[[effect]]
id = "e_gas"
description = ""
parameters.exponent = { range = [0.5, 2], absent = 1 }
acts.gas_exponent = "exponent"

[[effect]]
id = "e_sag"
description = ""
parameters.kpa_per_n = { range = [0, 1], absent = 0 }
acts.pressure_flexor_kpa = "pf - kpa_per_n * abs(force)"

[[effect]]
id = "e_inertia"
description = ""
parameters.mass_kg = { range = [-150, 5000], absent = 0 }
acts.inertia_kg = "mass_kg"
"#;

fn run(effect: &str) -> Vec<Frame> {
    let mut parameters = plain(&[effect]);
    parameters.plant.viscous_ns_m = 6e3;
    parameters.plant.friction = DryFriction::coulomb(5.0);
    sealed(&parameters, [30.0, 60.0], 2.0, sine(1.5, 1.0))
}

/// What the log and the truth show, each in its variation: mm, kPa, kPa, mm.
fn distance(a: &[Frame], b: &[Frame]) -> f64 {
    let shown = |f: &Frame| {
        let [pf, pe] = f.truth.pressures_kpa;
        [f.truth.displacement_mm, pf / 20.0, pe / 20.0, f.row.angle_deg / 8.0]
    };
    let pairs = a.iter().zip(b).flat_map(|(a, b)| {
        let (a, b) = (shown(a), shown(b));
        (0..4).map(move |k| (a[k] - b[k]).abs())
    });
    pairs.fold(0.0, f64::max)
}

#[test]
fn a_file_hides_what_the_rigs_own_effects_hide() {
    expression::read(FILE).expect("it can be read");
    let crosstalk =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/effects/chamber_crosstalk.toml");
    expression::load(crosstalk).expect("it can be read");
    let cases = [
        ("e_viscous:coefficient_ns_m=3000", "viscous_damping:coefficient_ns_m=3000"),
        ("e_coulomb:force_n=20", "coulomb_friction:force_n=20"),
        (
            "e_creep:stiffness_n_mm=30,time_constant_s=0.3",
            "creep:stiffness_n_mm=30,time_constant_s=0.3",
        ),
        ("e_drift:relative_per_min=5", "stiffness_drift:relative_per_min=5"),
        ("e_gain:relative=0.1", "force_gain:relative=0.1"),
        ("e_lag:cutoff_hz=4", "actuator_lag:cutoff_hz=4"),
        ("e_delay:delay_ms=13.5", "position_delay:delay_ms=13.5"),
        ("e_play:gap_mm=0.2", "backlash:gap_mm=0.2"),
        ("e_gas:exponent=1.3", "polytropic_gas:exponent=1.3"),
        ("e_inertia:mass_kg=60", "added_inertia:mass_kg=60"),
        ("air_crosstalk:rate_per_s=0.1", "chamber_crosstalk:rate_per_s=0.1"),
    ];
    let nothing = run("coulomb_friction:force_n=0");
    for (own, known) in cases {
        let (own_run, known_run) = (run(own), run(known));
        let (off, effect) = (distance(&own_run, &known_run), distance(&known_run, &nothing));
        assert!(effect > 1e-2, "{known} does something: {effect}");
        assert!(off < 2e-3 * effect, "{own}: {off} of {effect}");
    }
}

#[test]
fn a_sensor_may_feel_the_drive() {
    expression::read(FILE).expect("it can be read");
    let (plain, sagging) = (run("coulomb_friction:force_n=0"), run("e_sag:kpa_per_n=0.5"));
    let strongest = plain.iter().map(|f| f.truth.force_n.abs()).fold(0.0, f64::max);
    assert!(strongest > 20.0, "the motor pushes with {strongest} N");
    let kpa = |f: &Frame| 6.894_757 * f.row.measured_psi[0];
    // A sample is read before the step that its force drives: the drive of the sample before is felt.
    for (k, (a, b)) in plain.iter().zip(&sagging).enumerate().skip(1) {
        assert_eq!(a.truth.displacement_mm, b.truth.displacement_mm);
        let sag = 0.5 * plain[k - 1].truth.force_n.abs();
        assert!((kpa(a) - kpa(b) - sag).abs() < 1.0, "{k}: {} {} {sag}", kpa(a), kpa(b));
    }
}

/// The settings of a rig hold the definition, so that they are read where the file is not.
#[test]
fn settings_of_a_rig_carry_the_definition() {
    expression::read(FILE).expect("it can be read");
    let parameters = plain(&["e_play:gap_mm=0.2"]);
    let text = parameters.to_toml();
    assert!(text.contains("clamp(encoder_mm"), "{text}");
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rig.toml");
    std::fs::write(&path, text.replace("e_play", "e_play_elsewhere")).expect("written");
    let back = RigParameters::read(&path).expect("it brings its definition");
    assert_eq!(back.effects[0].id(), "e_play_elsewhere");
    assert_eq!(back.effects[0].values(), [0.2]);
}

#[test]
fn faults_of_an_effect_in_the_rig_are_named() {
    let wrong = FILE.replace("(x - q) /", "(x - w) /");
    let message = expression::read(&wrong).expect_err("there is no w");
    assert!(message.starts_with("line 19, column 40: there is no name `w`"), "{message}");
    let other = FILE.replace("gap_mm / 2", "gap_mm / 3");
    expression::read(FILE).expect("it can be read");
    assert!(expression::read(&other).expect_err("taken").contains("another id"));
    for (text, word) in [
        ("e_creep:stiffness_n_mm=1", "time_constant_s"),
        ("e_creep", "stiffness_n_mm"),
        ("e_gain:relative=9", "outside"),
        ("e_gain:share=0.1", "relative"),
    ] {
        let message = text.parse::<pam_rig::Effect>().expect_err(text).to_string();
        assert!(message.contains(word), "{text}: {message}");
    }
}
