//! Title, legend and axes around the content of a figure.

use super::path::UNITS;
use super::scale::{Axis, Scale};
use super::style::{BAND, Colour, GRID, GROUND, INK, Role, TEXT, TITLE, coloured, px, text_width};
use maud::{Markup, html};

/// Room left and below the axes, for their labels, px.
const LEFT: f64 = 76.0;
const BELOW: f64 = 48.0;
/// Room right of the axes if nothing stands there, px.
pub(super) const RIGHT: f64 = 16.0;
/// Height of a row of the legend, and room above it, px.
const ROW: f64 = 20.0;
const ABOVE: f64 = 8.0;
/// Length of a sample in the legend with the gap to its text, and gap between entries, px.
const SAMPLE: f64 = 28.0;
const GAP: f64 = 14.0;

/// An axis with its text.
pub(super) struct FrameAxis<'a> {
    pub(super) label: &'a str,
    pub(super) axis: &'a Axis,
    pub(super) scale: Scale,
}

impl FrameAxis<'_> {
    /// `low high scale`, for the page's script.
    fn data(&self) -> String {
        let scale = if self.scale == Scale::Logarithmic { "log" } else { "linear" };
        format!("{} {} {scale}", self.axis.low, self.axis.high)
    }

    /// Position in the share of the axis, and text, of its marks.
    fn marks(&self) -> impl Iterator<Item = (f64, String)> + '_ {
        let (low, span) = (self.axis.low, self.axis.span());
        let marks = self.axis.marks().iter();
        marks.map(move |&v| ((v - low) / span, self.scale.label(v, span)))
    }
}

/// An entry of the legend.
pub(super) struct Entry<'a> {
    pub(super) label: &'a str,
    /// Drawn to the left of the text: 22 px wide, its middle at height 0.
    pub(super) sample: Markup,
}

impl Entry<'_> {
    fn width(&self) -> f64 {
        SAMPLE + text_width(self.label, TEXT)
    }
}

/// A named stretch of the horizontal axis, in its places.
pub(super) struct PlacedBand<'a> {
    pub(super) label: &'a str,
    pub(super) from: f64,
    pub(super) to: f64,
}

/// A figure without its content.
pub(super) struct Frame<'a> {
    pub(super) title: &'a str,
    pub(super) size: (u32, u32),
    pub(super) x: FrameAxis<'a>,
    pub(super) y: FrameAxis<'a>,
    pub(super) entries: Vec<Entry<'a>>,
    /// Every other one has a ground of its own.
    pub(super) bands: Vec<PlacedBand<'a>>,
    /// Room right of the axes, px.
    pub(super) right: f64,
    /// Whether content beyond the axes is cut off.
    pub(super) cut: bool,
}

/// The rectangle between the axes, px.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plot {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Plot {
    /// A place of the content in px.
    pub(super) fn px(&self, (x, y): (i64, i64)) -> (f64, f64) {
        let share = |v: i64| v as f64 / UNITS as f64;
        (self.x + share(x) * self.width, self.y + share(y) * self.height)
    }

    /// A shape drawn in px at a place of the content, which keeps its size; the page's script reads the place from `data-at`.
    pub(super) fn mark(&self, (x, y): (i64, i64), shape: &Markup) -> Markup {
        let scale = |size: f64| format!("{:.2}", UNITS as f64 / size);
        let transform =
            format!("translate({x} {y}) scale({} {})", scale(self.width), scale(self.height));
        html! { g data-at=(format!("{x} {y}")) transform=(transform) { (shape) } }
    }
}

impl<'a> Frame<'a> {
    /// Rows of the legend: each entry with its left end. The first row shares its line with the title.
    fn rows(&self) -> Vec<Vec<(f64, &Entry<'a>)>> {
        let whole = f64::from(self.size.0) - RIGHT;
        let mut room = whole - LEFT - text_width(self.title, TITLE) - GAP;
        let mut rows: Vec<Vec<&Entry<'a>>> = vec![Vec::new()];
        for entry in &self.entries {
            let needed = entry.width() + GAP;
            if needed > room && (rows.len() > 1 || room < whole - LEFT) {
                rows.push(Vec::new());
                room = whole - LEFT;
            }
            room -= needed;
            if let Some(row) = rows.last_mut() {
                row.push(entry);
            }
        }
        rows.into_iter()
            .map(|row| {
                let length: f64 = row.iter().map(|e| e.width() + GAP).sum::<f64>() - GAP;
                let mut left = (whole - length).max(LEFT);
                row.into_iter()
                    .map(|entry| {
                        let at = left;
                        left += entry.width() + GAP;
                        (at, entry)
                    })
                    .collect()
            })
            .collect()
    }

    /// The rectangle between the axes.
    pub(super) fn plot(&self) -> Plot {
        let rows = if self.title.is_empty() && self.entries.is_empty() {
            0.2
        } else {
            self.rows().len() as f64
        };
        let top = ABOVE + ROW * rows;
        Plot {
            x: LEFT,
            y: top,
            width: (f64::from(self.size.0) - LEFT - self.right).max(1.0),
            height: (f64::from(self.size.1) - top - BELOW).max(1.0),
        }
    }

    /// The figure as SVG text: `content` is drawn in [`UNITS`] between the axes, `beside` in px to their right.
    pub(super) fn to_svg(&self, content: &Markup, beside: &Markup) -> String {
        let (width, height) = self.size;
        let plot = self.plot();
        let label_width = text_width(self.y.label, TEXT);
        // A label longer than its axis stands about the middle of the figure.
        let middle = if label_width > plot.height {
            0.5 * f64::from(height)
        } else {
            plot.y + 0.5 * plot.height
        };
        let top = |row: usize| ABOVE + ROW * row as f64 + 0.5 * f64::from(TEXT);
        let text = html! {
            svg xmlns="http://www.w3.org/2000/svg" class="figure" width=(width) height=(height)
                viewBox=(format!("0 0 {width} {height}")) role="img" aria-label=(self.description())
                data-x=(self.x.data()) data-y=(self.y.data()) data-right=(px(self.right))
                font-family="system-ui, sans-serif" font-size=(TEXT) {
                (coloured(GROUND, &html! { rect width="100%" height="100%" fill="currentColor" {} }))
                (coloured(INK, &html! {
                    @if !self.title.is_empty() {
                        text class="title" x=(px(LEFT)) y="21" font-size=(TITLE) fill="currentColor"
                            data-width=(px(text_width(self.title, TITLE))) { (self.title) }
                    }
                }))
                @for (k, row) in self.rows().iter().enumerate() { @for (left, entry) in row {
                    g class="entry" data-width=(px(entry.width())) transform=(format!("translate({} {})", px(*left), px(top(k)))) {
                        (entry.sample)
                        (coloured(INK, &html! { text x=(px(SAMPLE)) y="4.5" fill="currentColor" { (entry.label) } }))
                    }
                } }
                @if self.bands.len() > 1 { (self.inner(plot, &self.grounds())) }
                g class="mesh" { (self.mesh(plot)) }
                (coloured(INK, &html! {
                    text class="x-label" x=(px(plot.x + 0.5 * plot.width)) y=(px(f64::from(height) - 10.0)) text-anchor="middle"
                        fill="currentColor" { (self.x.label) }
                    text class="y-label" transform=(format!("translate(15 {}) rotate(-90)", px(middle))) text-anchor="middle"
                        fill="currentColor" data-width=(px(label_width)) { (self.y.label) }
                }))
                (self.inner(plot, content))
                (coloured(Role::Neutral.colour(), &self.band_labels(plot)))
                g class="beside" transform=(format!("translate({} 0)", px(f64::from(width) - self.right))) { (beside) }
            }
        };
        text.into_string() + "\n"
    }

    /// The figure in one phrase, for readers who do not see it.
    fn description(&self) -> String {
        let title = if self.title.is_empty() { String::new() } else { format!("{}: ", self.title) };
        let lines: Vec<&str> = self.entries.iter().map(|e| e.label).collect();
        let lines =
            if lines.is_empty() { String::new() } else { format!("; {}", lines.join(", ")) };
        format!("{title}{} over {}{lines}", self.y.label, self.x.label)
    }

    /// A picture in [`UNITS`] over the plot.
    fn inner(&self, plot: Plot, content: &Markup) -> Markup {
        html! {
            svg class="data" x=(px(plot.x)) y=(px(plot.y)) width=(px(plot.width)) height=(px(plot.height))
                viewBox=(format!("0 0 {UNITS} {UNITS}")) preserveAspectRatio="none"
                overflow=(if self.cut { "hidden" } else { "visible" }) { (content) }
        }
    }

    fn grounds(&self) -> Markup {
        let bands = self.bands.iter().skip(1).step_by(2);
        coloured(
            BAND,
            &html! {
                @for band in bands {
                    @let [from, to] = [band.from, band.to].map(|x| self.x.axis.unit(x));
                    rect x=(from) width=(to - from) height=(UNITS) fill="currentColor" {}
                }
            },
        )
    }

    /// Grid, axis lines and the numbers at them.
    fn mesh(&self, plot: Plot) -> Markup {
        let x: Vec<(f64, String)> =
            self.x.marks().map(|(share, text)| (plot.x + share * plot.width, text)).collect();
        let bottom = plot.y + plot.height;
        let y: Vec<(f64, String)> =
            self.y.marks().map(|(share, text)| (bottom - share * plot.height, text)).collect();
        let mut grid = String::new();
        for (at, _) in &x {
            grid += &format!("M{} {}v{}", px(*at), px(plot.y), px(plot.height));
        }
        for (at, _) in &y {
            grid += &format!("M{} {}h{}", px(plot.x), px(*at), px(plot.width));
        }
        let axes = format!("M{} {}v{}h{}", px(plot.x), px(plot.y), px(plot.height), px(plot.width));
        html! {
            (stroked(GRID, &grid))
            (stroked(INK, &axes))
            (coloured(INK, &html! {
                @for (at, text) in &x {
                    text x=(px(*at)) y=(px(bottom + 17.0)) text-anchor="middle" fill="currentColor" { (text) }
                }
                @for (at, text) in &y {
                    text x=(px(plot.x - 8.0)) y=(px(at + 4.5)) text-anchor="end" fill="currentColor" { (text) }
                }
            }))
        }
    }

    /// Names of bands at their tops, hidden where the band is too narrow.
    fn band_labels(&self, plot: Plot) -> Markup {
        html! {
            @for band in &self.bands {
                @let [from, to] = [band.from, band.to].map(|x| self.x.axis.unit(x));
                @let scale = plot.width / UNITS as f64;
                @let width = text_width(band.label, TEXT);
                @let fits = (to - from) as f64 * scale > width;
                text class="band-label" x=(px(plot.x + 0.5 * (from + to) as f64 * scale)) y=(px(plot.y + 14.0))
                    visibility=(if fits { "visible" } else { "hidden" }) text-anchor="middle" fill="currentColor"
                    data-from=(from) data-to=(to) data-width=(px(width)) { (band.label) }
            }
        }
    }
}

/// A thin line.
fn stroked(colour: Colour, path: &str) -> Markup {
    coloured(colour, &html! { path d=(path) fill="none" stroke="currentColor" {} })
}
