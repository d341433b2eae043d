//! The simulation against an adaptive solver of fifth order, with the published network.

use crate::support::joint::DT;
use crate::support::published::{exact, run_with, weights};
use pam_core::{ForceInput, ForceModel, JointModel, SealedMasses};
use pam_effects::effects::by_id;
use pam_effects::expression;
use pam_effects::simulation::{Base, ForceTable, Nuisances, Trajectory, Trial, simulate};
use pam_solvers::Interpolation;
use pam_trajectory::SolverSettings;

/// Table, averaged force and steps of 4 ms together leave less than 3 µm of ±2 mm; 5 µm where one muscle has
/// eight times the pressure of the other, and the network bends most.
#[test]
fn the_simulation_follows_an_exact_solver() {
    let model = weights();
    let held = (Interpolation::Hold, 0.0);
    let smooth = (Interpolation::Linear, 0.5);
    for (psi, (interpolation, lead_samples), most) in [
        ([45.0, 45.0], held, 3e-3),
        ([45.0, 45.0], smooth, 3e-3),
        ([30.0, 60.0], held, 3e-3),
        ([10.0, 80.0], held, 5e-3),
    ] {
        let settings = SolverSettings { interpolation, ..exact() };
        let subject = run_with(&model, psi, 0.2, &settings);
        let trial = Trial::new(&model, &subject);
        let nuisances = Nuisances { lead_samples, ..Nuisances::none() };
        let mut out = Trajectory::default();
        simulate::<f64>(&trial, &Base::of(&model), &[], &[], &nuisances, &mut out)
            .expect("in range");
        let r = &subject.recording;
        let every = (trial.record.step_s / DT).round() as usize;
        let worst = |ours: &[f64], exact: &[f64]| {
            ours.iter().enumerate().map(|(k, a)| (a - exact[k * every]).abs()).fold(0.0, f64::max)
        };
        let x = worst(&out.channels[0], &r.displacement_mm);
        let v = worst(&out.channels[1], &r.velocity_mm_s);
        let p = worst(&out.channels[2], &r.pressure_flexor_kpa);
        let pairs = out.channels[0].iter().enumerate();
        let pairs: Vec<[f64; 2]> = pairs.map(|(k, a)| [*a, r.displacement_mm[k * every]]).collect();
        let gain = slope(&pairs);
        println!("{psi:?}: {x:.5} mm, {v:.4} mm/s, {p:.4} kPa, gain {gain:.6}");
        // A diagnosis of a minute sees a change of the stiffness of 5e-4.
        assert!((gain - 1.0).abs() < 2e-4, "{psi:?}: gain {gain}");
        assert!(x < most, "{psi:?}: {x} mm");
        // One slope of the pressure is 15 kPa/mm.
        assert!(v < 0.3 && p < 0.05, "{psi:?}: {v} mm/s, {p} kPa");
    }
}

/// The slope of the first of two columns along the second.
fn slope(pairs: &[[f64; 2]]) -> f64 {
    let n = pairs.len() as f64;
    let mean = |c: usize| pairs.iter().map(|p| p[c]).sum::<f64>() / n;
    let (a, b) = (mean(0), mean(1));
    let products = pairs.iter().map(|p| (p[0] - a) * (p[1] - b)).sum::<f64>();
    products / pairs.iter().map(|p| (p[1] - b).powi(2)).sum::<f64>()
}

/// `f = c x² + d ẋ²`.
struct Parabola;

impl ForceModel<f64> for Parabola {
    fn restoring_force_mn(&self, input: &ForceInput<f64>, _: &mut [f64]) -> f64 {
        300.0 * input.displacement_mm.powi(2) + 2.0 * input.velocity_mm_s.powi(2)
    }
}

/// Bilinear interpolation between values at the nodes would be above a parabola everywhere: by h²/12 of its second derivatives on the
/// average. The table is not.
#[test]
fn a_table_of_a_parabola_has_no_bias() {
    let joint = JointModel::datasheet(Parabola);
    let masses = SealedMasses { flexor_g: 0.08, extensor_g: 0.08 };
    let table = ForceTable::new(&joint, masses, [-2.0, 2.0], [-20.0, 20.0]);
    let inner = |share: f64, reach: f64| (2.0 * share - 1.0) * reach;
    let mut errors = Vec::new();
    for i in 0..700 {
        for j in 0..700 {
            let (a, b) = ((f64::from(i) + 0.5) / 700.0, (f64::from(j) + 0.5) / 700.0);
            // Whole cells, away from the edges.
            let (x, v) = (inner(a, 1.8), inner(b, 19.0));
            let exact = 300.0 * x * x + 2.0 * v * v;
            errors.push(table.force_mn(x, v, [0.0; 2]) - exact);
        }
    }
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    // h² f''/12 of both directions: 0.5 mN and 0.02 mN.
    assert!(mean.abs() < 5e-3, "{mean} mN");
    assert!(errors.iter().all(|e| e.abs() < 1.2));
}

/// A part of a recording starts from the measured state in the middle of the motion, and follows the exact motion as the whole
/// does. A start that is taken from elsewhere is off by a part of the amplitude of 2 mm.
#[test]
fn a_part_of_a_recording_moves_as_the_whole() {
    let model = weights();
    let subject = run_with(&model, [45.0, 45.0], 0.2, &exact());
    let whole = Trial::new(&model, &subject);
    let points = whole.record.points();
    let range = points / 3..points - points / 5;
    let part = whole.part(range.clone());
    assert_eq!(part.record.points(), range.len());
    assert_eq!(part.record.since_start_s, whole.record.step_s * range.start as f64);
    let mut out = Trajectory::default();
    simulate::<f64>(&part, &Base::of(&model), &[], &[], &Nuisances::none(), &mut out)
        .expect("in range");
    let every = (whole.record.step_s / DT).round() as usize;
    let exact = |k: usize| subject.recording.displacement_mm[(range.start + k) * every];
    let off = |k: usize| (out.channels[0][k] - exact(k)).abs();
    let worst = (0..range.len()).map(off).fold(0.0, f64::max);
    println!("{worst:.5} mm");
    // Means over 4 ms start the part: at 12 mm/s, 2 ms are 24 µm, which die away.
    assert!(off(0) < 0.03 && (250..range.len()).all(|k| off(k) < 3e-3), "{worst} mm");
    assert!(exact(0).abs() > 0.1, "the joint moves where the part begins");
}

/// Damping that grows with the square of the speed of the last seconds, and a pressure sensor that drifts with it.
const WARMING: &str = r#"
[[effect]]
id = "warming_damping"
description = "damping that grows with the work of the last seconds"
parameters.c = { range = [0, 1], absent = 0, start = [0.02] }
memory.z = { start = "0", rate = "(v^2 - z) / 4" }
acts.force_n = "-c * z * v"

[[effect]]
id = "warming_sensor"
description = "reading that grows with the work of the last seconds"
parameters.c = { range = [0, 1], absent = 0, start = [0.02] }
memory.z = { start = "0", rate = "(v^2 - z) / 4" }
acts.pressure_flexor_kpa = "pf + c * z"
"#;

/// A part begins with what the motion before it has left: a damping and a sensor that have warmed, and air that has leaked. Without that
/// it misses the changes of the whole by much more.
#[test]
fn a_part_of_a_recording_remembers_the_motion_before_it() {
    let model = weights();
    let subject = run_with(&model, [45.0, 45.0], 0.2, &exact());
    let warming = expression::parse(WARMING).expect("definitions");
    let leak = by_id("leak").expect("an id");
    // Displacement in mm, pressure in kPa.
    let cases = [
        (warming[0], &[0.02][..], 0, 1e-3),
        (warming[1], &[0.1][..], 2, 0.05),
        (leak, &[3e-3, 1e-3][..], 0, 1e-3),
    ];
    for (effect, values, channel, most) in cases {
        let mut whole = Trial::new(&model, &subject);
        let motion = |trial: &Trial| {
            let mut out = Trajectory::default();
            let base = Base::of(&model);
            simulate::<f64>(trial, &base, &[effect], values, &Nuisances::none(), &mut out)
                .expect("in range");
            out.channels
        };
        let moved = motion(&whole);
        whole.record.measured = moved.clone();
        let points = whole.record.points();
        let range = points / 2..points - 20;
        let part = whole.part(range.clone());
        let mut forgetful = part.clone();
        forgetful.record.before = None;
        let [with, without] = [part, forgetful].map(|trial| {
            let own = motion(&trial);
            (0..range.len())
                .map(|k| own[channel][k] - moved[channel][range.start + k])
                .map(|off| (off - own[channel][0] + moved[channel][range.start]).abs())
                .fold(0.0, f64::max)
        });
        println!("{}: {with:.6}, without memory {without:.6}", effect.info().id);
        assert!(with < most && without > 20.0 * with, "{}: {with} {without}", effect.info().id);
    }
}
