//! One line of a figure.

use super::style::{Role, Stroke};

/// One line of a figure.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; no entry if empty.
    pub label: String,
    /// Points in the order they are joined; a lone point has a mark.
    pub points: Vec<(f64, f64)>,
    /// Role of the line.
    pub role: Role,
    /// How it is drawn.
    pub stroke: Stroke,
}
