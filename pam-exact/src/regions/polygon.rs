//! Convex polygons, clipped by half-planes (I. E. Sutherland, G. W. Hodgman, *Reentrant polygon clipping*, 1974).

use super::half_plane::{HalfPlane, Window};

/// A convex polygon, counter-clockwise; side `k` runs from vertex `k` to its successor and lies on the
/// border of half-plane `k`.
#[derive(Debug, Clone, Default)]
pub(crate) struct ConvexPolygon {
    pub(crate) vertices: Vec<[f64; 2]>,
    sides: Vec<HalfPlane>,
    margins: Vec<f64>,
    next_vertices: Vec<[f64; 2]>,
    next_sides: Vec<HalfPlane>,
}

/// The effect of a clip.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Clip {
    /// The polygon lies inside.
    Whole,
    /// A part is left.
    Cut,
    /// Nothing would be left; the polygon is unchanged.
    Nothing,
}

/// The smallest rectangle around a polygon.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BoundingBox {
    pub(crate) centre: [f64; 2],
    pub(crate) half_widths: [f64; 2],
}

impl ConvexPolygon {
    /// Restarts with a whole window.
    pub(crate) fn restart(&mut self, window: &Window) {
        let ([p0, p1], [r0, r1]) = (window.first, window.second);
        self.vertices.clear();
        self.vertices.extend([[p0, r0], [p1, r0], [p1, r1], [p0, r1]]);
        self.sides.clear();
        let side = |alpha: f64, beta: f64, gamma: f64| HalfPlane { alpha, beta, gamma };
        self.sides.extend([
            side(-r0, 0.0, 1.0),
            side(p1, -1.0, 0.0),
            side(r1, 0.0, -1.0),
            side(-p0, 1.0, 0.0),
        ]);
    }

    /// Removes what lies outside of a half-plane. New vertices are intersections of the two borders
    /// themselves, so the old vertices' rounding does not enter.
    pub(crate) fn clip(&mut self, plane: &HalfPlane) -> Clip {
        let count = self.vertices.len();
        self.margins.clear();
        self.margins.extend(self.vertices.iter().map(|&v| plane.margin(v)));
        let inside = self.margins.iter().filter(|&&m| m >= 0.0).count();
        if inside == count {
            return Clip::Whole;
        }
        if inside == 0 {
            return Clip::Nothing;
        }
        self.next_vertices.clear();
        self.next_sides.clear();
        for k in 0..count {
            let next = if k + 1 == count { 0 } else { k + 1 };
            let (here, there) = (self.margins[k] >= 0.0, self.margins[next] >= 0.0);
            if here {
                self.next_vertices.push(self.vertices[k]);
                self.next_sides.push(self.sides[k]);
            }
            if here != there {
                let mut at = self.sides[k].intersection(plane);
                let (a, b) = (self.vertices[k], self.vertices[next]);
                let within = |i: usize| at[i] >= a[i].min(b[i]) && at[i] <= a[i].max(b[i]);
                if !(within(0) && within(1)) {
                    // Nearly parallel borders, or rounding past an end: stay on the side.
                    let t = self.margins[k] / (self.margins[k] - self.margins[next]);
                    at = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
                }
                self.next_vertices.push(at);
                self.next_sides.push(if here { *plane } else { self.sides[k] });
            }
        }
        std::mem::swap(&mut self.vertices, &mut self.next_vertices);
        std::mem::swap(&mut self.sides, &mut self.next_sides);
        Clip::Cut
    }

    pub(crate) fn bounding_box(&self) -> BoundingBox {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in &self.vertices {
            for i in 0..2 {
                low[i] = low[i].min(v[i]);
                high[i] = high[i].max(v[i]);
            }
        }
        let half = |i: usize| 0.5 * (high[i] - low[i]);
        BoundingBox {
            centre: [low[0] + half(0), low[1] + half(1)],
            half_widths: [half(0), half(1)],
        }
    }
}

/// The area of a polygon by the shoelace formula about its first vertex.
pub(crate) fn area(vertices: &[[f64; 2]]) -> f64 {
    let Some(&o) = vertices.first() else { return 0.0 };
    let about = |v: [f64; 2]| [v[0] - o[0], v[1] - o[1]];
    vertices
        .windows(2)
        .map(|w| {
            let (a, b) = (about(w[0]), about(w[1]));
            0.5 * (a[0] * b[1] - a[1] * b[0])
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_cut_to_a_triangle() {
        let mut polygon = ConvexPolygon::default();
        polygon.restart(&Window { first: [0.0, 1.0], second: [0.0, 1.0] });
        assert!((area(&polygon.vertices) - 1.0).abs() < 1e-15);
        let diagonal = HalfPlane { alpha: 1.0, beta: -1.0, gamma: -1.0 };
        assert_eq!(polygon.clip(&diagonal), Clip::Cut);
        assert!((area(&polygon.vertices) - 0.5).abs() < 1e-15);
        assert_eq!(polygon.clip(&diagonal), Clip::Whole);
        let away = HalfPlane { alpha: -3.0, beta: 1.0, gamma: 1.0 };
        assert_eq!(polygon.clip(&away), Clip::Nothing);
        assert!((area(&polygon.vertices) - 0.5).abs() < 1e-15);
    }

    /// Two borders that meet far from the vertices of a huge window still meet exactly.
    #[test]
    fn intersections_do_not_suffer_from_a_large_window() {
        let mut polygon = ConvexPolygon::default();
        polygon.restart(&Window { first: [-1e7, 1e7], second: [-1e9, 1e9] });
        polygon.clip(&HalfPlane { alpha: -0.1, beta: 1.0, gamma: 0.0 });
        polygon.clip(&HalfPlane { alpha: 0.3, beta: 0.0, gamma: -1.0 });
        assert!(polygon.vertices.contains(&[0.1, 0.3]), "{:?}", polygon.vertices);
    }
}
