//! Lists of the rig: effects, protocols, parameters, observables.

use crate::console::{Console, table};
use crate::error::CliError;
use clap::Args;
use clap::builder::PossibleValuesParser;
use pam_report::page::number;
use pam_rig::effects::{ALL, Group, HiddenEffect};
use pam_rig::observables::observables;
use pam_rig::{Protocol, RigParameters};
use serde_json::{Value, json};

/// Arguments of `pam rig protocol`.
#[derive(Debug, Args)]
pub struct RigProtocolArguments {
    /// A built-in protocol
    #[arg(value_name = "NAME", value_parser = PossibleValuesParser::new(Protocol::BUILT_IN))]
    pub name: Option<String>,
}

/// Arguments of `pam rig parameters`.
#[derive(Debug, Args)]
pub struct RigParametersArguments {
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
}

/// Arguments of `pam rig observables`.
#[derive(Debug, Args)]
pub struct RigObservablesArguments {
    /// Parameters of the rig: default, measured (as rough as the published real run), or a TOML file; what that leaves
    /// out has its default
    #[arg(long, value_name = "NAME|FILE", default_value = "default")]
    pub rig: String,
}

const UNLISTED: &str = "unlisted phenomena (not in the vocabulary; for testing what is outside it)";

/// `pam rig list-effects`.
pub(super) fn effects(console: &Console) {
    let json = |e: &HiddenEffect| {
        let parameters = e.info.parameters.iter().zip(e.typical).map(|(p, typical)| {
            json!({
                "name": p.name,
                "meaning": p.meaning,
                "typical": typical,
                "neutral": e.neutral(p),
                "limits": p.range,
            })
        });
        json!({
            "id": e.info.id,
            "group": if e.is_listed() { e.info.group.label() } else { "unlisted" },
            "listed": e.is_listed(),
            "what": e.info.description,
            "parameters": parameters.collect::<Vec<_>>(),
        })
    };
    console.json(&Value::Array(ALL.iter().map(json).collect()));
    for group in [Some(Group::Mechanics), Some(Group::Gas), Some(Group::Sensing), None] {
        console.text(format!("\n{}", group.map_or(UNLISTED, Group::label)));
        for e in ALL.iter().filter(|e| e.is_listed().then_some(e.info.group) == group) {
            let named = e.info.parameters.iter().zip(e.typical);
            let values: Vec<String> = named.map(|(p, v)| format!("{}={v}", p.name)).collect();
            let (id, what) = (e.info.id, e.info.description);
            console.text(format!("  {id}:{}\n      {what}", values.join(",")));
            for p in e.info.parameters {
                let [low, high] = p.range;
                console.text(format!("        {}, {low} … {high}: {}", p.name, p.meaning));
            }
        }
    }
    console.text(
        "\nThe values are typical ones, which an id alone takes. Effects act in addition to the rig's own \
         imperfections.",
    );
}

/// `pam rig protocol`.
pub(super) fn protocol(
    arguments: &RigProtocolArguments,
    console: &Console,
) -> Result<(), CliError> {
    let Some(name) = &arguments.name else {
        console.json(&json!(Protocol::BUILT_IN));
        console.text(Protocol::BUILT_IN.join("\n"));
        return Ok(());
    };
    let protocol = Protocol::built_in(name)?;
    console.json(&serde_json::to_value(&protocol).unwrap_or(Value::Null));
    console.text(Protocol::built_in_text(name).unwrap_or_default().trim_end());
    Ok(())
}

/// `pam rig parameters`.
pub(super) fn parameters(
    arguments: &RigParametersArguments,
    console: &Console,
) -> Result<(), CliError> {
    let rig = RigParameters::open(&arguments.rig)?;
    console.json(&serde_json::to_value(&rig).unwrap_or(Value::Null));
    console.text(rig.to_toml().trim_end());
    Ok(())
}

/// `pam rig observables`.
pub(super) fn observables_of(
    arguments: &RigObservablesArguments,
    console: &Console,
) -> Result<(), CliError> {
    let all = observables(&RigParameters::open(&arguments.rig)?.plant)?;
    console.json(&serde_json::to_value(&all).unwrap_or(Value::Null));
    let mut rows =
        vec![["observable", "published", "rig", "unit", "source"].map(str::to_owned).to_vec()];
    for o in &all {
        let digits = if o.published.abs() >= 1000.0 { 0 } else { 2 };
        let values = [o.published, o.rig].map(|v| number(v, digits));
        let [published, rig] = values;
        rows.push(vec![o.what.clone(), published, rig, o.unit.into(), o.source.into()]);
    }
    console.text(table(&rows));
    Ok(())
}
