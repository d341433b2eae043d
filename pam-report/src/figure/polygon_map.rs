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
                let colour = colour(polygon.value, self.plane.limits);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_polygon_is_drawn_in_the_colour_of_its_value() {
        let square = |x: f64, value: f64| ValuedPolygon {
            corners: vec![[x, 0.0], [x + 1.0, 0.0], [x + 1.0, 1.0], [x, 1.0]],
            value,
        };
        let svg = PolygonMap {
            plane: ValuePlane {
                title: "Map".into(),
                x_label: "x".into(),
                y_label: "v".into(),
                value_label: "K".into(),
                limits: (10.0, 20.0),
                size: (520, 400),
            },
            polygons: vec![square(0.0, 10.0), square(1.0, 20.0), square(2.0, 99.0)],
            window: [[0.0, 3.0], [0.0, 1.0]],
        }
        .to_svg();
        let fills: Vec<&str> = svg
            .split("<polygon")
            .skip(1)
            .map(|p| p.split("fill=\"").nth(1).and_then(|f| f.split('"').next()).unwrap())
            .collect();
        assert_eq!(fills.len(), 3);
        assert_ne!(fills[0], fills[1]);
        assert_eq!(fills[1], fills[2], "beyond the scale its end counts");
    }
}
