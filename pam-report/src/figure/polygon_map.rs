use super::colour_bar::colour;
use super::value_plane::ValuePlane;
use maud::html;

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
    #[must_use]
    pub fn to_svg(&self) -> String {
        self.plane.to_svg(self.window, Vec::new(), |geometry| {
            html! {
                @for polygon in &self.polygons {
                    @let colour = colour(polygon.value, self.plane.scale());
                    @let corners = polygon.corners.iter().map(|c| {
                        let (x, y) = geometry.unit(c[0], c[1]);
                        format!("{x},{y}")
                    }).collect::<Vec<_>>().join(" ");
                    // A line of the same colour closes the seam to the neighbours.
                    polygon points=(corners) fill=(colour) stroke=(colour) stroke-width="0.5" vector-effect="non-scaling-stroke" {}
                }
            }
        })
    }
}
