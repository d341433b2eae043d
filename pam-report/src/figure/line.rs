use super::style::{INK, Role, SCALE, TEXT, TITLE, at_nominal_size, draw_axes, padded_range};
use plotters::prelude::*;

/// One line of a figure.
#[derive(Debug, Clone)]
pub struct Series {
    /// Name in the legend; no entry if empty.
    pub label: String,
    /// Points in the order they are joined.
    pub points: Vec<(f64, f64)>,
    /// What the line stands for.
    pub role: Role,
}

/// A figure of lines.
#[derive(Debug, Clone)]
pub struct LineFigure {
    /// Title above the axes.
    pub title: String,
    /// Label and unit of the horizontal axis.
    pub x_label: String,
    /// Label and unit of the vertical axis.
    pub y_label: String,
    /// The lines, drawn in order.
    pub series: Vec<Series>,
    /// Width, px.
    pub width: u32,
    /// Height, px.
    pub height: u32,
}

impl LineFigure {
    /// An empty figure.
    #[must_use]
    pub fn new(title: &str, x_label: &str, y_label: &str, width: u32, height: u32) -> Self {
        Self {
            title: title.into(),
            x_label: x_label.into(),
            y_label: y_label.into(),
            series: Vec::new(),
            width,
            height,
        }
    }

    /// Adds a line.
    #[must_use]
    pub fn with(mut self, label: &str, role: Role, points: Vec<(f64, f64)>) -> Self {
        self.series.push(Series { label: label.into(), points, role });
        self
    }

    /// The figure as SVG text.
    ///
    /// # Panics
    /// Never: drawing into memory cannot fail.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let mut svg = String::new();
        self.draw(&mut svg).expect("drawing into memory cannot fail");
        at_nominal_size(&svg, self.width, self.height)
    }

    fn draw(&self, svg: &mut String) -> Result<(), Box<dyn std::error::Error>> {
        let size = (self.width * SCALE, self.height * SCALE);
        let root = SVGBackend::with_string(svg, size).into_drawing_area();
        root.fill(&WHITE)?;
        let points = || self.series.iter().flat_map(|s| &s.points);
        let (x0, x1) = padded_range(points().map(|p| p.0), 0.01);
        let (y0, y1) = padded_range(points().map(|p| p.1), 0.06);
        self.draw_header(&root)?;
        let mut builder = ChartBuilder::on(&root);
        builder
            .margin(8 * SCALE)
            .margin_top((TITLE + 14) * SCALE)
            .margin_right(16 * SCALE)
            .x_label_area_size(40 * SCALE)
            .y_label_area_size(62 * SCALE);
        let mut chart = builder.build_cartesian_2d(x0..x1, y0..y1)?;
        draw_axes(
            &mut chart,
            (&self.x_label, &self.y_label),
            ((self.width / 70).max(3) as usize, (self.height / 38).max(3) as usize),
        )?;
        for series in &self.series {
            let style = series.role.colour().stroke_width(SCALE + 1);
            let finite = series.points.iter().copied().filter(|p| p.1.is_finite());
            chart.draw_series(LineSeries::new(finite, style))?;
        }
        root.present()?;
        Ok(())
    }

    /// Title at the left and legend at the right, above the axes where they hide nothing.
    fn draw_header(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<(), Box<dyn std::error::Error>> {
        let scale = SCALE as i32;
        let baseline = 8 * scale;
        let title = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
        root.draw(&Text::new(self.title.clone(), (70 * scale, baseline), title))?;
        let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
        let mut right = (self.width as i32 - 16) * scale;
        for series in self.series.iter().rev().filter(|s| !s.label.is_empty()) {
            // Text is drawn by the reader's browser; its width can only be estimated.
            let width = (series.label.chars().count() as f64 * f64::from(TEXT) * 0.56) as i32;
            right -= width * scale;
            root.draw(&Text::new(series.label.clone(), (right, baseline), text.clone()))?;
            let middle = baseline + (TEXT as i32 * scale) / 2;
            let line = [(right - 26 * scale, middle), (right - 6 * scale, middle)];
            let style = series.role.colour().stroke_width(2 * SCALE);
            root.draw(&PathElement::new(line, style))?;
            right -= 42 * scale;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_figure_names_its_axes_and_survives_odd_data() {
        let nan = vec![(0.0, f64::NAN), (1.0, 2.0)];
        let figure = LineFigure::new("Title", "time (s)", "force (N)", 300, 200)
            .with("measured", Role::Measured, nan)
            .with("", Role::Residual, vec![]);
        let svg = figure.to_svg();
        for part in
            ["width=\"300\" height=\"200\"", "viewBox=\"0 0 600 400\"", "time (s)", "measured"]
        {
            assert!(svg.contains(part), "{part}");
        }
        let empty = LineFigure::new("", "", "", 300, 200).to_svg();
        assert!(empty.ends_with("</svg>\n"));
    }
}
