use super::colour_bar::colour;
use super::frame::Entry;
use super::style::{INK, Role, coloured, padded_range, px};
use super::value_plane::{PlaneGeometry, ValuePlane};
use maud::{Markup, html};

/// Radius of a ring in half widths of its square: just outside the corners.
const RING: f64 = 1.5;

/// A measured point of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapPoint {
    /// Horizontal coordinate.
    pub x: f64,
    /// Vertical coordinate.
    pub y: f64,
    /// Value shown as colour; points without a finite value are drawn hollow.
    pub value: f64,
    /// True if a circle is drawn around the point.
    pub ringed: bool,
}

/// Values over a plane, as coloured squares with a colour bar.
#[derive(Debug, Clone)]
pub struct ColourMap {
    /// Title, axes and colours.
    pub plane: ValuePlane,
    /// The points.
    pub points: Vec<MapPoint>,
    /// Legend of the circles; no entry if empty or if no point has one.
    pub ring_label: String,
}

impl ColourMap {
    /// The map as SVG text.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let (x0, x1) = padded_range(self.points.iter().map(|p| p.x), 0.08);
        let (y0, y1) = padded_range(self.points.iter().map(|p| p.y), 0.08);
        let ringed = self.points.iter().any(|p| p.ringed);
        let entries = if ringed && !self.ring_label.is_empty() {
            vec![Entry { label: &self.ring_label, sample: ring(16.0, 6.0) }]
        } else {
            Vec::new()
        };
        self.plane.to_svg([[x0, x1], [y0, y1]], entries, |geometry| self.content(geometry))
    }

    /// Half the width of a square, px: as large as leaves neighbours apart.
    fn half_width(&self, geometry: &PlaneGeometry<'_>) -> f64 {
        let (smallest, largest) = (3.0, 11.0);
        let places: Vec<(f64, f64)> =
            self.points.iter().map(|p| geometry.plot.px(geometry.unit(p.x, p.y))).collect();
        // Repetitions of one condition lie on each other whatever the size.
        let mut nearest: Vec<f64> = places
            .iter()
            .filter_map(|a| {
                let distances = places.iter().map(|b| (a.0 - b.0).abs().max((a.1 - b.1).abs()));
                distances.filter(|d| *d > 2.0).min_by(f64::total_cmp)
            })
            .collect();
        nearest.sort_unstable_by(f64::total_cmp);
        // A few pairs may lie closer than the rest.
        let pitch = nearest.get(nearest.len() / 10).copied().unwrap_or(f64::MAX);
        let ringed = self.points.iter().any(|p| p.ringed);
        let share = if ringed { 0.5 / RING } else { 0.42 };
        (pitch * share).clamp(smallest, largest)
    }

    fn content(&self, geometry: &PlaneGeometry<'_>) -> Markup {
        let half = self.half_width(geometry);
        let side = px(2.0 * half);
        let mark = |p: &MapPoint| {
            html! {
                @if p.value.is_finite() {
                    // The edge shows dark values on dark ground.
                    (coloured(Role::Neutral.colour(), &html! {
                        rect x=(px(-half)) y=(px(-half)) width=(side) height=(side) fill=(colour(p.value, self.plane.scale()))
                            stroke="currentColor" stroke-width="0.7" {}
                    }))
                } @else {
                    (coloured(INK, &html! {
                        rect x=(px(-half)) y=(px(-half)) width=(side) height=(side) fill="none" stroke="currentColor" {}
                    }))
                }
                @if p.ringed { (ring(0.0, half * RING)) }
            }
        };
        html! {
            @for p in &self.points { (geometry.plot.mark(geometry.unit(p.x, p.y), &mark(p))) }
        }
    }
}

fn ring(x: f64, radius: f64) -> Markup {
    coloured(
        INK,
        &html! { circle cx=(px(x)) r=(px(radius)) fill="none" stroke="currentColor" stroke-width="1.5" {} },
    )
}
