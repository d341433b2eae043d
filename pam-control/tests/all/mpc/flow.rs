use pam_control::mpc::ValveModel;
use pam_core::units::ATMOSPHERE_KPA;

#[test]
fn flow_is_choked_below_the_critical_ratio() {
    let v = ValveModel::default();
    let choked = 0.020 * 1.185 * v.supply_kpa * 1e-2;
    assert!((v.inflow_g_s(0.2 * v.supply_kpa) - choked).abs() < 1e-12);
    assert!(v.inflow_g_s(0.8 * v.supply_kpa) < 0.75 * choked);
    assert_eq!(v.inflow_g_s(1.1 * v.supply_kpa), 0.0);
    assert_eq!(v.outflow_g_s(ATMOSPHERE_KPA), 0.0);
}
