use super::colour_bar::colour;
use super::header::text_width;
use super::style::{INK, SCALE, TEXT, padded_range};
use super::value_plane::{DrawError, Plane, Root, ValuePlane};
use plotters::coord::ranged1d::Ranged;
use plotters::prelude::*;

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
    ///
    /// # Panics
    /// Never: drawing into memory cannot fail.
    #[must_use]
    pub fn to_svg(&self) -> String {
        let (x0, x1) = padded_range(self.points.iter().map(|p| p.x), 0.08);
        let (y0, y1) = padded_range(self.points.iter().map(|p| p.y), 0.08);
        self.plane.to_svg([[x0, x1], [y0, y1]], |root, plane| self.draw(root, plane))
    }

    /// Half the width of a square, px of the drawing: as large as leaves neighbours apart.
    fn half_width<X, Y>(&self, area: &DrawingArea<SVGBackend<'_>, Cartesian2d<X, Y>>) -> i32
    where
        X: Ranged<ValueType = f64>,
        Y: Ranged<ValueType = f64>,
    {
        let (smallest, largest) = (3.0, 11.0);
        let places: Vec<(i32, i32)> =
            self.points.iter().map(|p| area.map_coordinate(&(p.x, p.y))).collect();
        // Repetitions of one condition lie on each other whatever the size.
        let mut nearest: Vec<i32> = places
            .iter()
            .filter_map(|a| {
                let distances = places.iter().map(|b| (a.0 - b.0).abs().max((a.1 - b.1).abs()));
                distances.filter(|d| *d > 2 * SCALE as i32).min()
            })
            .collect();
        nearest.sort_unstable();
        // A few pairs may lie closer than the rest.
        let pitch = nearest.get(nearest.len() / 10).copied().unwrap_or(i32::MAX);
        let ringed = self.points.iter().any(|p| p.ringed);
        let share = if ringed { 0.5 / RING } else { 0.42 };
        let (low, high) = (smallest * f64::from(SCALE), largest * f64::from(SCALE));
        (f64::from(pitch) * share).clamp(low, high) as i32
    }

    fn draw(&self, root: &Root<'_>, chart: &mut Plane<'_, '_>) -> Result<(), DrawError> {
        let half = self.half_width(chart.plotting_area());
        chart.draw_series(self.points.iter().map(|p| {
            let style = if p.value.is_finite() {
                colour(p.value, self.plane.scale()).filled()
            } else {
                INK.stroke_width(SCALE)
            };
            EmptyElement::at((p.x, p.y)) + Rectangle::new([(-half, -half), (half, half)], style)
        }))?;
        let ringed = || self.points.iter().filter(|p| p.ringed);
        let ring = INK.stroke_width(SCALE + SCALE / 2);
        let radius = (f64::from(half) * RING) as i32;
        chart.draw_series(ringed().map(|p| Circle::new((p.x, p.y), radius, ring)))?;
        if !self.ring_label.is_empty() && ringed().next().is_some() {
            let text = ("sans-serif", TEXT * SCALE).into_font().color(&INK);
            let scale = SCALE as i32;
            let right = self.plane.size.0 as i32 - 8;
            let left = (right - text_width(&self.ring_label, TEXT) as i32) * scale;
            root.draw(&Text::new(self.ring_label.clone(), (left, 10 * scale), text))?;
            let centre = (left - 12 * scale, (9 + TEXT as i32 / 2) * scale);
            root.draw(&Circle::new(centre, 6 * scale, ring))?;
        }
        Ok(())
    }
}
