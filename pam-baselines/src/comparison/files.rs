//! The comparison as JSON, CSV and a LaTeX table.

use super::qualitative::Qualities;
use super::result::{BothSets, Comparison, ModelResult, Summary};
use crate::method::Needs;
use serde_json::{Value, json};
use std::fmt::Write as _;

impl Comparison {
    /// Everything that repeats from the seed: scores, numbers of parameters, what fits found.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let models: Vec<Value> = self
            .models
            .iter()
            .map(|m| {
                let mut value = json!(m.result);
                without_times(&mut value["details"]);
                value["qualities"] = json!(Qualities::of(&m.result));
                value
            })
            .collect();
        json!({
            "name": self.name,
            "seed": self.seed,
            "warm_up_samples": self.warm_up,
            "train": self.train,
            "held_out": self.held_out,
            "models": models,
        })
    }

    /// Seconds of fitting and predicting, which do not repeat.
    #[must_use]
    pub fn times_json(&self) -> Value {
        let times: serde_json::Map<String, Value> = self
            .models
            .iter()
            .map(|m| {
                let mut value = json!(m.times);
                if let Some(own) = m.result.details.get("regression_s") {
                    value["regression_s"] = own.clone();
                }
                (m.result.name.clone(), value)
            })
            .collect();
        Value::Object(times)
    }

    /// One row a model, numbers to full precision; empty where undefined.
    #[must_use]
    pub fn to_csv(&self) -> String {
        let frequencies = self.frequencies_hz();
        let mut csv = String::from("model,kind,parameters,needs");
        for start in ["cold", "warm"] {
            for set in ["train", "held_out"] {
                for what in ["mean", "sd", "median", "recordings", "stopped"] {
                    let _ = write!(csv, ",{start}_{set}_r2_x_{what}");
                }
                for f in &frequencies {
                    let _ = write!(csv, ",{start}_{set}_r2_x_mean_{f}hz");
                }
            }
        }
        csv.push_str(",force_r2,stiffness_error_percent,shown_stiffness_error_percent\n");
        let cell = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v}"));
        for m in self.models.iter().map(|m| &m.result) {
            let needs = match m.needs {
                Needs::State => "state",
                Needs::Pressures => "pressures",
            };
            let name = m.name.replace('"', "\"\"");
            let _ = write!(csv, "\"{name}\",{},{},{needs}", m.kind, m.parameters);
            for both in [&m.cold, &m.warm] {
                for set in [&both.train, &both.held_out] {
                    let d = &set.displacement;
                    let (mean, sd, median) = (cell(d.mean), cell(d.deviation), cell(d.median));
                    let _ = write!(csv, ",{mean},{sd},{median},{},{}", d.count, d.stopped);
                    for f in &frequencies {
                        let at = set.by_frequency.iter().find(|(g, _)| g == f);
                        let _ = write!(csv, ",{}", cell(at.and_then(|(_, s)| s.mean)));
                    }
                }
            }
            let x = &m.mechanics;
            let _ = writeln!(
                csv,
                ",{},{},{}",
                cell(x.force_r2),
                cell(x.stiffness_error_percent),
                cell(x.shown_stiffness_error_percent)
            );
        }
        csv
    }

    /// One row a recording, model and start.
    #[must_use]
    pub fn recordings_csv(&self) -> String {
        let mut csv = String::from(
            "model,start,set,recording,r2_x,r2_v,r2_pf,r2_pe,rmse_x_mm,shown_stiffness_n_mm,stopped\n",
        );
        let cell = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v}"));
        for m in self.models.iter().map(|m| &m.result) {
            for (start, both) in [("cold", &m.cold), ("warm", &m.warm)] {
                for (set, scores) in [("train", &both.train), ("held_out", &both.held_out)] {
                    for r in &scores.recordings {
                        let name = m.name.replace('"', "\"\"");
                        let _ = write!(csv, "\"{name}\",{start},{set},{}", r.name);
                        for v in r.r2.into_iter().chain([r.rmse_mm, r.shown_stiffness_n_mm]) {
                            let _ = write!(csv, ",{}", cell(v));
                        }
                        let why = r.stopped.as_deref().unwrap_or_default().replace('"', "'");
                        let _ = writeln!(csv, ",\"{why}\"");
                    }
                }
            }
        }
        csv
    }

    /// A LaTeX table (booktabs) of R², parameters, times and grades.
    #[must_use]
    pub fn to_latex(&self) -> String {
        let mut tex = String::from(
            "% Displacement R2, mean and standard deviation over recordings. Needs \\usepackage{booktabs}.\n\
             \\begin{tabular}{lrrrrrrllll}\n\
             \\toprule\n & & & \\multicolumn{2}{c}{cold start} & \\multicolumn{2}{c}{warm start} & & & & \\\\\n\
             Model & Parameters & Fit (s) & Training & Held out & Training & Held out & Prediction & Force & \
             Stiffness & Interpretability \\\\\n\\midrule\n",
        );
        for m in &self.models {
            let r = &m.result;
            let q = Qualities::of(r);
            let both = |b: &BothSets| {
                [summary_tex(&b.train.displacement), summary_tex(&b.held_out.displacement)]
            };
            let [ct, ch] = both(&r.cold);
            let [wt, wh] = both(&r.warm);
            let mark = if r.needs == Needs::Pressures { "$^{*}$" } else { "" };
            let _ = writeln!(
                tex,
                "{}{mark} & {} & {} & {ct} & {ch} & {wt} & {wh} & {} & {} & {} & {} \\\\",
                tex_text(&r.name),
                r.parameters,
                seconds(m.times.fit_s),
                q.prediction.label(),
                q.force.label(),
                q.stiffness.label(),
                q.interpretability
            );
        }
        tex.push_str("\\bottomrule\n");
        let any = |what: &dyn Fn(&ModelResult) -> bool| self.models.iter().any(|m| what(&m.result));
        let mut note = |text: &str| {
            let _ = writeln!(tex, "\\multicolumn{{11}}{{l}}{{\\footnotesize {text}}} \\\\");
        };
        if any(&|r| r.needs == Needs::Pressures) {
            note("$^{*}$ driven by the measured pressures");
        }
        if any(&|r| r.sets().iter().any(|s| s.displacement.stopped > 0)) {
            note("$^{\\dagger}$ without the recordings, so many of all, whose prediction diverges");
        }
        tex.push_str("\\end{tabular}\n");
        tex
    }

    /// Excitation frequencies of all recordings, Hz.
    #[must_use]
    pub fn frequencies_hz(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self
            .models
            .iter()
            .flat_map(|m| [&m.result.cold.train, &m.result.cold.held_out])
            .flat_map(|s| &s.by_frequency)
            .map(|(f, _)| *f)
            .collect();
        all.sort_by(f64::total_cmp);
        all.dedup();
        all
    }
}

/// Takes out what does not repeat.
fn without_times(details: &mut Value) {
    if let Some(details) = details.as_object_mut() {
        details.retain(|name, _| !name.ends_with("_s") || name == "time_constant_s");
    }
}

/// Mean ± deviation in words.
#[must_use]
pub fn summary_text(s: &Summary) -> String {
    let Some(mean) = s.mean else { return "–".into() };
    let sd = s.deviation.map_or(String::new(), |d| format!(" ± {}", short(d)));
    let stopped =
        if s.stopped > 0 { format!(" ({} of {} stop)", s.stopped, s.count) } else { String::new() };
    format!("{}{sd}{stopped}", short(mean)).replace('-', "−")
}

/// Three decimals, or powers of ten for large numbers.
fn short(v: f64) -> String {
    if v.abs() < 1000.0 { format!("{v:.3}") } else { format!("{v:.1e}") }
}

/// Seconds in a readable form.
#[must_use]
pub fn seconds(s: f64) -> String {
    if s < 10.0 { format!("{s:.2}") } else { format!("{s:.0}") }
}

fn summary_tex(s: &Summary) -> String {
    let stopped = match s.stopped {
        0 => String::new(),
        n => format!("$^{{\\dagger}}$ ({n} of {})", s.count),
    };
    let Some(mean) = s.mean else { return format!("--{stopped}") };
    let power = |v: f64| {
        let text = short(v);
        match text.split_once('e') {
            Some((digits, exponent)) => format!("{digits}\\cdot 10^{{{exponent}}}"),
            None => text,
        }
    };
    match s.deviation {
        Some(d) => format!("${} \\pm {}${stopped}", power(mean), power(d)),
        None => format!("${}${stopped}", power(mean)),
    }
}

fn tex_text(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => format!("\\{c}"),
            '\\' => "\\textbackslash{}".into(),
            '^' => "\\textasciicircum{}".into(),
            '~' => "\\textasciitilde{}".into(),
            '<' => "\\textless{}".into(),
            '>' => "\\textgreater{}".into(),
            '–' => "--".into(),
            '−' => "$-$".into(),
            c => c.to_string(),
        })
        .collect()
}
