//! Effects in the gas, on the truth of pressures, volumes and masses.

use crate::common::{ideal, kpa, largest, line, plain, sealed, sine};
use pam_rig::Frame;
use pam_rig::plant::{HeatExchange, Muscle, MuscleParameters};

/// The volume of a plain muscle at each sample, mm³: flexor, then extensor.
fn geometric_mm3(frame: &Frame) -> [f64; 2] {
    let muscle = Muscle::new(
        &MuscleParameters::default(),
        Default::default(),
        HeatExchange::Isothermal,
        101.325,
    );
    [1.0, -1.0].map(|side| muscle.gas_volume_mm3(side * frame.truth.displacement_mm))
}

/// d ln m / dt = −rate (P − P_atm)/P, for each chamber with its own rate.
#[test]
fn leak() {
    let rates = [0.05, 0.02];
    let effect = format!("leak:flexor_rate_per_s={},extensor_rate_per_s={}", rates[0], rates[1]);
    for parameters in [plain(&[&effect]), ideal(&[&effect])] {
        let frames = sealed(&parameters, [30.0, 60.0], 5.0, sine(1.0, 1.0));
        for (i, rate) in rates.into_iter().enumerate() {
            let pressure = |f: &Frame| f.truth.pressures_kpa[i];
            let share = |f: &Frame| (pressure(f) - 101.325) / pressure(f);
            let fed: f64 = frames.windows(2).map(|w| 0.5e-3 * (share(&w[0]) + share(&w[1]))).sum();
            let [first, last] = [0, frames.len() - 1].map(|k| frames[k].truth.masses_g[i].ln());
            let made = (last - first) / fed;
            assert!((made / -rate - 1.0).abs() < 1e-5, "{made} instead of -{rate} 1/s");
        }
    }
    // A parameter that is left out means a tight chamber.
    let frames = sealed(&plain(&["leak:extensor_rate_per_s=0.5"]), [30.0, 60.0], 2.0, |_| 0.0);
    let change = |i: usize| frames[1999].truth.masses_g[i] / frames[0].truth.masses_g[i];
    assert!(change(0) == 1.0 && change(1) < 0.6);
}

/// A leak ends at room pressure.
#[test]
fn a_chamber_leaks_until_it_has_room_pressure() {
    let parameters = plain(&["leak:flexor_rate_per_s=1,extensor_rate_per_s=1"]);
    let frames = sealed(&parameters, [20.0, 20.0], 14.0, |_| 0.0);
    let end = frames[13_999].truth.pressures_kpa;
    assert!(end.iter().all(|p| (p - 101.325).abs() < 1e-2), "{end:?}");
    assert!(frames.iter().all(|f| f.truth.pressures_kpa[0] > 101.325 - 1e-9));
}

/// P Vⁿ is constant in the volume of the plain muscle, and P V is not.
#[test]
fn polytropic_gas() {
    let frames =
        sealed(&plain(&["polytropic_gas:exponent=1.3"]), [30.0, 60.0], 3.0, sine(1.5, 1.0));
    let spread = |exponent: f64, i: usize| {
        let constant = |f: &Frame| f.truth.pressures_kpa[i] * geometric_mm3(f)[i].powf(exponent);
        let first = constant(&frames[0]);
        frames.iter().map(|f| (constant(f) / first - 1.0).abs()).fold(0.0, f64::max)
    };
    for i in 0..2 {
        assert!(spread(1.3, i) < 1e-11, "{}", spread(1.3, i));
        assert!(spread(1.0, i) > 5e-3);
    }
}

/// nu of the published cylinder, `dV/V = (2 nu − 1) dc/L` at rest, is off by the factor.
#[test]
fn geometry_coefficient() {
    let nu = |effect: &str| {
        let frames = sealed(&plain(&[effect]), [45.0, 45.0], 2.0, sine(0.3, 1.0));
        [(0, 1.0), (1, -1.0)].map(|(i, side): (usize, f64)| {
            let points: Vec<_> = frames
                .iter()
                .map(|f| (side * f.truth.displacement_mm, f.truth.volumes_mm3[i].ln()))
                .filter(|(c, _)| c.abs() < 0.1)
                .collect();
            assert!(points.len() > 100);
            0.5 * (1.0 + 200.0 * line(&points).0)
        })
    };
    let usual = nu("geometry_coefficient:relative=0");
    for relative in [0.15, -0.2] {
        let made = nu(&format!("geometry_coefficient:relative={relative}"));
        for (made, usual) in made.into_iter().zip(usual) {
            let ratio = made / usual;
            assert!((ratio - 1.0 - relative).abs() < 1e-3, "{ratio}");
        }
    }
    // More change of volume, more change of pressure.
    let swing = |effect: &str| {
        let frames = sealed(&plain(&[effect]), [45.0, 45.0], 2.0, sine(0.3, 1.0));
        let pressures = frames.iter().map(|f| f.truth.pressures_kpa[0]);
        largest(pressures) - kpa(45.0)
    };
    assert!(
        swing("geometry_coefficient:relative=0.15")
            > 1.1 * swing("geometry_coefficient:relative=0")
    );
}
