//! Values of every effect at which tests look at it.

use pam_effects::effects::{ALL, DataScales};

/// Medium values of each effect, switches behind them. Effects that are not listed here take the values from
/// which their first fit starts.
pub(crate) fn medium() -> Vec<(&'static str, Vec<f64>)> {
    let mut values = vec![
        ("coulomb_friction", vec![13.0]),
        ("stribeck_friction", vec![9.0, 17.0, 2.1]),
        ("load_friction", vec![0.041]),
        ("viscous_damping", vec![800.0]),
        ("hysteresis", vec![15.0, 0.53, 0.0]),
        ("hysteresis", vec![15.0, 0.51, 1.0]),
        ("hysteresis", vec![15.0, 0.51, 2.0]),
        ("hysteresis", vec![15.0, 0.51, 100.0]),
        ("creep", vec![8.0, 0.7]),
        ("constant_load", vec![12.0]),
        ("added_inertia", vec![35.0]),
        ("backlash", vec![0.13]),
        ("cogging", vec![7.0, 0.613]),
        ("tendon_slack", vec![0.77, 0.2]),
        ("stiffness_drift", vec![0.12]),
        ("stiffness_scale", vec![0.073]),
        ("leak", vec![1.5e-3, 7e-4]),
        ("polytropic_gas", vec![1.2, 0.0]),
        ("polytropic_gas", vec![1.2, 1.0]),
        ("geometry_coefficient", vec![0.08, 0.0]),
        ("geometry_coefficient", vec![0.08, 1.0]),
        ("force_gain", vec![-0.07]),
        ("force_saturation", vec![151.3]),
        ("actuation_delay", vec![10.7]),
        ("actuator_lag", vec![4.3]),
        ("pressure_sensor_lag", vec![5.0]),
        ("pressure_delay", vec![25.7]),
        ("pressure_bias", vec![12.0, -8.0]),
        ("pressure_gain", vec![0.05, -0.04]),
        ("position_offset", vec![0.12]),
        ("position_gain", vec![0.04]),
        ("position_sensor_lag", vec![6.0]),
        ("position_delay", vec![13.1]),
    ];
    let scales = DataScales {
        force_n: 100.0,
        peak_force_n: 150.0,
        force_quantiles_n: Vec::new(),
        travel_mm: 1.0,
        reach_mm: 1.0,
        speed_mm_s: 6.0,
        stiffness_n_mm: 150.0,
        gauge_kpa: 310.0,
        duration_s: 10.0,
        samples: Vec::new(),
    };
    for effect in ALL {
        let id = effect.info().id;
        if values.iter().all(|v| v.0 != id) {
            values.push((id, effect.starts(&scales).swap_remove(0)));
        }
    }
    values
}
