//! Output of a running command: text, JSON and progress.

use crate::arguments::GlobalOptions;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use pam_data::Recording;
use serde_json::Value;
use std::io::Write;
use std::sync::Mutex;

/// Text, JSON and progress, according to the global options.
#[derive(Debug, Clone, Copy)]
pub struct Console {
    json: bool,
    quiet: bool,
}

impl Console {
    /// A console as the options ask for.
    #[must_use]
    pub fn new(options: &GlobalOptions) -> Self {
        Self { json: options.json, quiet: options.quiet }
    }

    /// Prints text unless JSON is asked for or the console is quiet.
    pub fn text(&self, text: impl AsRef<str>) {
        if !self.json && !self.quiet {
            print_line(text.as_ref());
        }
    }

    /// Prints the notes of a recording on the error stream unless the console is quiet.
    pub fn notes(&self, recording: &Recording) {
        if !self.quiet {
            for note in &recording.notes {
                eprintln!("note: {}: {note}", recording.name);
            }
        }
    }

    /// Prints a warning on the error stream unless the console is quiet.
    pub fn warn(&self, text: impl AsRef<str>) {
        if !self.quiet {
            eprintln!("warning: {}", text.as_ref());
        }
    }

    /// Prints JSON if it is asked for.
    pub fn json(&self, value: &Value) {
        if self.json {
            print_line(&format!("{value:#}"));
        }
    }

    /// A progress bar over `total` items with time left; hidden when quiet or not on a terminal.
    #[must_use]
    pub fn progress(&self, total: usize, what: &'static str) -> ProgressBar {
        let target =
            if self.quiet { ProgressDrawTarget::hidden() } else { ProgressDrawTarget::stderr() };
        let bar = ProgressBar::with_draw_target(Some(total as u64), target).with_message(what);
        let style = "{msg} [{bar:32}] {pos}/{len}  {elapsed} gone, {eta} left";
        if let Ok(style) = ProgressStyle::with_template(style) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar
    }
}

/// The first failure to write to the standard output.
static LOST: Mutex<Option<std::io::Error>> = Mutex::new(None);

/// Prints a line; see [`write_out`].
fn print_line(text: &str) {
    write_out(format!("{text}\n").as_bytes());
}

/// Writes to the standard output. A closed pipe (`pam … | head`) ends the output, as its reader wants; any other failure
/// is kept for [`lost_output`].
pub(crate) fn write_out(bytes: &[u8]) {
    let mut out = std::io::stdout().lock();
    keep(out.write_all(bytes).and_then(|()| out.flush()));
}

fn keep(written: std::io::Result<()>) {
    let Err(error) = written else { return };
    if error.kind() != std::io::ErrorKind::BrokenPipe
        && let Ok(mut lost) = LOST.lock()
    {
        lost.get_or_insert(error);
    }
}

/// Why a part of the standard output is lost, if it is.
pub(crate) fn lost_output() -> Option<std::io::Error> {
    LOST.lock().ok()?.take()
}

/// Aligns rows of cells into columns, the first to the left, the others to the right.
#[must_use]
pub fn table(rows: &[Vec<String>]) -> String {
    let columns = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |c: usize| {
        rows.iter().filter_map(|r| r.get(c)).map(|s| s.chars().count()).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..columns).map(width).collect();
    rows.iter()
        .map(|row| {
            let cells: Vec<String> = row
                .iter()
                .zip(&widths)
                .enumerate()
                .map(
                    |(i, (cell, &w))| {
                        if i == 0 { format!("{cell:<w$}") } else { format!("{cell:>w$}") }
                    },
                )
                .collect();
            format!("  {}", cells.join("  ")).trim_end().to_owned()
        })
        .collect::<Vec<_>>()
        .join("\n")
}
