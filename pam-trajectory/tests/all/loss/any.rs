use super::testing::{assert_cotangents, noisy, random_recording};
use pam_trajectory::{AnyLoss, SquaredError, TrajectoryLoss};

fn parse(json: &str) -> Result<AnyLoss, serde_json::Error> {
    serde_json::from_str(json)
}

const FILES: [&str; 6] = [
    r#"{"kind":"paper"}"#,
    r#"{"kind":"published"}"#,
    r#"{"kind":"squared","weights":[3.0,2.0,1.0,0.5]}"#,
    r#"{"kind":"normalised","weights":[1.0,1.0,2.0,2.0]}"#,
    r#"{"kind":"huber","form":"pseudo_huber","thresholds":[0.5,5.0,2.0,2.0],"weights":[1.0,1.0,1.0,1.0]}"#,
    r#"{"kind":"masked","of":{"kind":"paper"},"every":3,"intervals_s":[[0.0,0.15]]}"#,
];

#[test]
fn every_loss_has_its_name() {
    // In their order; further losses may stand between them.
    let mut names = AnyLoss::ALL.iter().map(|(name, _)| name);
    for json in FILES {
        let named = |name: &str| json.starts_with(&format!(r#"{{"kind":"{name}""#));
        assert!(names.any(|name| named(name)), "{json}");
    }
    // A file that names a loss of the list is refused for its fields only.
    for (name, _) in AnyLoss::ALL {
        let refusal = parse(&format!(r#"{{"kind":"{name}","colour":1}}"#)).unwrap_err();
        assert!(!refusal.to_string().contains("variant"), "{name}: {refusal}");
    }
}

#[test]
fn every_kind_is_read_written_and_right() {
    for (k, json) in FILES.iter().enumerate() {
        let loss = parse(json).unwrap();
        loss.check().unwrap();
        assert_eq!(serde_json::to_string(&loss).unwrap(), *json);
        assert_cotangents(&loss, 20 + k as u64);
    }
}

#[test]
fn named_losses_are_those_of_the_squared_error() {
    let measured = random_recording(12, 3);
    let predicted = noisy(&measured, 4);
    let value = |loss: &dyn TrajectoryLoss| {
        loss.value_and_cotangents(&measured, &predicted, &mut [[0.0; 4]; 12])
    };
    assert_eq!(value(&parse(FILES[0]).unwrap()), value(&SquaredError::paper()));
    assert_eq!(value(&AnyLoss::default()), value(&SquaredError::published()));
}

#[test]
fn what_is_unknown_or_senseless_is_refused() {
    assert!(parse(r#"{"kind":"paper","weights":[1,1,1,1]}"#).is_err());
    assert!(parse(r#"{"kind":"squared","weights":[1,1,1,1],"colour":1}"#).is_err());
    assert!(parse(r#"{"kind":"masked","of":{"kind":"paper"},"each":3}"#).is_err());
    assert!(parse(r#"{"kind":"hinge"}"#).is_err());
    for json in [
        r#"{"kind":"squared","weights":[1,-1,1,1]}"#,
        r#"{"kind":"huber","thresholds":[0,1,1,1],"weights":[1,1,1,1]}"#,
        r#"{"kind":"masked","of":{"kind":"paper"},"every":0}"#,
        r#"{"kind":"masked","of":{"kind":"paper"},"intervals_s":[[2,1]]}"#,
        r#"{"kind":"masked","of":{"kind":"normalised","weights":[-1,1,1,1]}}"#,
    ] {
        assert!(parse(json).unwrap().check().is_err(), "{json}");
    }
}
