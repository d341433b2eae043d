//! Figures as SVG text.

mod colour_map;
mod decimate;
mod line;
mod style;

pub use colour_map::{ColourMap, MapPoint};
pub use decimate::{envelope, thin};
pub use line::{LineFigure, Series};
pub use style::Role;
