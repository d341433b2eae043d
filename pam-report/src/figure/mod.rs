//! Figures as SVG text.

mod colour_bar;
mod colour_map;
mod decimate;
mod header;
mod line;
mod polygon_map;
mod scale;
mod series;
mod style;
mod value_plane;

pub use colour_map::{ColourMap, MapPoint};
pub use decimate::{envelope, thin};
pub use line::{Band, LineFigure};
pub use polygon_map::{PolygonMap, ValuedPolygon};
pub use scale::Scale;
pub use series::Series;
pub use style::{Role, Stroke};
pub use value_plane::ValuePlane;
