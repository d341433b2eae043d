use pam_rig::Effect;
use pam_rig::effects::{ALL, Clock, Seen};

#[test]
fn text_and_table_say_the_same() {
    let effect: Effect = "leak: flexor_rate_per_s = 0.01".parse().unwrap();
    assert_eq!(effect.values(), [0.01, 0.0]);
    assert_eq!(effect.to_string().parse::<Effect>().unwrap(), effect);
    let json = serde_json::to_string(&effect).unwrap();
    assert_eq!(serde_json::from_str::<Effect>(&json).unwrap(), effect);
}

#[test]
fn what_is_wrong_is_said() {
    let message = |text: &str| text.parse::<Effect>().unwrap_err().to_string();
    assert!(message("coulomb").contains("coulomb_friction, stribeck_friction"));
    assert!(message("creep:stiffness_n_mm=10").contains("`time_constant_s` is missing"));
    assert!(message("creep:stiffness=10").contains("no parameter `stiffness`"));
    assert!(message("backlash:gap_mm=-1").contains("outside 0"));
    assert!(message("backlash:gap_mm=x").contains("not a number"));
    assert!(message("backlash:gap_mm").contains("name=value"));
}

#[test]
fn every_effect_takes_its_typical_values_within_its_limits() {
    for hidden in ALL {
        let effect: Effect = hidden.info.id.parse().unwrap();
        assert!(hidden.info.parameters.len() <= Effect::MOST);
        assert_eq!(hidden.info.parameters.len(), hidden.typical.len());
        assert_eq!(effect.to_string().parse::<Effect>().unwrap(), effect);
        let _ = effect.start();
    }
}

#[test]
fn a_delay_gives_the_past() {
    let read = |delay_ms: f64, samples: &[f64]| -> Vec<f64> {
        let effect: Effect = format!("position_delay:delay_ms={delay_ms}").parse().unwrap();
        let mut delay = effect.start();
        let pass = |(k, &displacement_mm): (usize, &f64)| {
            let clock = Clock { time_s: k as f64 * 1e-3, step_s: 1e-3, sealed_g: None };
            let mut seen = Seen { displacement_mm, pressures_kpa: [0.0; 2] };
            delay.observe(&clock, &mut seen);
            seen.displacement_mm
        };
        samples.iter().enumerate().map(pass).collect()
    };
    let rising: Vec<f64> = (0..6).map(f64::from).collect();
    assert_eq!(read(2.5, &rising), [0.0, 0.0, 0.0, 0.5, 1.5, 2.5]);
    assert_eq!(read(0.0, &[3.0]), [3.0]);
}
