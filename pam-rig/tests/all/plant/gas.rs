use approx::assert_relative_eq;
use pam_rig::plant::gas::ROOM_K;
use pam_rig::plant::{Chamber, GasLedger, HeatExchange};

fn chamber(exchange: HeatExchange) -> Chamber {
    Chamber::at_rest(412.0, 25e3, 5.0, exchange)
}

#[test]
fn fast_is_adiabatic_and_slow_isothermal() {
    for (exchange, exponent) in [(HeatExchange::Isothermal, 1.0), (HeatExchange::Adiabatic, 1.4)] {
        let mut air = chamber(exchange);
        air.compress(24e3);
        air.relax(1.0);
        let expected = 412.0 * (25.0_f64 / 24.0).powf(exponent);
        assert_relative_eq!(air.pressure_kpa(), expected, max_relative = 1e-12);
    }
    let mut air = chamber(HeatExchange::default());
    air.compress(24e3);
    assert_relative_eq!(
        air.pressure_kpa(),
        412.0 * (25.0_f64 / 24.0).powf(1.4),
        max_relative = 1e-12
    );
    air.relax(60.0);
    assert_relative_eq!(air.pressure_kpa(), 412.0 * 25.0 / 24.0, max_relative = 1e-12);
}

#[test]
fn the_slowest_mode_has_the_time_constant_of_conduction() {
    // r² ρ c_p / (β₁² k) with ρ = 4.5 kg/m³ (381 kPa at 295.15 K), by hand in SI units.
    let still = HeatExchange::Conduction { scale: 1.0 };
    let mut air = Chamber::at_rest(381.2, 25e3, 5.0, still);
    air.compress(24e3);
    let density = 1e6 * air.mass_g / 24e3;
    let expected_s = 25e-6 * density * 1004.5 / (0.026 * 5.783_186);
    air.relax(2.0);
    let first = air.temperature_k() - ROOM_K;
    air.relax(0.5);
    let second = air.temperature_k() - ROOM_K;
    assert_relative_eq!(0.5 / (first / second).ln(), expected_s, max_relative = 2e-3);
}

#[test]
fn the_first_law_closes_in_every_step() {
    for exchange in [HeatExchange::Isothermal, HeatExchange::Adiabatic, HeatExchange::default()] {
        let mut air = chamber(exchange);
        let start = air.energy_uj();
        for k in 0..1000 {
            let t = f64::from(k) * 1e-2;
            air.compress(25e3 * (1.0 + 0.05 * t.sin()));
            air.relax(1e-2);
            air.exchange_air(1e-4 * (3.0 * t).cos(), 280.0);
        }
        let GasLedger { work_uj, heat_uj, enthalpy_uj } = air.ledger;
        let change = air.energy_uj() - start;
        assert_relative_eq!(change, enthalpy_uj - work_uj - heat_uj, epsilon = 1e-9 * start);
    }
}

#[test]
fn availability_only_falls_while_heat_flows() {
    let mut air = chamber(HeatExchange::default());
    air.compress(23e3);
    // Air that has cooled near the wall and is expanded is cold there and warm within.
    for volume in [23e3, 23.5e3, 23.2e3] {
        air.compress(volume);
        let mut last = air.availability_uj();
        for _ in 0..20 {
            air.relax(0.02);
            let now = air.availability_uj();
            assert!(now < last, "{volume} mm³: {last} to {now} µJ");
            last = now;
        }
    }
}
