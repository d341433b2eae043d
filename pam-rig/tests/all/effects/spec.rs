use pam_rig::Effect;

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
