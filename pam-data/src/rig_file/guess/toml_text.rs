//! A guessed rig file as TOML with its reasons as comments.

use super::GuessedRig;
use std::fmt::Write;

impl GuessedRig {
    /// The rig file as TOML: guesses with their reasons, and lines to be filled in for what is missing.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut out = String::from(
            "# The rig and its files, guessed from one of them. Confirm the lines marked `confirm`, fill in those marked\n\
             # `fill in`, then check with `pam inspect --rig-file`. Keys: docs/own-rig.md.\n\n",
        );
        let _ = writeln!(out, "name = {}", quoted(&self.rig.name));
        out += "\n[file]\n";
        let file = &self.rig.file;
        if let Some(separator) = &file.separator {
            let _ = writeln!(out, "separator = {}", quoted(separator));
        }
        if let Some(decimal) = &file.decimal {
            let _ = writeln!(out, "decimal = {}", quoted(decimal));
        }
        if let Some(header) = file.header {
            let _ = writeln!(out, "header = {header}");
        }
        self.missing_of(&mut out, "file");
        if let Some(columns) = &self.rig.columns {
            let plain = [
                ("time", columns.time.as_ref()),
                ("displacement", Some(&columns.displacement)),
                ("velocity", columns.velocity.as_ref()),
                ("force", Some(&columns.force)),
            ];
            for (key, column) in plain {
                let key = format!("columns.{key}");
                match column {
                    Some(c) => {
                        let _ = writeln!(out, "\n[{key}]");
                        self.line(
                            &mut out,
                            &key,
                            &format!("column = {}", quoted(&c.column_text())),
                        );
                        self.line(
                            &mut out,
                            &format!("{key}.unit"),
                            &format!("unit = {}", quoted(&c.unit)),
                        );
                        if !key.ends_with("time") {
                            self.line(
                                &mut out,
                                &format!("{key}.sign"),
                                &format!("sign = {}", c.sign),
                            );
                        }
                    }
                    None => self.line(&mut out, &key, &format!("\n# [{key}]")),
                }
                if key.ends_with("velocity") {
                    for (key, p) in [
                        ("columns.pressure_flexor", &columns.pressure_flexor),
                        ("columns.pressure_extensor", &columns.pressure_extensor),
                    ] {
                        let _ = writeln!(out, "\n[{key}]");
                        let name = p.as_column().column_text();
                        self.line(&mut out, key, &format!("column = {}", quoted(&name)));
                        self.line(
                            &mut out,
                            &format!("{key}.unit"),
                            &format!("unit = {}", quoted(&p.unit)),
                        );
                        let zero = format!("{:?}", p.reference).to_lowercase();
                        self.line(
                            &mut out,
                            &format!("{key}.reference"),
                            &format!("reference = {}", quoted(&zero)),
                        );
                    }
                }
            }
        }
        for (table, more) in [
            ("drive", ""),
            ("muscles", ""),
            ("joint", ""),
            (
                "air",
                "# atmosphere_kpa = 101.325\n# temperature_c = 22\n# rest_s = 0         # time at rest at the start, s: its mean gives the sealed masses\n",
            ),
            (
                "filter",
                "# displacement_hz = 20 # zero-phase low-pass of each channel, Hz; none by default\n# pressure_hz = 20\n# force_hz = 20\n# velocity_hz = 20     # of the displacement before its derivative is taken\n",
            ),
            (
                "limits",
                "# pressure_kpa = [110, 600]   # absolute\n# displacement_mm = [-10, 10]\n# force_n = 200\n",
            ),
        ] {
            if more.is_empty()
                && !self.missing.iter().any(|(key, _)| key.starts_with(&format!("{table}.")))
            {
                continue;
            }
            let _ = writeln!(out, "\n[{table}]");
            self.missing_of(&mut out, table);
            out += more;
        }
        if !self.unused.is_empty() {
            let _ =
                writeln!(out, "\n# Columns that nothing is taken from: {}", self.unused.join(", "));
        }
        out
    }

    /// A line with the reason of its guess.
    fn line(&self, out: &mut String, key: &str, text: &str) {
        match self.guesses.iter().find(|g| g.key == key) {
            Some(g) => {
                let mark = if g.to_confirm { "confirm: " } else { "" };
                let _ = writeln!(out, "{text:<28} # {mark}{}", g.reason);
            }
            None => {
                let _ = writeln!(out, "{text}");
            }
        }
    }

    fn missing_of(&self, out: &mut String, table: &str) {
        for (key, what) in &self.missing {
            if let Some(key) = key.strip_prefix(&format!("{table}.")) {
                let _ = writeln!(out, "{:<28} # fill in: {what}", format!("# {key} ="));
            }
        }
    }
}

impl super::Column {
    fn column_text(&self) -> String {
        match &self.column {
            super::ColumnKey::Name(name) => name.clone(),
            super::ColumnKey::Number(number) => number.to_string(),
        }
    }
}

fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
