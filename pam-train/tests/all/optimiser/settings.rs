use pam_train::optimiser::{AdamSettings, LbfgsSettings, OptimiserSettings};

fn read(json: &str) -> Result<OptimiserSettings, serde_json::Error> {
    serde_json::from_str(json)
}

/// Defaults: Kingma and Ba (2015), algorithm 1; the decay is the one that PyTorch documents.
#[test]
fn what_is_left_out_has_its_default() {
    let adam = read(r#"{ "kind": "adam" }"#).unwrap();
    assert_eq!(adam, OptimiserSettings::default());
    let expected = AdamSettings { beta1: 0.9, beta2: 0.999, epsilon: 1e-8, weight_decay: 0.0 };
    assert_eq!(adam.adam(), Some(expected));
    let adamw = read(r#"{ "kind": "adamw", "beta2": 0.99 }"#).unwrap();
    let expected = AdamSettings { beta2: 0.99, weight_decay: 0.01, ..expected };
    assert_eq!(adamw.adam(), Some(expected));
    let lbfgs = read(r#"{ "kind": "lbfgs", "memory": 5 }"#).unwrap();
    let expected = LbfgsSettings { memory: 5, ..LbfgsSettings::default() };
    assert_eq!(lbfgs, OptimiserSettings::Lbfgs(expected));
    assert_eq!(lbfgs.adam(), None);
    for settings in [adam, adamw, lbfgs] {
        settings.check().unwrap();
        assert_eq!(read(&serde_json::to_string(&settings).unwrap()).unwrap(), settings);
    }
}

#[test]
fn what_does_not_belong_is_refused() {
    assert!(read(r#"{ "kind": "adam", "weight_decay": 0.1 }"#).is_err());
    assert!(read(r#"{ "kind": "lbfgs", "beta1": 0.9 }"#).is_err());
    assert!(read(r#"{ "kind": "sgd" }"#).is_err());
    for json in [
        r#"{ "kind": "adam", "beta1": 1.0 }"#,
        r#"{ "kind": "adam", "epsilon": 0 }"#,
        r#"{ "kind": "adamw", "weight_decay": -1 }"#,
        r#"{ "kind": "lbfgs", "memory": 0 }"#,
        r#"{ "kind": "lbfgs", "armijo": 0.95 }"#,
    ] {
        assert!(read(json).unwrap().check().is_err(), "{json}");
    }
}
