//! Reports of plans, tests and maps, as self-contained HTML text.

mod identification;
mod maps;
mod mpc;
mod plan;
mod tracking;

pub use identification::{IdentificationReport, identification_report};
pub use maps::stiffness_report;
pub use mpc::{MpcReport, mpc_report};
pub use plan::plan_report;
pub use tracking::tracking_report;

use pam_report::figure::{LineFigure, Role, envelope};

/// Pixel columns of a time series.
const BUCKETS: usize = 700;

/// A wide figure of series over time.
fn over_time(y_label: &str, time_s: &[f64], series: &[(&str, Role, Vec<f64>)]) -> String {
    let mut figure = LineFigure::new("", "time (s)", y_label, 1040, 230);
    for (label, role, values) in series {
        figure = figure.with(label, *role, envelope(time_s, values, BUCKETS));
    }
    figure.to_svg()
}
