//! Definitions as TOML.

use super::{EffectDefinition, Language, MemoryLaw};
use crate::Group;
use std::fmt::Write;

impl EffectDefinition {
    /// The definition as a file with this effect alone. The same definition gives the same text, and
    /// [`read_all`](Self::read_all) gives the definition back.
    #[must_use]
    pub fn to_toml(&self, language: &Language) -> String {
        let mut out = String::from("[[effect]]\n");
        let mut line = |text: String| {
            out.push_str(&text);
            out.push('\n');
        };
        line(format!("id = {}", quoted(&self.id)));
        line(format!("description = {}", quoted(&self.description)));
        let group = match self.group {
            Group::Mechanics => "mechanics",
            Group::Gas => "gas",
            Group::Sensing => "sensing",
        };
        line(format!("group = {}", quoted(group)));
        if !self.excited_by.is_empty() {
            line(format!("excited_by = {}", quoted(&self.excited_by)));
        }
        if let Some(valid) = &self.valid {
            line(format!("valid = {}", quoted(&valid.text)));
        }
        for p in &self.parameters {
            let mut entry = format!("range = [{:?}, {:?}]", p.range[0], p.range[1]);
            if let Some(absent) = p.absent {
                let _ = write!(entry, ", absent = {absent:?}");
            }
            if p.logarithmic {
                entry += ", log = true";
            }
            if let Some(other) = p.not_below {
                let _ = write!(entry, ", not_below = {}", quoted(&self.parameters[other].name));
            }
            let starts: Vec<String> = p.starts.iter().map(|s| quoted(&s.text)).collect();
            let _ = write!(entry, ", start = [{}]", starts.join(", "));
            if !p.meaning.is_empty() {
                let _ = write!(entry, ", meaning = {}", quoted(&p.meaning));
            }
            line(format!("parameters.{} = {{ {entry} }}", p.name));
        }
        for s in &self.switches {
            let values: Vec<String> = s.values.iter().map(|v| format!("{v:?}")).collect();
            let meaning = quoted(&s.meaning);
            line(format!(
                "switches.{} = {{ values = [{}], meaning = {meaning} }}",
                s.name,
                values.join(", ")
            ));
        }
        for (name, formula) in &self.lets {
            line(format!("let.{name} = {}", quoted(&formula.text)));
        }
        for m in &self.memory {
            let law = match &m.law {
                MemoryLaw::Rate(_) => "rate",
                MemoryLaw::Step(_) => "step",
            };
            let (start, text) = (quoted(&m.start.text), quoted(&m.law.formula().text));
            line(format!("memory.{} = {{ start = {start}, {law} = {text} }}", m.name));
        }
        for (place, formula) in &self.acts {
            line(format!("acts.{} = {}", language.places[*place].name, quoted(&formula.text)));
        }
        out
    }
}

/// A text as a string of TOML on one line.
fn quoted(text: &str) -> String {
    toml::Value::String(text.split_whitespace().collect::<Vec<_>>().join(" ")).to_string()
}
