//! What the rig can do, and what it is.

use super::rig;
use crate::arguments::{RigObservablesArguments, RigProtocolArguments};
use crate::console::{Console, table};
use crate::error::CliError;
use pam_report::page::number;
use pam_rig::effects::ALL;
use pam_rig::observables::observables;
use pam_rig::{Protocol, RigParameters};
use serde_json::{Value, json};

/// `pam rig list-effects`.
pub(super) fn effects(console: &Console) {
    let parameter = |p: &pam_rig::effects::ParameterInfo| json!({ "name": p.name, "typical": p.typical, "neutral": p.neutral, "limits": p.limits });
    let effect = |e: &pam_rig::EffectInfo| {
        json!({
            "id": e.id,
            "group": e.group.label(),
            "listed": e.group.is_listed(),
            "what": e.what,
            "parameters": e.parameters.iter().map(parameter).collect::<Vec<_>>(),
        })
    };
    console.json(&Value::Array(ALL.iter().map(effect).collect()));
    let mut group = None;
    for e in ALL {
        if group != Some(e.group) {
            group = Some(e.group);
            console.text(format!("\n{}", e.group.label()));
        }
        let parameters: Vec<String> =
            e.parameters.iter().map(|p| format!("{}={}", p.name, p.typical)).collect();
        console.text(format!("  {}:{}\n      {}", e.id, parameters.join(","), e.what));
    }
    console.text(
        "\nThe values are typical ones, which an id alone takes. Effects come on top of what the rig \
         already does.",
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
pub(super) fn parameters(console: &Console) {
    let rig = RigParameters::default();
    console.json(&serde_json::to_value(&rig).unwrap_or(Value::Null));
    console.text(rig.to_toml().trim_end());
}

/// `pam rig observables`.
pub(super) fn observables_of(
    arguments: &RigObservablesArguments,
    console: &Console,
) -> Result<(), CliError> {
    let all = observables(&rig(arguments.rig.as_deref())?.plant)?;
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
