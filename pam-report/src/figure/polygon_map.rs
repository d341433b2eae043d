use super::colour_bar::{colour, draw_bar};
use super::style::{INK, SCALE, TITLE, at_nominal_size, draw_axes, tick_label};
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
    /// Title above the axes.
    pub title: String,
    /// Label and unit of the horizontal axis.
    pub x_label: String,
    /// Label and unit of the vertical axis.
    pub y_label: String,
    /// Name and unit of the value.
    pub value_label: String,
    /// The polygons.
    pub polygons: Vec<ValuedPolygon>,
    /// Least and largest shown of the horizontal and of the vertical axis.
    pub window: [[f64; 2]; 2],
    /// Values at the ends of the colour scale; values outside take the end's colour.
    pub limits: (f64, f64),
    /// Width and height, px.
    pub size: (u32, u32),
}

impl PolygonMap {
    /// The map as SVG text.
    ///
    /// # Panics
    /// Never: drawing into memory cannot fail.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("drawing into memory cannot fail");
        at_nominal_size(&svg, self.size.0, self.size.1)
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let (width, height) = (self.size.0 * SCALE, self.size.1 * SCALE);
        let root = SVGBackend::with_string(svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (plane, bar) = root.split_horizontally(width - 104 * SCALE);
        let title = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
        let [[x0, x1], [y0, y1]] = self.window;
        let mut chart = ChartBuilder::on(&plane)
            .margin(8 * SCALE)
            .caption(&self.title, title)
            .x_label_area_size(40 * SCALE)
            .y_label_area_size(62 * SCALE)
            .build_cartesian_2d(x0..x1, y0..y1)?;
        draw_axes(
            &mut chart,
            (&self.x_label, &self.y_label),
            (8, 8),
            (&|v| tick_label(v, x1 - x0), &|v| tick_label(v, y1 - y0)),
        )?;
        for polygon in &self.polygons {
            let colour = colour(polygon.value, self.limits);
            let mut corners: Vec<(f64, f64)> =
                polygon.corners.iter().map(|c| (c[0], c[1])).collect();
            chart.draw_series([Polygon::new(corners.clone(), colour.filled())])?;
            // A line of the same colour closes the seam to the neighbours.
            corners.extend(corners.first().copied());
            chart.draw_series([PathElement::new(corners, colour.stroke_width(1))])?;
        }
        draw_bar(&bar, &self.value_label, self.limits)?;
        root.present()?;
        Ok(())
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
            title: "Map".into(),
            x_label: "x".into(),
            y_label: "v".into(),
            value_label: "K".into(),
            polygons: vec![square(0.0, 10.0), square(1.0, 20.0), square(2.0, 99.0)],
            window: [[0.0, 3.0], [0.0, 1.0]],
            limits: (10.0, 20.0),
            size: (520, 400),
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
