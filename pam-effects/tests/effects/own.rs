//! Effects of other crates, known by their ids.

use pam_effects::effects::{
    ALL, AnyEffect, DataScales, Effect, EffectInfo, Group, ParameterInfo, by_id, register,
};
use pam_effects::{EffectError, EffectRecord};

macro_rules! effect {
    ($name:ident, $id:literal) => {
        #[derive(Debug)]
        struct $name;
        impl Effect for $name {
            fn info(&self) -> &'static EffectInfo {
                const INFO: EffectInfo = EffectInfo::new(
                    $id,
                    Group::Mechanics,
                    stringify!($name),
                    &[ParameterInfo::linear("force_n", [0.0, 1.0])],
                );
                &INFO
            }
            fn starts(&self, _: &DataScales) -> Vec<Vec<f64>> {
                vec![vec![0.5]]
            }
        }
    };
}

effect!(Own, "own_of_the_tests");
effect!(Impostor, "own_of_the_tests");
effect!(Leak, "leak");

#[test]
fn an_own_effect_is_found_by_its_id_once_it_is_registered() {
    let text = "own_of_the_tests:force_n=0.25";
    let record: EffectRecord = text.parse().expect("an id and a value");
    let unknown = record.resolve(&[]).expect_err("nobody knows it yet");
    assert!(matches!(unknown, EffectError::Unknown { .. }));
    for word in ["own_of_the_tests", "coulomb_friction", "pam_cli::Registry"] {
        assert!(unknown.to_string().contains(word), "{unknown}");
    }
    // A caller that hands it over needs no table.
    assert_eq!(record.resolve(&[&Own]).expect("handed over").values, [0.25]);

    register(&Own).expect("the id is free");
    register(&Own).expect("the same one again");
    assert_eq!(record.resolve(&[]).expect("registered").values, [0.25]);
    assert!(by_id("own_of_the_tests").is_some());
    assert_eq!(pam_effects::effects::all().len(), ALL.len() + 1);
    for taken in [&Impostor as &'static dyn AnyEffect, &Leak] {
        let message = register(taken).expect_err("taken").to_string();
        assert!(message.contains("another id"), "{message}");
    }
}

#[test]
fn effects_on_a_command_line_are_read_or_refused_with_the_reason() {
    let bias: EffectRecord =
        " pressure_bias: flexor_kpa = 2, extensor_kpa=-1 ".parse().expect("two values");
    assert_eq!((bias.effect.as_str(), bias.values["extensor_kpa"]), ("pressure_bias", -1.0));
    for (text, word) in [
        ("leak:flexor_rate_per_s", "NAME=VALUE"),
        ("leak:flexor_rate_per_s=much", "no number"),
        ("leak:a=1,a=2", "twice"),
    ] {
        let message = text.parse::<EffectRecord>().expect_err(text).to_string();
        assert!(message.contains("leak") && message.contains(word), "{message}");
    }
}
