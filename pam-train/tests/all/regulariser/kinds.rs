use pam_train::AnyRegulariser;
use pam_train::regulariser::L2;

const PASSIVITY: &str = r#"{
    "kind": "passivity",
    "within": { "mass_flexor_g": [0.02, 0.1], "mass_extensor_g": [0.02, 0.1],
                "displacement_mm": [-3, 3], "velocity_mm_s": [-20, 20] },
    "damping": { "strength": 1.0, "half_width": 0.5 }
}"#;

#[test]
fn kinds_are_read_and_wrong_numbers_refused() {
    let read = |json: &str| serde_json::from_str::<AnyRegulariser>(json);
    let l2 = read(r#"{ "kind": "l2", "strength": 1e-4 }"#).unwrap();
    assert_eq!(l2, AnyRegulariser::L2(L2 { strength: 1e-4 }));
    let passivity = read(PASSIVITY).unwrap();
    passivity.check().unwrap();
    let AnyRegulariser::Passivity(own) = &passivity else { panic!("{passivity:?}") };
    assert_eq!((own.stiffness, own.damping.map(|d| d.floor)), (None, Some(0.0)));
    let again = read(&serde_json::to_string(&passivity).unwrap()).unwrap();
    assert_eq!(again, passivity);

    assert!(read(r#"{ "kind": "l2", "strength": -1.0 }"#).unwrap().check().is_err());
    assert!(read(r#"{ "kind": "l2", "strength": 1.0, "power": 2 }"#).is_err());
    for (from, to) in [("[-3, 3]", "[3, -3]"), ("0.5", "0.0"), ("1.0", "-1.0")] {
        assert!(read(&PASSIVITY.replace(from, to)).unwrap().check().is_err(), "{from}");
    }
}
