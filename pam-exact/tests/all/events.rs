//! Crossings that are hard to find, on networks whose solution is known.

use pam_core::force::{Dense, Mlp};
use pam_core::{Activation, JointModel, NetworkForce, SealedMasses};
use pam_exact::{ExactMotion, ExactProblem, ExactSolver, ExactTrajectory, ForceSignal};
use pam_solvers::Interpolation;
use std::f64::consts::PI;

/// A joint whose force is `Σ gain · max(0, a x + b ẋ + c)` over units `[gain, a, b, c]`.
fn joint(units: &[[f64; 4]]) -> ExactMotion {
    let rows: Vec<f64> = units.iter().flat_map(|u| [0.0, 0.0, u[1], u[2]]).collect();
    let hidden = Dense::from_rows(&rows, units.iter().map(|u| u[3]).collect()).unwrap();
    let gains: Vec<f64> = units.iter().map(|u| u[0]).collect();
    let output = Dense::from_rows(&gains, vec![0.0]).unwrap();
    let relu = Activation::from_name("relu").unwrap();
    let force = NetworkForce::new(Mlp::new(vec![hidden, output], relu).unwrap()).unwrap();
    ExactMotion::new(&JointModel::datasheet(force)).unwrap()
}

fn spring(k: f64) -> [[f64; 4]; 2] {
    [[k, 1.0, 0.0, 0.0], [-k, -1.0, 0.0, 0.0]]
}

/// A free motion that is sampled at `times` only.
fn free<'a>(times: &'a [f64], zeros: &'a [f64], y0: [f64; 2]) -> ExactProblem<'a> {
    ExactProblem {
        masses: SealedMasses { flexor_g: 0.08, extensor_g: 0.08 },
        signal: ForceSignal { times_s: times, force_mn: zeros, interpolation: Interpolation::Hold },
        t0: 0.0,
        t1: times[times.len() - 1],
        y0,
        observe_s: times,
    }
}

fn every(step_s: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|k| k as f64 * step_s).collect()
}

/// Two half springs: every half period is known, and with samples far apart many crossings lie between
/// two of them.
#[test]
fn repeated_crossings_between_samples() {
    let (soft, stiff) = (100e3, 400e3);
    let motion = joint(&[[soft, 1.0, 0.0, 0.0], [-stiff, -1.0, 0.0, 0.0]]);
    let omega = [soft, stiff].map(|k| (k / motion.mass_kg).sqrt());
    let halves = omega.map(|w| PI / w);
    let period = halves[0] + halves[1];
    // x of a motion that leaves zero upwards with velocity 10 mm/s.
    let x = |t: f64| {
        let t = t % period;
        if t < halves[0] {
            10.0 / omega[0] * (omega[0] * t).sin()
        } else {
            -10.0 / omega[1] * (omega[1] * (t - halves[0])).sin()
        }
    };
    for step_s in [0.7, 0.033, 1e-3] {
        let count = (20.0 * period / step_s) as usize;
        let times = every(step_s, count);
        let zeros = vec![0.0; times.len()];
        let problem = free(&times, &zeros, [0.0, 10.0]);
        let trajectory = ExactTrajectory::new(&motion, &problem).unwrap();
        let end = times[count];
        for k in 0..1000 {
            let t = end * f64::from(k) / 999.0;
            let [found, _, acceleration] = trajectory.at(t.min(end)).unwrap();
            assert!((found - x(t)).abs() < 1e-11, "{t} s: {found} {}", x(t));
            let k = if found > 0.0 { soft } else { stiff };
            assert!((acceleration + k * found / motion.mass_kg).abs() < 1e-7);
        }
        // Both units change at each passage through zero after the start.
        let passages = (0..).map(|n| {
            let whole = f64::from(n / 2) * period;
            if n % 2 == 0 { whole } else { whole + halves[0] }
        });
        let passages: Vec<f64> = passages.skip(1).take_while(|t| *t < end).collect();
        let crossings = trajectory.crossings();
        let at_start = crossings.iter().filter(|c| c.time_s == 0.0).count();
        assert_eq!(crossings.len() - at_start, 2 * passages.len(), "step {step_s}");
        for (pair, passage) in crossings[at_start..].chunks_exact(2).zip(&passages) {
            for c in pair {
                assert!((c.time_s - passage).abs() < 1e-12, "{} {passage}", c.time_s);
                assert!(c.state[0].abs() < 1e-11 && c.layer == 0);
                assert_eq!(c.activates, (c.unit == 0) == (c.state[1] > 0.0));
            }
        }
        assert!(trajectory.at(end + 1e-9).is_none() && trajectory.at(-1e-9).is_none());
    }
}

/// An oscillation that reaches past a border by a depth, and stays before it by as much: two crossings
/// close together in the first case at any depth above rounding, none in the second.
#[test]
fn grazing_crossings() {
    let omega = |motion: &ExactMotion| (150e3 / motion.mass_kg).sqrt();
    for depth in [1e-2, 1e-5, 1e-8, 1e-11] {
        for (border, expected) in [(1.0 - depth, 2), (1.0 + depth, 0)] {
            let mut units = spring(150e3).to_vec();
            units.push([500e3, 1.0, 0.0, -border]);
            let motion = joint(&units);
            // From below: x = −cos ωt reaches one after half a period, which one step covers.
            let half = PI / omega(&motion);
            for parts in [1, 7] {
                let times = every(1.5 * half / f64::from(parts), parts as usize);
                let zeros = vec![0.0; times.len()];
                let problem = free(&times, &zeros, [-1.0, 0.0]);
                let trajectory = ExactTrajectory::new(&motion, &problem).unwrap();
                let touched: Vec<_> =
                    trajectory.crossings().into_iter().filter(|c| c.unit == 2).collect();
                assert_eq!(touched.len(), expected, "depth {depth}, {parts} parts");
                if let [first, second] = touched[..] {
                    assert!(first.activates && !second.activates);
                    // cos ωt = −border, the second by the stiffer spring's symmetry at the same speed.
                    let expected = (-border).acos() / omega(&motion);
                    assert!(
                        (first.time_s - expected).abs() < 2e-16 / (depth.sqrt() * depth.sqrt())
                    );
                    assert!((first.state[1] + second.state[1]).abs() < 1e-6);
                }
                // Where the border lies hardly matters: the solution is continuous in it.
                let x = trajectory.at(0.9 * half).unwrap()[0];
                let free = -(0.9 * PI).cos();
                assert!((x - free).abs() < 1e-12 || border < free);
            }
        }
    }
}

/// Borders that meet on the way of the motion, and one border shared by several units.
#[test]
fn simultaneous_crossings() {
    let k = 150e3;
    let omega = (k / joint(&spring(k)).mass_kg).sqrt();
    let times = every(0.05, 40);
    let zeros = vec![0.0; times.len()];
    let solve = |shift: f64| {
        let mut units = spring(k).to_vec();
        // Through (0, −ω), where x = cos ωt passes first: two lines that cross there, and copies.
        for (gain, a, b) in [(40e3, 1.0, 0.02), (-30e3, 1.0, -0.03), (10e3, 2.0, 0.04)] {
            units.push([gain, a, b, b * omega + shift]);
        }
        let motion = joint(&units);
        let mut solver = ExactSolver::new();
        let problem = free(&times, &zeros, [1.0, 0.0]);
        assert!(solver.solve(&motion, &[problem]).is_empty());
        (solver.observed(0).to_vec(), solver.statistics(0).crossings)
    };
    let (together, crossings) = solve(0.0);
    assert!(crossings >= 10);
    for shift in [1e-6, -1e-6, 1e-9, -1e-9, 1e-12] {
        let (apart, _) = solve(shift);
        let off = together.iter().zip(&apart).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e4 * shift.abs() + 1e-12, "shift {shift}: {off:e}");
    }
}

/// A motion that starts on a border, along it, and one that stays on it.
#[test]
fn motions_on_a_border() {
    let k = 150e3;
    let mut units = spring(k).to_vec();
    // ẋ = 0 is a border: the force has a damper on one side only.
    units.push([3e3, 0.0, 1.0, 0.0]);
    let motion = joint(&units);
    let times = every(0.01, 100);
    let zeros = vec![0.0; times.len()];
    let rest = ExactTrajectory::new(&motion, &free(&times, &zeros, [0.0, 0.0])).unwrap();
    assert_eq!(rest.at(0.77).unwrap()[..2], [0.0, 0.0], "rest stays rest");
    // From rest at 1 mm the velocity is negative at once: undamped to the other side.
    let swing = ExactTrajectory::new(&motion, &free(&times, &zeros, [1.0, 0.0])).unwrap();
    let omega = (k / motion.mass_kg).sqrt();
    let t = 0.8 * PI / omega;
    assert!((swing.at(t).unwrap()[0] - (omega * t).cos()).abs() < 1e-12);
}
