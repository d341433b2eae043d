//! The pulse servo and the valves, seen from the log and the truth.

use crate::common::{ideal, kpa};
use pam_rig::pneumatics::Opening;
use pam_rig::{Command, Frame, PressureCommand, Rig, RigParameters};

/// The servo's deadband, the sensor's step (150 psi over 80 % of 14 bits) and four of its deviations.
const REACHED_PSI: f64 = 0.5 + 150.0 / 13_107.2 + 4.0 * 0.008;

const SHUT: i8 = -1;
const INFLATES: i8 = 1;
const EXHAUSTS: i8 = 2;

fn run(rig: &mut Rig, pressure: PressureCommand, samples: usize) -> Vec<Frame> {
    (0..samples).map(|_| rig.tick(&Command { current_a: 0.0, pressure })).collect()
}

fn new() -> Rig {
    Rig::new(&RigParameters::default(), 3, 0.0).unwrap()
}

fn gauge_psi(frame: &Frame) -> [f64; 2] {
    frame.truth.pressures_kpa.map(|p| (p - 101.325) / 6.89476)
}

/// Lengths of the runs of equal commands to the valves of a muscle, with the command.
fn stretches(frames: &[Frame], muscle: usize) -> Vec<(i8, usize)> {
    let mut out: Vec<(i8, usize)> = Vec::new();
    for code in frames.iter().map(|f| f.row.valves[muscle]) {
        match out.last_mut() {
            Some((last, length)) if *last == code => *length += 1,
            _ => out.push((code, 1)),
        }
    }
    out
}

#[test]
fn targets_are_reached_and_held() {
    for targets in [[10.0, 80.0], [45.0, 45.0], [60.0, 30.0], [20.0, 70.0]] {
        let mut rig = new();
        let frames = run(&mut rig, PressureCommand::Servo(targets), 12_000);
        assert!(frames.iter().all(|f| f.row.commanded_psi == targets));
        for (i, target) in targets.into_iter().enumerate() {
            let off = |f: &Frame| (gauge_psi(f)[i] - target).abs();
            let first = frames.iter().position(|f| off(f) < 0.5).unwrap();
            assert!(first < 4000, "{targets:?}: {first} ms");
            // While the air takes the room's temperature again the servo corrects, and a pulse may be
            // too large for the deadband; the next one follows 30 ms later.
            let held = &frames[4000..];
            let out = held.iter().filter(|f| off(f) > REACHED_PSI).count();
            assert!(out < held.len() / 25, "{targets:?}: {out} of 8000 samples outside");
            assert!(held.iter().all(|f| off(f) < 1.5));
            let mut longest = 0;
            let mut since = 0;
            for frame in held {
                let rests = frame.row.valves[i] == SHUT && off(frame) <= REACHED_PSI;
                since = if rests { since + 1 } else { 0 };
                longest = longest.max(since);
                // The log lags; after half a second it says the same.
                if since > 500 {
                    assert!((frame.row.measured_psi[i] - target).abs() <= REACHED_PSI);
                }
            }
            assert!(longest > 1500, "{targets:?}: held for {longest} ms");
        }
    }
}

/// Section IV of the source: 10 ms inflate or 15 ms exhaust, then 20 ms of pause.
#[test]
fn pulses_have_the_published_lengths() {
    let mut rig = new();
    let mut frames = run(&mut rig, PressureCommand::Servo([70.0, 20.0]), 3000);
    frames.extend(run(&mut rig, PressureCommand::Servo([20.0, 70.0]), 3000));
    frames.extend(run(&mut rig, PressureCommand::Servo([70.0, 20.0]), 3000));
    for muscle in 0..2 {
        let all = stretches(&frames, muscle);
        let inner = &all[1..all.len() - 1];
        let count = |code| inner.iter().filter(|(c, _)| *c == code).count();
        assert!(count(INFLATES) > 20 && count(EXHAUSTS) > 20, "{all:?}");
        for (code, length) in inner {
            match *code {
                INFLATES => assert_eq!(*length, 10),
                EXHAUSTS => assert_eq!(*length, 15),
                _ => assert!(*code == SHUT && *length >= 20, "{code} for {length} ms"),
            }
        }
        assert!(all.windows(2).all(|w| w[0].0 == SHUT || w[1].0 == SHUT));
        // Far from the target the pauses are as short as they may be.
        assert!(inner.iter().filter(|(c, n)| *c == SHUT && *n == 20).count() > 40);
    }
}

/// Air moves only while a valve is open, which is 2 ms later than its command.
#[test]
fn air_flows_only_through_open_valves() {
    let mut rig = new();
    let frames = run(&mut rig, PressureCommand::Servo([50.0, 30.0]), 3000);
    let (mut moved, mut still) = (0, 0);
    for k in 2..frames.len() - 1 {
        for i in 0..2 {
            let change = frames[k + 1].truth.masses_g[i] - frames[k].truth.masses_g[i];
            match frames[k - 2].row.valves[i] {
                INFLATES => assert!(change > 0.0),
                EXHAUSTS => assert!(change < 0.0),
                _ => assert_eq!(change, 0.0),
            }
            moved += usize::from(change != 0.0);
            still += usize::from(change == 0.0);
        }
    }
    assert!(moved > 300 && still > 300, "{moved} {still}");
}

#[test]
fn sealed_valves_let_nothing_flow() {
    let mut rig = new();
    run(&mut rig, PressureCommand::Servo([50.0, 30.0]), 3000);
    // A pulse that was under way ends with the valves' response.
    run(&mut rig, PressureCommand::Sealed, 3);
    let sealed = run(&mut rig, PressureCommand::Sealed, 5000);
    let masses = sealed[0].truth.masses_g;
    assert!(masses[0] > 1.2 * masses[1] && masses[1] > 0.0);
    for frame in &sealed {
        assert_eq!(frame.truth.masses_g, masses);
        assert_eq!(frame.row.valves, [SHUT; 2]);
    }
}

/// ISO 6358: behind a choked orifice of C = 0.020 dm³/(s·bar) the mass grows by C ρ₀ p₁ √(T₀/T₁), with
/// the reference air of 1.185 g/dm³ at 293.15 K.
#[test]
fn an_empty_muscle_fills_with_the_choked_flow() {
    let mut rig = new();
    let frames = run(&mut rig, PressureCommand::Valves([Opening::Inflate, Opening::Shut]), 60);
    let mass = |k: usize| frames[k].truth.masses_g[0];
    let supply_bar = 1e-2 * kpa(96.7);
    let expected_g_s = 0.020 * 1.185 * supply_bar * (293.15_f64 / 295.15).sqrt();
    assert_eq!(mass(2), mass(0));
    let flow_g_s = (mass(22) - mass(2)) / 20e-3;
    assert!((flow_g_s / expected_g_s - 1.0).abs() < 2e-3, "{flow_g_s} of {expected_g_s} g/s");
}

/// However long the valves stay open.
#[test]
fn pressures_stay_between_room_and_supply() {
    for (openings, filled) in [
        ([Opening::Inflate, Opening::Exhaust], 0),
        ([Opening::Exhaust, Opening::Inflate], 1),
        ([Opening::Inflate; 2], 0),
        ([Opening::Exhaust; 2], 2),
    ] {
        let mut rig = new();
        rig.fill([kpa(40.0); 2]);
        let frames = run(&mut rig, PressureCommand::Valves(openings), 10_000);
        for frame in &frames {
            for pressure in frame.truth.pressures_kpa {
                assert!(pressure > 101.325 - 1e-3, "{pressure} kPa");
                assert!(pressure < kpa(96.7) + 1e-3, "{pressure} kPa");
            }
            assert!(frame.row.reservoir_psi < 96.7 + 1e-9);
        }
        let end = frames[9999].truth.pressures_kpa;
        for (i, opening) in openings.into_iter().enumerate() {
            let expected = if opening == Opening::Inflate { kpa(96.7) } else { 101.325 };
            assert!((end[i] - expected).abs() < 0.5, "{openings:?}: {end:?} kPa");
        }
        if filled < 2 {
            let lowest = frames.iter().map(|f| f.row.reservoir_psi).fold(f64::MAX, f64::min);
            assert!(lowest < 96.0, "filling takes nothing from the reservoir: {lowest} psi");
        }
    }
}

/// What the servo decides on is the sensor before its low-pass: with the filtered value it would run
/// past its target by what the pressure does in 50 ms.
#[test]
fn the_servo_does_not_wait_for_the_low_pass() {
    let valves = |cutoff_hz: f64| {
        let mut parameters = ideal(&[]);
        parameters.sensors.pressure.cutoff_hz = cutoff_hz;
        let mut rig = Rig::new(&parameters, 1, 0.0).unwrap();
        let frames = run(&mut rig, PressureCommand::Servo([45.0, 60.0]), 4000);
        frames.iter().map(|f| f.row.valves).collect::<Vec<_>>()
    };
    assert_eq!(valves(0.3), valves(0.0));
}
