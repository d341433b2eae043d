//! `pam parts`.

use super::RunCommand;
use crate::arguments::GlobalOptions;
use crate::console::Console;
use crate::error::CliError;
use clap::Args;
use pam_core::Activation;
use pam_effects::effects;
use pam_trajectory::AnyLoss;
use serde_json::{Value, json};
use std::process::ExitCode;

/// Arguments of `pam parts`.
#[derive(Debug, Args)]
pub struct PartsArguments {}

/// A part with a name.
struct Part {
    kind: &'static str,
    name: &'static str,
    description: String,
    own: bool,
}

/// Every effect, activation and loss that files and options may name.
fn parts() -> Vec<Part> {
    let effects = effects::all().into_iter().map(|effect| {
        let info = effect.info();
        let values: Vec<&str> = info.value_names().collect();
        Part {
            kind: "effect",
            name: info.id,
            description: format!("{} ({})", info.description, values.join(", ")),
            own: !effects::ALL.iter().any(|e| e.info().id == info.id),
        }
    });
    let activations = Activation::names().into_iter().map(|name| Part {
        kind: "activation",
        name,
        description: String::new(),
        own: !Activation::NAMES.contains(&name),
    });
    let losses = AnyLoss::all().into_iter().map(|(name, description)| Part {
        kind: "loss",
        name,
        description: description.to_owned(),
        own: !AnyLoss::ALL.iter().any(|(built_in, _)| *built_in == name),
    });
    effects.chain(activations).chain(losses).collect()
}

impl RunCommand for PartsArguments {
    fn run(&self, _global: &GlobalOptions, console: &Console) -> Result<ExitCode, CliError> {
        let parts = parts();
        let width = parts.iter().map(|p| p.name.len()).max().unwrap_or(0);
        for p in &parts {
            let own = if p.own { " [own]" } else { "" };
            let line = format!("{:<10}  {:<width$}  {}{own}", p.kind, p.name, p.description);
            console.text(line.trim_end());
        }
        let json = |p: &Part| -> Value {
            json!({ "kind": p.kind, "name": p.name, "description": p.description, "own": p.own })
        };
        console.json(&json!(parts.iter().map(json).collect::<Vec<_>>()));
        Ok(ExitCode::SUCCESS)
    }
}
