use super::header::{draw_header, text_width};
use super::scale::Scale;
use super::series::Series;
use super::style::{AxisLabels, BAND, Role, SCALE, Stroke, TEXT, at_nominal_size, draw_axes};
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

/// A stretch of the horizontal axis; every other one has a ground of its own.
#[derive(Debug, Clone, PartialEq)]
pub struct Band {
    /// Where it begins.
    pub from: f64,
    /// Where it ends.
    pub to: f64,
    /// Name at its top, left out where the stretch is too narrow for it.
    pub label: String,
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
    /// True if every point has a mark, for measurements between which a line only guides the eye.
    pub marks: bool,
    /// The lines, drawn in order.
    pub series: Vec<Series>,
    /// Dotted lines over the whole height, behind the series.
    pub verticals: Vec<(f64, Role)>,
    /// Stretches of the horizontal axis, behind everything.
    pub bands: Vec<Band>,
    /// Values that the vertical axis covers besides the points: figures that share them have the same axis.
    pub covers: Vec<f64>,
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
            verticals: Vec::new(),
            bands: Vec::new(),
            covers: Vec::new(),
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
    pub fn with(self, label: &str, role: Role, points: Vec<(f64, f64)>) -> Self {
        self.with_stroke(label, role, Stroke::Solid, points)
    }

    /// Adds a line of some stroke.
    #[must_use]
    pub fn with_stroke(
        mut self,
        label: &str,
        role: Role,
        stroke: Stroke,
        points: Vec<(f64, f64)>,
    ) -> Self {
        self.series.push(Series { label: label.into(), points, role, stroke });
        self
    }

    /// The figure with a vertical axis that covers these values too.
    #[must_use]
    pub fn covering(mut self, values: impl IntoIterator<Item = f64>) -> Self {
        self.covers.extend(values);
        self
    }

    /// Adds a dotted line over the whole height at `x`.
    #[must_use]
    pub fn with_vertical(mut self, x: f64, role: Role) -> Self {
        self.verticals.push((x, role));
        self
    }

    /// The figure with these bands; the second, the fourth and so on have a ground of their own.
    #[must_use]
    pub fn with_bands(mut self, bands: Vec<Band>) -> Self {
        self.bands = bands;
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
        // Bands begin and end where they do in figures without marks.
        let margin = if self.marks && self.bands.is_empty() { 0.04 } else { 0.01 };
        let edges = self.bands.iter().flat_map(|b| [b.from, b.to]).map(|x| self.x_scale.place(x));
        let x_axis = self.x_scale.axis(places().map(|p| p.0).chain(edges), margin, ticks.0);
        // The names of bands stand above the lines.
        let named = f64::from(TEXT + 6) / f64::from(self.height.max(160) - 85);
        let margin = if self.bands.is_empty() { 0.06 } else { named.max(0.06) };
        let covered = self.covers.iter().map(|&y| self.y_scale.place(y)).filter(|y| y.is_finite());
        let y_axis = self.y_scale.axis(places().map(|p| p.1).chain(covered), margin, ticks.1);
        let spans = (x_axis.span(), y_axis.span());
        let (x_range, y_range) = ((x_axis.low, x_axis.high), (y_axis.low, y_axis.high));
        let header = draw_header(&root, &self.title, &self.series, self.width)?;
        let mut builder = ChartBuilder::on(&root);
        builder
            .margin(8 * SCALE)
            .margin_top(header)
            .margin_right(16 * SCALE)
            .x_label_area_size(40 * SCALE)
            .y_label_area_size(62 * SCALE);
        let mut chart = builder.build_cartesian_2d(x_axis, y_axis)?;
        let bands = || {
            let place = |x: f64| self.x_scale.place(x).clamp(x_range.0, x_range.1);
            let placed = self.bands.iter().enumerate();
            placed
                .map(move |(k, band)| (k, band, place(band.from), place(band.to)))
                .filter(|(_, _, from, to)| from.is_finite() && to.is_finite())
        };
        chart.draw_series(bands().filter(|(k, ..)| k % 2 == 1).map(|(_, _, from, to)| {
            Rectangle::new([(from, y_range.0), (to, y_range.1)], BAND.filled())
        }))?;
        draw_axes(
            &mut chart,
            AxisLabels {
                label: &self.x_label,
                ticks: ticks.0,
                format: &|v| self.x_scale.label(v, spans.0),
            },
            AxisLabels {
                label: &self.y_label,
                ticks: ticks.1,
                format: &|v| self.y_scale.label(v, spans.1),
            },
        )?;
        let shown = f64::from(self.width.saturating_sub(62 + 16 + 16)) / spans.0;
        let text = ("sans-serif", TEXT * SCALE).into_font().color(&Role::Neutral.colour());
        let text = text.pos(Pos::new(HPos::Center, VPos::Top));
        chart.draw_series(
            bands()
                .filter(|(_, band, from, to)| (to - from) * shown > text_width(&band.label, TEXT))
                .map(|(_, band, from, to)| {
                    Text::new(band.label.clone(), (0.5 * (from + to), y_range.1), text.clone())
                }),
        )?;
        let (dash, gap) = (SCALE, 3 * SCALE);
        for (x, role) in &self.verticals {
            let x = self.x_scale.place(*x);
            if (x_range.0..=x_range.1).contains(&x) {
                let style = role.colour().stroke_width(SCALE);
                let line = [(x, y_range.0), (x, y_range.1)];
                chart.draw_series(DashedLineSeries::new(line, dash, gap, style))?;
            }
        }
        for series in &self.series {
            let colour = series.role.colour();
            let points = || series.points.iter().map(place).filter(finite);
            match series.stroke.pattern() {
                None => {
                    let style = colour.stroke_width(SCALE + 1);
                    chart.draw_series(LineSeries::new(points(), style))?
                }
                Some((dash, gap)) => {
                    let style = colour.stroke_width(SCALE);
                    chart.draw_series(DashedLineSeries::new(points(), dash, gap, style))?
                }
            };
            if self.marks || series.points.len() == 1 {
                let mark = |p| Circle::new(p, 3 * SCALE, colour.filled());
                chart.draw_series(points().map(mark))?;
            }
        }
        root.present()?;
        Ok(())
    }
}
