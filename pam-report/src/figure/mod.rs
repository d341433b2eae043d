//! Figures as SVG text.
//!
//! A figure is a frame (title, legend, axes) around content that is drawn in the units of its axes. The page's script
//! reads the frame's `data-` attributes, so that a reader can zoom, and lays the figure out again at another width. A figure
//! outside a page needs neither script nor style.

mod colour_bar;
mod colour_map;
mod decimate;
mod frame;
mod heat_table;
mod line;
mod path;
mod polygon_map;
mod scale;
mod series;
mod style;
mod value_plane;

pub use colour_map::{ColourMap, MapPoint};
pub use decimate::{envelope, thin};
pub use heat_table::HeatTable;
pub use line::{Band, LineFigure};
pub use polygon_map::{PolygonMap, ValuedPolygon};
pub use scale::Scale;
pub use series::Series;
pub(crate) use style::PALETTE;
pub use style::{Role, Stroke};
pub use value_plane::ValuePlane;
