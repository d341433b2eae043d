use super::scale::Scale;
use super::style::{INK, Role, SCALE, TEXT, TITLE, at_nominal_size, draw_axes};
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
    /// How numbers are laid along the horizontal axis.
    pub x_scale: Scale,
    /// How numbers are laid along the vertical axis.
    pub y_scale: Scale,
    /// Whether every point has a mark, for measurements that a line only guides the eye between.
    pub marks: bool,
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
            x_scale: Scale::Linear,
            y_scale: Scale::Linear,
            marks: false,
            series: Vec::new(),
            width,
            height,
        }
    }

    /// The figure with other scales.
    #[must_use]
    pub fn with_scales(mut self, x_scale: Scale, y_scale: Scale) -> Self {
        (self.x_scale, self.y_scale) = (x_scale, y_scale);
        self
    }

    /// The figure with a mark at every point.
    #[must_use]
    pub fn with_marks(mut self) -> Self {
        self.marks = true;
        self
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
        let place = |p: &(f64, f64)| (self.x_scale.place(p.0), self.y_scale.place(p.1));
        let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let places = || self.series.iter().flat_map(|s| &s.points).map(place).filter(finite);
        let ticks = ((self.width / 70).max(3) as usize, (self.height / 38).max(3) as usize);
        let margin = if self.marks { 0.04 } else { 0.01 };
        let x_axis = self.x_scale.axis(places().map(|p| p.0), margin, ticks.0);
        let y_axis = self.y_scale.axis(places().map(|p| p.1), 0.06, ticks.1);
        let spans = (x_axis.span(), y_axis.span());
        let header = self.draw_header(&root)?;
        let mut builder = ChartBuilder::on(&root);
        builder
            .margin(8 * SCALE)
            .margin_top(header)
            .margin_right(16 * SCALE)
            .x_label_area_size(40 * SCALE)
            .y_label_area_size(62 * SCALE);
        let mut chart = builder.build_cartesian_2d(x_axis, y_axis)?;
        draw_axes(
            &mut chart,
            (&self.x_label, &self.y_label),
            ticks,
            (&|v| self.x_scale.label(v, spans.0), &|v| self.y_scale.label(v, spans.1)),
        )?;
        for series in &self.series {
            let colour = series.role.colour();
            let points = || series.points.iter().map(place).filter(finite);
            chart.draw_series(LineSeries::new(points(), colour.stroke_width(SCALE + 1)))?;
            if self.marks {
                let mark = |p| Circle::new(p, 3 * SCALE, colour.filled());
                chart.draw_series(points().map(mark))?;
            }
        }
        root.present()?;
        Ok(())
    }

    /// Title at the left and legend at the right, above the axes where they hide nothing, the legend in
    /// as many rows as it needs. Returns the height of it all.
    fn draw_header(
        &self,
        root: &DrawingArea<SVGBackend<'_>, plotters::coord::Shift>,
    ) -> Result<u32, Box<dyn std::error::Error>> {
        let scale = SCALE as i32;
        // Text is drawn by the reader's browser; its width can only be estimated.
        let width = |text: &str, size: u32| {
            (text.chars().count() as f64 * f64::from(size) * 0.56) as i32 * scale
        };
        let left = 70 * scale;
        let title = ("sans-serif", TITLE * SCALE).into_font().color(&INK);
        root.draw(&Text::new(self.title.clone(), (left, 8 * scale), title))?;
        let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
        let gap = 42 * scale;
        let entries: Vec<&Series> = self.series.iter().filter(|s| !s.label.is_empty()).collect();
        let whole = (self.width as i32 - 16) * scale;
        // The first row shares its line with the title.
        let mut room = whole - left - width(&self.title, TITLE);
        let mut rows: Vec<Vec<&Series>> = vec![Vec::new()];
        for entry in entries {
            let needed = width(&entry.label, TEXT) + gap;
            if needed > room {
                rows.push(Vec::new());
                room = whole - left;
            }
            room -= needed;
            if let Some(row) = rows.last_mut() {
                row.push(entry);
            }
        }
        let mut baseline = 8 * scale;
        let height = (TEXT as i32 + 7) * scale;
        for row in &rows {
            let mut right = whole;
            for series in row.iter().rev() {
                right -= width(&series.label, TEXT);
                root.draw(&Text::new(series.label.clone(), (right, baseline), text.clone()))?;
                let middle = baseline + (TEXT as i32 * scale) / 2;
                let line = [(right - 26 * scale, middle), (right - 6 * scale, middle)];
                let style = series.role.colour().stroke_width(2 * SCALE);
                root.draw(&PathElement::new(line, style))?;
                right -= gap;
            }
            baseline += height;
        }
        let extra = (rows.len() as u32 - 1) * height.unsigned_abs();
        Ok((TITLE + 14) * SCALE + extra)
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

    #[test]
    fn logarithmic_axes_leave_out_what_they_cannot_show_and_legends_take_rows() {
        let mut figure = LineFigure::new("Errors", "time (s)", "error", 300, 200)
            .with_scales(Scale::Logarithmic, Scale::Logarithmic)
            .with_marks();
        for k in 0..5 {
            let points = vec![(1e-3, 1e-9), (1.0, 0.0), (10.0, 1e-2)];
            figure = figure.with(&format!("method number {k}"), Role::Category(k), points);
        }
        let svg = figure.to_svg();
        assert_eq!(svg.matches("<circle").count(), 2 * 5, "zero has no place");
        for part in ["10⁻⁸", "0.01", "method number 4"] {
            assert!(svg.contains(part), "{part}");
        }
    }
}
