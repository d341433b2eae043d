use super::frame::{Entry, Frame, FrameAxis, PlacedBand, RIGHT};
use super::path::{UNITS, path_through};
use super::scale::{Axis, Scale};
use super::series::Series;
use super::style::{Role, Stroke, TEXT, coloured};
use maud::{Markup, html};

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
///
/// ```
/// use pam_report::{LineFigure, Role};
///
/// let line = (0..100).map(|k| 0.1 * f64::from(k)).map(|t| (t, t.sin())).collect();
/// let svg = LineFigure::new("", "time (s)", "displacement (mm)", 640, 240)
///     .with("measured", Role::Measured, line)
///     .to_svg();
/// assert!(svg.starts_with("<svg") && svg.contains("displacement (mm)"));
/// ```
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
    #[must_use]
    pub fn to_svg(&self) -> String {
        let place = |p: &(f64, f64)| (self.x_scale.place(p.0), self.y_scale.place(p.1));
        let finite = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
        let places = || self.series.iter().flat_map(|s| &s.points).map(place).filter(finite);
        let ticks = ((self.width / 70).max(3) as usize, (self.height / 38).max(3) as usize);
        // Bands begin and end where they do in figures without marks.
        let margin = if self.marks && self.bands.is_empty() { 0.04 } else { 0.01 };
        let edges = self.bands.iter().flat_map(|b| [b.from, b.to]).map(|x| self.x_scale.place(x));
        let x = self.x_scale.axis(places().map(|p| p.0).chain(edges), margin, ticks.0);
        // The names of bands stand above the lines.
        let named = f64::from(TEXT + 6) / f64::from(self.height.max(160) - 85);
        let margin = if self.bands.is_empty() { 0.06 } else { named.max(0.06) };
        let covered = self.covers.iter().map(|&y| self.y_scale.place(y)).filter(|y| y.is_finite());
        let y = self.y_scale.axis(places().map(|p| p.1).chain(covered), margin, ticks.1);
        let frame = Frame {
            title: &self.title,
            size: (self.width, self.height),
            x: FrameAxis { label: &self.x_label, axis: &x, scale: self.x_scale },
            y: FrameAxis { label: &self.y_label, axis: &y, scale: self.y_scale },
            entries: self.entries(),
            bands: self.placed_bands(&x),
            right: RIGHT,
            cut: false,
        };
        let plot = frame.plot();
        let verticals = self
            .verticals
            .iter()
            .map(|(at, role)| (self.x_scale.place(*at), role))
            .filter(|(at, _)| (x.low..=x.high).contains(at));
        let content = html! {
            @for (at, role) in verticals {
                (coloured(role.colour(), &line(&format!("M{} 0v{UNITS}", x.unit(at)), Stroke::Dotted)))
            }
            @for series in &self.series {
                @let points: Vec<(i64, i64)> = series.points.iter().map(place).filter(finite)
                    .map(|p| (x.unit(p.0), y.unit_down(p.1))).collect();
                @if !points.is_empty() {
                    (coloured(series.role.colour(), &html! {
                        (line(&path_through(points.iter().copied()), series.stroke))
                        @if self.marks || series.points.len() == 1 { @for point in points {
                            (plot.mark(point, &html! { circle r="3" fill="currentColor" {} }))
                        } }
                    }))
                }
            }
        };
        frame.to_svg(&content, &html! {})
    }

    /// The legend: a sample of each named line.
    fn entries(&self) -> Vec<Entry<'_>> {
        let named = self.series.iter().filter(|s| !s.label.is_empty());
        named
            .map(|s| Entry {
                label: &s.label,
                sample: coloured(
                    s.role.colour(),
                    &html! {
                        path d="M0 0h22" fill="none" stroke="currentColor" stroke-width="2" stroke-dasharray=[s.stroke.dashes()] {}
                    },
                ),
            })
            .collect()
    }

    fn placed_bands(&self, axis: &Axis) -> Vec<PlacedBand<'_>> {
        let place = |x: f64| self.x_scale.place(x).clamp(axis.low, axis.high);
        let placed = |b: &'_ Band| (place(b.from), place(b.to));
        self.bands
            .iter()
            .map(|b| (b, placed(b)))
            .filter(|(_, (from, to))| from.is_finite() && to.is_finite())
            .map(|(b, (from, to))| PlacedBand { label: &b.label, from, to })
            .collect()
    }
}

/// A line whose width does not grow with the figure.
fn line(path: &str, stroke: Stroke) -> Markup {
    html! {
        path d=(path) fill="none" stroke="currentColor" stroke-width=(stroke.width()) stroke-linejoin="round"
            stroke-dasharray=[stroke.dashes()] vector-effect="non-scaling-stroke" {}
    }
}
