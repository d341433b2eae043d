//! Pages whose numbers and tables come from the results.
//!
//! | marker | is replaced by |
//! |---|---|
//! | `<!--= peers.pam_s -->0.714<!--/-->` | the number, with as many digits as it has |
//! | `<!--= peers.pam_s .2 -->0.71<!--/-->` | two decimals; `.1e` two digits and a power of ten, `.1%` in per cent, `.2g` two digits |
//! | `<!--= peers.jax_s / peers.pam_s .1 -->1.9<!--/-->` | a ratio of two numbers of one study |
//! | `<!--# peers.gradient -->` … `<!--/-->` | the table |
//!
//! Browsers, GitHub and mdBook hide the comments. Code blocks are left alone.

use super::{Results, ResultsError, Table};
use serde_json::Value;
use std::path::{Path, PathBuf};

const END: &str = "<!--/-->";

/// The pages with results: README, CHANGELOG, CONTRIBUTING and the files of `docs/` and `docs/studies/`.
///
/// # Errors
/// [`ResultsError::File`] if `docs/` cannot be listed.
pub fn pages(root: &Path) -> Result<Vec<PathBuf>, ResultsError> {
    let docs = root.join("docs");
    let entries = std::fs::read_dir(&docs).map_err(|e| pam_data::DataError::io(&docs, e))?;
    let studies = std::fs::read_dir(docs.join("studies")).into_iter().flatten();
    let mut pages: Vec<PathBuf> = entries
        .chain(studies)
        .filter_map(|entry| entry.ok().map(|e| e.path()))
        .filter(|path| path.extension().is_some_and(|e| e == "md"))
        .collect();
    pages.extend(["README.md", "CHANGELOG.md", "CONTRIBUTING.md"].map(|name| root.join(name)));
    pages.sort();
    Ok(pages)
}

/// The page with what its markers ask for.
///
/// # Errors
/// [`ResultsError::Unknown`] if no study has a number or a table, [`ResultsError::Marker`] if a marker has no end or cannot be
/// read.
pub fn fill(page: &str, results: &Results) -> Result<String, ResultsError> {
    let mut out = String::with_capacity(page.len());
    let mut rest = page;
    while let Some(start) = next_marker(page, page.len() - rest.len()) {
        let line = 1 + page[..start].matches('\n').count();
        let wrong = |message: &str| ResultsError::Marker { line, message: message.into() };
        let marker = &page[start..];
        let head = marker.find("-->").ok_or_else(|| wrong("`-->` is missing"))? + 3;
        let end = marker.find(END).ok_or_else(|| wrong("`<!--/-->` is missing"))?;
        if end < head {
            return Err(wrong("`-->` is missing"));
        }
        out.push_str(&rest[..start - (page.len() - rest.len())]);
        out.push_str(&marker[..head]);
        let what = marker[5..head - 3].trim();
        if marker.starts_with("<!--#") {
            out.push_str("\n\n");
            out.push_str(&to_markdown(results.table(what)?));
            out.push('\n');
        } else {
            out.push_str(&number(what, results).map_err(|e| match e {
                ResultsError::Marker { message, .. } => wrong(&message),
                other => other,
            })?);
        }
        out.push_str(END);
        rest = &marker[end + END.len()..];
    }
    out.push_str(rest);
    Ok(out)
}

/// Where the next marker outside of code begins.
fn next_marker(page: &str, from: usize) -> Option<usize> {
    let mut at = from;
    loop {
        let found = ["<!--= ", "<!--# "].iter().filter_map(|m| page[at..].find(m)).min()? + at;
        let fences = page[..found].lines().filter(|l| l.trim_start().starts_with("```")).count();
        if fences % 2 == 0 && !page[..found].ends_with('`') {
            return Some(found);
        }
        at = found + 5;
    }
}

/// `A.B`, `A.B .2` or `A.B / A.C .2`.
fn number(what: &str, results: &Results) -> Result<String, ResultsError> {
    let words: Vec<&str> = what.split_whitespace().collect();
    let (value, format) = match words[..] {
        [name] => (results.number(name)?, None),
        [name, format] => (results.number(name)?, Some(format)),
        [name, "/", over] => (results.number(name)? / results.number(over)?, None),
        [name, "/", over, format] => (results.number(name)? / results.number(over)?, Some(format)),
        _ => return Err(unreadable(what)),
    };
    shown(value, format).ok_or_else(|| unreadable(what))
}

fn unreadable(what: &str) -> ResultsError {
    let message =
        format!("`{what}` is not `STUDY.KEY`, `STUDY.KEY .2` or `STUDY.KEY / STUDY.KEY .2`");
    ResultsError::Marker { line: 0, message }
}

fn shown(value: f64, format: Option<&str>) -> Option<String> {
    let Some(format) = format else { return Some(minus(&value.to_string())) };
    let format = format.strip_prefix('.')?;
    let kind = format.trim_start_matches(|c: char| c.is_ascii_digit());
    let digits: usize = format[..format.len() - kind.len()].parse().ok()?;
    Some(minus(&match kind {
        "" => format!("{value:.digits$}"),
        "%" => format!("{:.digits$}", 100.0 * value),
        "%-" => format!("{:.digits$}", 100.0 * (1.0 - value)),
        "e" => format!("{value:.digits$e}"),
        "g" => {
            let magnitude = value.abs().log10().floor() as i32;
            let decimals = usize::try_from(digits as i32 - 1 - magnitude).unwrap_or(0);
            format!("{value:.decimals$}")
        }
        _ => return None,
    }))
}

fn minus(number: &str) -> String {
    number.replace('-', "−").replace("e−", "e-")
}

/// The table in Markdown.
#[must_use]
pub fn to_markdown(table: &Table) -> String {
    let mut text = format!("| {} |\n|", table.columns.join(" | "));
    text += &"---|".repeat(table.columns.len());
    text.push('\n');
    for row in &table.rows {
        let cells: Vec<String> = row
            .iter()
            .enumerate()
            .map(|(k, cell)| {
                let decimals = table.decimals.get(k).copied().flatten();
                match (cell, cell.as_f64()) {
                    (Value::Null, _) => "–".into(),
                    (_, Some(number)) => minus(&match decimals {
                        Some(decimals) => format!("{number:.decimals$}"),
                        None => cell.to_string(),
                    }),
                    (Value::String(text), None) => match text.as_str() {
                        "true" => "yes".into(),
                        "false" => "no".into(),
                        text => text.to_owned(),
                    },
                    (other, None) => other.to_string(),
                }
            })
            .collect();
        text += &format!("| {} |\n", cells.join(" | "));
    }
    text
}
