use crate::common::{diagnosis, model};
use pam_experiment::design::{
    DesignLimits, DesignOptions, LiveCause, Objective, commands_csv, design,
};
use pam_experiment::detect::DetectOptions;
use pam_experiment::plan::planned_runs;
use pam_rig::Protocol;
use pam_rig::sensors::{MotorParameters, SensorParameters};

fn options(objective: Objective, ids: &[&str]) -> DesignOptions {
    let mut sensors = SensorParameters::default();
    sensors.clock.rate_hz = 250.0;
    DesignOptions {
        detect: DetectOptions { diagnosis: diagnosis(ids), ..DetectOptions::default() },
        limits: DesignLimits {
            seconds: 6.0,
            recordings: 2,
            current_a: 1.2,
            ..DesignLimits::default()
        },
        objective,
        sensors,
        evaluations: 32,
        ..DesignOptions::default()
    }
}

/// A design stays within its limits, is a protocol file of the rig, does not depend on the number of threads, and is no worse than
/// the excitation with which it began.
#[test]
fn a_design_keeps_its_limits_and_repeats() {
    let ids = ["viscous_damping", "added_inertia", "coulomb_friction"];
    let options = options(Objective::MedianLimit, &ids);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| design(&model(), &options, &|_| {}).expect("a design"))
    };
    let designed = run(2);
    assert_eq!(designed.protocol, run(1).protocol);
    assert!(designed.median_factor > 1.0, "{}", designed.median_factor);
    let protocol = &designed.protocol;
    assert_eq!(Protocol::parse(&protocol.to_toml(), "design.toml").expect("a file"), *protocol);
    assert!((protocol.duration_s() - 6.0).abs() < 0.01);
    assert_eq!(protocol.runs().expect("runs").len(), 2);
    let commands = commands_csv(protocol, &MotorParameters::default(), 250.0, 1).expect("commands");
    assert_eq!(commands.len(), 2);
    for (_, text) in &commands {
        let currents = text.lines().skip(1).map(|l| l.split(',').nth(1).expect("a column"));
        let largest =
            currents.map(|c| c.parse::<f64>().expect("a number").abs()).fold(0.0, f64::max);
        assert!(largest <= 1.2 + 2e-3, "{largest} A");
    }
}

/// A design that is to stay where a model was trained moves no faster than allowed and holds no current for longer.
#[test]
fn a_design_keeps_within_the_motion_of_its_model() {
    let mut options = options(Objective::MedianLimit, &["viscous_damping", "stiffness_scale"]);
    let (speed_mm_s, hold_s) = (12.0, 0.4);
    options.limits = DesignLimits { speed_mm_s, hold_s, ..options.limits };
    let designed = design(&model(), &options, &|_| {}).expect("a design");
    let runs = planned_runs(&designed.protocol, &options.sensors.motor, 250.0, options.seed);
    for run in runs.expect("runs") {
        let simulated = run.simulated(&model()).expect("a simulation").recording;
        let fastest = simulated.velocity_mm_s.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
        assert!(fastest <= speed_mm_s, "{fastest} mm/s");
        let (mut held, mut longest) = (0, 0);
        for pair in run.force_mn.windows(2) {
            held = if pair[0] == pair[1] { held + 1 } else { 0 };
            longest = longest.max(held);
        }
        assert!(f64::from(longest) / 250.0 <= hold_s + 0.01, "{longest} samples");
    }
}

/// Damping and inertia look alike at one frequency; a design has to distinguish them at least as well as what it began with.
#[test]
fn a_design_separates_live_causes() {
    let ids = ["viscous_damping", "actuation_delay"];
    let live = LiveCause { cause: (0, vec![60.0]), others: vec![(1, vec![0.5])] };
    let options = options(Objective::Separation(vec![live]), &ids);
    let designed = design(&model(), &options, &|_| {}).expect("a design");
    let [pair] = &designed.separations[..] else { panic!("one pair") };
    assert!(pair.designed >= pair.standard, "{pair:?}");
    assert_eq!(designed.separates(), Some(pair.designed >= 1.0));
}

/// A live cause without all of its values, or that is no candidate, is an error that says so.
#[test]
fn live_causes_have_all_values() {
    let ids = ["polytropic_gas", "actuation_delay"];
    for (place, values, what) in [(0, vec![1.1], "polytropic_gas"), (7, vec![1.0], "7")] {
        let live = LiveCause { cause: (place, values), others: Vec::new() };
        let options = options(Objective::Separation(vec![live]), &ids);
        let error = design(&model(), &options, &|_| {}).expect_err("a wrong cause").to_string();
        assert!(error.contains(what), "{error}");
    }
}
