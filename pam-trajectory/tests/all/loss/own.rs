//! Losses of other crates, known by name.

use super::testing::assert_cotangents;
use pam_data::Recording;
use pam_trajectory::loss::{NamedLoss, register};
use pam_trajectory::{AnyLoss, SettingsError, TrajectoryLoss};
use serde::{Deserialize, Serialize};

/// `mean (Δx / scale)⁴` times a weight.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Quartic {
    scale_mm: f64,
    weight: f64,
}

impl TrajectoryLoss for Quartic {
    fn value_and_cotangents(
        &self,
        measured: &Recording,
        predicted: &[[f64; 4]],
        cotangents: &mut [[f64; 4]],
    ) -> f64 {
        let share = self.weight / predicted.len() as f64;
        let mut sum = 0.0;
        for ((p, x), w) in predicted.iter().zip(&measured.displacement_mm).zip(cotangents) {
            let e = (p[0] - x) / self.scale_mm;
            sum += share * e.powi(4);
            *w = [4.0 * share * e.powi(3) / self.scale_mm, 0.0, 0.0, 0.0];
        }
        sum
    }

    fn check(&self) -> Result<(), SettingsError> {
        match self.scale_mm > 0.0 {
            true => Ok(()),
            false => {
                Err(SettingsError(format!("scale_mm must be positive, got {}", self.scale_mm)))
            }
        }
    }
}

impl NamedLoss for Quartic {
    const NAME: &'static str = "quartic";
    const DESCRIPTION: &'static str = "fourth power of the displacement error";
}

/// Without settings, under a name that is taken.
#[derive(Serialize, Deserialize)]
struct Paper;

impl TrajectoryLoss for Paper {
    fn value_and_cotangents(&self, _: &Recording, _: &[[f64; 4]], _: &mut [[f64; 4]]) -> f64 {
        0.0
    }
}

impl NamedLoss for Paper {
    const NAME: &'static str = "paper";
    const DESCRIPTION: &'static str = "nothing";
}

/// Without settings.
#[derive(Serialize, Deserialize)]
struct Nothing;

impl TrajectoryLoss for Nothing {
    fn value_and_cotangents(&self, _: &Recording, _: &[[f64; 4]], w: &mut [[f64; 4]]) -> f64 {
        w.fill([0.0; 4]);
        0.0
    }
}

impl NamedLoss for Nothing {
    const NAME: &'static str = "nothing";
    const DESCRIPTION: &'static str = "zero";
}

const DEFAULT: Quartic = Quartic { scale_mm: 0.5, weight: 2.0 };

#[test]
fn an_own_loss_is_read_and_written_like_a_built_in_one() {
    register(&DEFAULT).unwrap();
    let parse = |json: &str| serde_json::from_str::<AnyLoss>(json);
    let loss = parse(r#"{"kind":"quartic","scale_mm":0.2}"#).unwrap();
    loss.check().unwrap();
    assert_cotangents(&loss, 31);
    let written = serde_json::to_string(&loss).unwrap();
    assert_eq!(written, r#"{"kind":"quartic","scale_mm":0.2,"weight":2.0}"#);
    assert_eq!(parse(&written).unwrap(), loss);
    assert_eq!("quartic:scale_mm=0.2".parse::<AnyLoss>().unwrap(), loss);
    // What a file leaves out is that of the registered value; another loss may wrap it.
    assert_eq!(parse(r#"{"kind":"quartic"}"#).unwrap(), AnyLoss::Own(own(&DEFAULT)));
    let masked = parse(r#"{"kind":"masked","every":2,"of":{"kind":"quartic"}}"#).unwrap();
    assert_cotangents(&masked, 32);
    assert!(parse(r#"{"kind":"quartic","scale_mm":-1.0}"#).unwrap().check().is_err());
    for (json, word) in [
        (r#"{"kind":"quartic","scale":1}"#, "scale_mm, weight"),
        (r#"{"kind":"quartic","scale_mm":"wide"}"#, "wide"),
        (r#"{"kind":"cubic"}"#, "pam_cli::Registry"),
        (r#"{"kind":"squared","weights":[1,1,1,1],"colour":1}"#, "colour"),
    ] {
        let message = parse(json).unwrap_err().to_string();
        assert!(message.contains(word), "{json}: {message}");
    }
    // The built-in ones are what they were.
    assert_eq!(parse(r#"{"kind":"paper"}"#).unwrap(), AnyLoss::Paper {});
}

fn own(loss: &Quartic) -> pam_trajectory::loss::OwnLoss {
    pam_trajectory::loss::OwnLoss::new(loss).unwrap()
}

#[test]
fn a_loss_without_settings_has_a_name_alone_and_names_are_not_taken_twice() {
    register(&Nothing).unwrap();
    register(&Nothing).unwrap();
    let loss: AnyLoss = serde_json::from_str(r#"{"kind":"nothing"}"#).unwrap();
    assert_eq!(serde_json::to_string(&loss).unwrap(), r#"{"kind":"nothing"}"#);
    let wrong = serde_json::from_str::<AnyLoss>(r#"{"kind":"nothing","scale":1}"#).unwrap_err();
    assert!(wrong.to_string().contains("no setting `scale`"), "{wrong}");
    assert!(register(&Paper).unwrap_err().to_string().contains("paper"));
    register(&DEFAULT).unwrap();
    assert!(register(&Quartic { scale_mm: 9.0, ..DEFAULT }).is_err());
    assert!(AnyLoss::all().iter().any(|(name, _)| *name == "quartic"));
}
