use super::style::{INK, SCALE, TEXT, TITLE, at_nominal_size, draw_axes, padded_range, tick_label};
use plotters::prelude::*;

/// A measured point of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPoint {
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// Value shown as colour; points without a finite value are drawn hollow.
    pub value: f64,
}

/// Values over a plane, as coloured squares with a colour bar.
#[derive(Debug, Clone)]
pub struct ColourMap {
    /// Title above the axes.
    pub title: String,
    /// Label and unit of the horizontal axis.
    pub x_label: String,
    /// Label and unit of the vertical axis.
    pub y_label: String,
    /// Name and unit of the value.
    pub value_label: String,
    /// The points.
    pub points: Vec<MapPoint>,
    /// Values at the ends of the colour scale; values outside take the end's colour.
    pub limits: (f64, f64),
    /// Width and height, px.
    pub size: (u32, u32),
}

impl ColourMap {
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

    fn colour(&self, value: f64) -> RGBColor {
        let (low, high) = self.limits;
        ViridisRGB::get_color_normalized(value.clamp(low, high), low, high)
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let (width, height) = (self.size.0 * SCALE, self.size.1 * SCALE);
        let root = SVGBackend::with_string(svg, (width, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let (plane, bar) = root.split_horizontally(width - 104 * SCALE);
        let title = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
        let (x0, x1) = padded_range(self.points.iter().map(|p| p.x), 0.08);
        let (y0, y1) = padded_range(self.points.iter().map(|p| p.y), 0.08);
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
        let columns = (self.points.len() as f64).sqrt().clamp(4.0, 15.0);
        let half = (f64::from(self.size.0.min(self.size.1)) * 0.3 / columns).max(4.0) as i32;
        let half = half * SCALE as i32;
        chart.draw_series(self.points.iter().map(|p| {
            let style = if p.value.is_finite() {
                self.colour(p.value).filled()
            } else {
                INK.stroke_width(SCALE)
            };
            EmptyElement::at((p.x, p.y)) + Rectangle::new([(-half, -half), (half, half)], style)
        }))?;
        self.draw_bar(&bar)?;
        root.present()?;
        Ok(())
    }

    fn draw_bar(
        &self,
        bar: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let (low, high) = self.limits;
        let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
        let mut chart = ChartBuilder::on(bar)
            .margin(8 * SCALE)
            .margin_top(36 * SCALE)
            .margin_bottom(46 * SCALE)
            .margin_right(14 * SCALE)
            .y_label_area_size(58 * SCALE)
            .build_cartesian_2d(0.0..1.0, low..high)?;
        let steps = 64;
        let edge = |k: i32| low + (high - low) * f64::from(k) / f64::from(steps);
        chart.draw_series((0..steps).map(|k| {
            let colour = self.colour(0.5 * (edge(k) + edge(k + 1)));
            Rectangle::new([(0.0, edge(k)), (1.0, edge(k + 1))], colour.filled())
        }))?;
        chart
            .configure_mesh()
            .disable_mesh()
            .disable_x_axis()
            .y_desc(&self.value_label)
            .y_labels(6)
            .label_style(text.clone())
            .axis_desc_style(text)
            .y_label_formatter(&|v| tick_label(*v, high - low))
            .draw()?;
        Ok(())
    }
}
