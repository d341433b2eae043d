use pam_train::curriculum::{Curriculum, CurriculumError};
use std::path::Path;

fn open(overrides: &[&str]) -> Result<Curriculum, CurriculumError> {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    Curriculum::open("recommended", &overrides)
}

#[test]
fn every_built_in_curriculum_is_sound_and_survives_its_text() {
    for name in Curriculum::BUILT_IN {
        let curriculum = Curriculum::open(name, &[]).unwrap();
        assert_eq!(curriculum.name, name);
        let back = Curriculum::parse(&curriculum.to_toml(), Path::new("x"), &[]).unwrap();
        assert_eq!(back, curriculum);
    }
}

#[test]
fn overrides_reach_every_depth() {
    let c = open(&["rate=3e-3", "model.activation=tanh", "stage.1.matching.steps=7"]).unwrap();
    assert_eq!(c.rate, 3e-3);
    assert_eq!(c.model.activation, "tanh");
    let pam_train::curriculum::Stage::Derivatives(stage) = &c.stages[1] else {
        panic!("{:?}", c.stages[1])
    };
    assert_eq!(stage.matching.steps, 7);
}

#[test]
fn what_is_wrong_is_said() {
    let message = |o: &str| open(&[o]).unwrap_err().to_string();
    assert!(message("rate").contains("key=value"));
    assert!(message("rates=1").contains("--set rates=1: unknown field `rates`"));
    assert!(message("stage.9.epochs=1").contains("places 0 to"));
    assert!(message("rate=-1").contains("rate"));
    assert!(message("model.activation=sinus").contains("sinus"));
    let text = "name = \"a\"\n[[stage]]\nkind = \"solve\"\nname = \"b\"\nepoch = 3\n";
    let message = Curriculum::parse(text, Path::new("c.toml"), &[]).unwrap_err().to_string();
    assert!(message.contains("c.toml:") && message.contains("epoch"), "{message}");
}
