//! Mass, heat and work of the air behind closed valves.

use crate::common::{kpa, plain, sealed, sine, springs};
use approx::assert_relative_eq;
use pam_rig::plant::{HeatExchange, Plant, PlantParameters};
use pam_rig::truth::TruthRow;
use pam_rig::{Command, PressureCommand, Rig, RigParameters};
use std::f64::consts::TAU;

const EXCHANGES: [HeatExchange; 3] =
    [HeatExchange::Isothermal, HeatExchange::Adiabatic, HeatExchange::Conduction { scale: 0.55 }];

/// Work of the air of each muscle from truth rows alone, µJ.
fn trapezoids_uj(before: &TruthRow, after: &TruthRow) -> [f64; 2] {
    [0, 1].map(|i| {
        0.5 * (before.pressures_kpa[i] + after.pressures_kpa[i])
            * (after.volumes_mm3[i] - before.volumes_mm3[i])
    })
}

/// ΔU = −W − Q + H, and W is what pressures and volumes of the truth say.
#[test]
fn the_ledger_of_each_chamber_closes() {
    for exchange in EXCHANGES {
        let mut parameters = RigParameters::default();
        parameters.plant.heat = exchange;
        let mut rig = Rig::new(&parameters, 1, 0.0).unwrap();
        rig.fill([kpa(30.0), kpa(60.0)]);
        let chambers = |rig: &Rig| [0, 1].map(|i| rig.plant().muscles()[i].air);
        let start = chambers(&rig);
        let (mut work_uj, mut most_uj, mut off_uj) = ([0.0; 2], [0.0_f64; 2], [0.0_f64; 2]);
        let mut last: Option<TruthRow> = None;
        for k in 0..4000 {
            let t = f64::from(k) * 1e-3;
            let current_a = sine(1.0, 0.5)(t) + sine(0.5, 3.0)(t);
            let ledgers = chambers(&rig).map(|air| air.ledger);
            let now = rig.tick(&Command { current_a, pressure: PressureCommand::Sealed }).truth;
            if let Some(last) = last {
                let piece = trapezoids_uj(&last, &now);
                for i in 0..2 {
                    work_uj[i] += piece[i];
                    most_uj[i] = most_uj[i].max(work_uj[i].abs());
                    off_uj[i] = off_uj[i].max((work_uj[i] - ledgers[i].work_uj).abs());
                }
            }
            last = Some(now);
        }
        for (i, (air, start)) in chambers(&rig).iter().zip(start).enumerate() {
            let l = air.ledger;
            assert_eq!(l.enthalpy_uj, 0.0);
            let change = air.energy_uj() - start.energy_uj();
            let balance = change + l.work_uj + l.heat_uj;
            assert!(balance.abs() < 1e-9 * start.energy_uj(), "{exchange:?}: {balance} µJ");
            assert!(off_uj[i] < 3e-6 * most_uj[i], "{exchange:?}: {off_uj:?} of {most_uj:?}");
            match exchange {
                HeatExchange::Isothermal => assert_eq!(change, 0.0),
                HeatExchange::Adiabatic => assert_eq!(l.heat_uj, 0.0),
                HeatExchange::Conduction { .. } => assert!(change != 0.0 && l.heat_uj != 0.0),
            }
        }
    }
}

#[test]
fn sealed_air_stays_in_its_chamber() {
    let frames = sealed(&RigParameters::default(), [20.0, 70.0], 30.0, |t| {
        sine(1.5, 0.5)(t) + sine(0.5, 7.0)(t)
    });
    let start = frames[0].truth.masses_g;
    for frame in &frames {
        for (mass, start) in frame.truth.masses_g.into_iter().zip(start) {
            assert_relative_eq!(mass, start, max_relative = 1e-12);
        }
    }
    let x = || frames.iter().map(|f| f.truth.displacement_mm);
    assert!(x().fold(f64::MIN, f64::max) - x().fold(f64::MAX, f64::min) > 2.0);
}

/// Largest relative change of `P Vⁿ` of both chambers in a motion.
fn polytropic_spread(rows: impl Iterator<Item = TruthRow>, exponent: f64) -> f64 {
    let constant =
        |r: &TruthRow| [0, 1].map(|i| r.pressures_kpa[i] * r.volumes_mm3[i].powf(exponent));
    let mut rows = rows.peekable();
    let start = constant(rows.peek().unwrap());
    rows.map(|r| [0, 1].map(|i| (constant(&r)[i] / start[i] - 1.0).abs()))
        .fold(0.0, |most, [f, e]| most.max(f).max(e))
}

#[test]
fn isothermal_air_keeps_p_v_and_adiabatic_air_p_v_to_the_1_4() {
    for (heat, exponent) in [(HeatExchange::Isothermal, 1.0), (HeatExchange::Adiabatic, 1.4)] {
        let mut parameters = plain(&[]);
        parameters.plant.heat = heat;
        let rows =
            || sealed(&parameters, [30.0, 60.0], 3.0, sine(1.5, 1.0)).into_iter().map(|f| f.truth);
        assert!(polytropic_spread(rows(), exponent) < 1e-11);
        // The other law is off by what the volumes allow.
        assert!(polytropic_spread(rows(), 2.4 - exponent) > 5e-3);
    }
}

/// A joint that is dragged through a sine of 1.5 mm for some cycles; truth a hundred times a cycle.
fn dragged(parameters: &PlantParameters, frequency_hz: f64, cycles: usize) -> Vec<TruthRow> {
    const STEPS: usize = 4000;
    let mut plant = Plant::new(parameters, Default::default(), &[]);
    plant.fill([kpa(45.0); 2]);
    (0..cycles * STEPS)
        .map(|k| {
            let (sine, cosine) = (TAU * k as f64 / STEPS as f64).sin_cos();
            let rate = 1.5 * TAU * frequency_hz * cosine;
            plant.drag(1.5 * sine, rate, 1.0 / (frequency_hz * STEPS as f64));
            TruthRow::of(&plant)
        })
        .collect()
}

/// Conduction lies between the two limits and reaches them.
#[test]
fn slow_motion_is_isothermal_and_fast_motion_adiabatic() {
    let joint = PlantParameters { heat: HeatExchange::Conduction { scale: 1.0 }, ..springs() };
    let spread = |frequency_hz: f64, exponent: f64| {
        polytropic_spread(dragged(&joint, frequency_hz, 1).into_iter(), exponent)
    };
    assert!(spread(1e-4, 1.0) < 1e-4);
    assert!(spread(1e3, 1.4) < 1e-4);
    // Between them neither law holds.
    assert!(spread(0.2, 1.0) > 5e-3 && spread(0.2, 1.4) > 5e-3);
}

/// Heat that lags behind the motion costs work in every cycle, most where the period matches the time
/// constant of the conduction (0.8 s, 2π · 0.2 Hz).
#[test]
fn a_cycle_of_compression_costs_work() {
    let joint = PlantParameters { heat: HeatExchange::Conduction { scale: 1.0 }, ..springs() };
    let cost_uj = |frequency_hz: f64| {
        let rows = dragged(&joint, frequency_hz, 21);
        let last = &rows[rows.len() - 4001..];
        -last.windows(2).map(|w| trapezoids_uj(&w[0], &w[1])[0]).sum::<f64>()
    };
    let [slow, medium, fast] = [0.002, 0.2, 20.0].map(cost_uj);
    assert!(slow > 0.0 && fast > 0.0);
    assert!(medium > 5.0 * slow && medium > 5.0 * fast);
}
