//! Figures as SVG text.

mod colour_map;
mod decimate;
mod line;
mod scale;
mod style;

pub use colour_map::{ColourMap, MapPoint};
pub use decimate::{envelope, thin};
pub use line::{LineFigure, Series};
pub use scale::Scale;
pub use style::Role;
