//! Figures as SVG text.

mod colour_bar;
mod colour_map;
mod decimate;
mod header;
mod line;
mod polygon_map;
mod scale;
mod style;
mod value_plane;

pub use colour_map::{ColourMap, MapPoint};
pub use decimate::{envelope, thin};
pub use line::{Band, LineFigure, Series};
pub use polygon_map::{PolygonMap, ValuedPolygon};
pub use scale::Scale;
pub use style::{Role, Stroke};
pub use value_plane::ValuePlane;
