use super::colour_bar::colour;
use super::value_plane::ValuePlane;
use plotters::prelude::*;

/// A polygon with a value.
#[derive(Debug, Clone, PartialEq)]
pub struct ValuedPolygon {
    /// Corners in order.
    pub corners: Vec<[f64; 2]>,
    /// Value shown as colour.
    pub value: f64,
}

/// A plane cut into polygons, each coloured by its value, with a colour bar.
#[derive(Debug, Clone)]
pub struct PolygonMap {
    /// Title, axes and colours.
    pub plane: ValuePlane,
    /// The polygons.
    pub polygons: Vec<ValuedPolygon>,
    /// Least and largest shown of the horizontal and of the vertical axis.
    pub window: [[f64; 2]; 2],
}

impl PolygonMap {
    /// The map as SVG text.
    ///
    /// # Panics
    /// Never: drawing into memory cannot fail.
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.plane.to_svg(self.window, |_, plane| {
            for polygon in &self.polygons {
                let colour = colour(polygon.value, self.plane.scale());
                let mut corners: Vec<(f64, f64)> =
                    polygon.corners.iter().map(|c| (c[0], c[1])).collect();
                plane.draw_series([Polygon::new(corners.clone(), colour.filled())])?;
                // A line of the same colour closes the seam to the neighbours.
                corners.extend(corners.first().copied());
                plane.draw_series([PathElement::new(corners, colour.stroke_width(1))])?;
            }
            Ok(())
        })
    }
}
