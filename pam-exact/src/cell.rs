//! The polygon in which a pattern holds.

/// A half-plane `α + β p + γ r ≥ 0` of the plane `(p, r)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HalfPlane {
    pub(crate) alpha: f64,
    pub(crate) beta: f64,
    pub(crate) gamma: f64,
}

impl HalfPlane {
    #[inline(always)]
    pub(crate) fn margin(&self, [p, r]: [f64; 2]) -> f64 {
        self.alpha + self.beta * p + self.gamma * r
    }

    /// Where the borders of two half-planes meet; infinite if they are parallel.
    fn meet(&self, other: &Self) -> [f64; 2] {
        let d = self.beta * other.gamma - self.gamma * other.beta;
        [
            (self.gamma * other.alpha - self.alpha * other.gamma) / d,
            (self.alpha * other.beta - self.beta * other.alpha) / d,
        ]
    }
}

/// A rectangle, the part of a plane that is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Window {
    /// Smallest and largest value along the first axis.
    pub first: [f64; 2],
    /// Smallest and largest value along the second axis.
    pub second: [f64; 2],
}

impl Window {
    pub(crate) fn contains(&self, [p, r]: [f64; 2]) -> bool {
        p >= self.first[0] && p <= self.first[1] && r >= self.second[0] && r <= self.second[1]
    }
}

/// A convex polygon, counter-clockwise; side `k` goes from vertex `k` to its successor and lies on the
/// border of half-plane `k`.
#[derive(Debug, Clone, Default)]
pub(crate) struct Cell {
    pub(crate) vertices: Vec<[f64; 2]>,
    sides: Vec<HalfPlane>,
    margins: Vec<f64>,
    next_vertices: Vec<[f64; 2]>,
    next_sides: Vec<HalfPlane>,
}

/// What a clip did to a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Clip {
    /// All of it is inside.
    Whole,
    /// A part is left.
    Cut,
    /// Nothing would be left; the cell is unchanged.
    Nothing,
}

impl Cell {
    /// Starts with a whole window.
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

    /// Cuts off what is outside of a half-plane. New vertices are intersections of the two borders
    /// themselves, so they are as exact wherever the old vertices were.
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
                let mut at = self.sides[k].meet(plane);
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

    /// The middle and the half widths of the smallest rectangle around the cell.
    pub(crate) fn bounds(&self) -> ([f64; 2], [f64; 2]) {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for v in &self.vertices {
            for i in 0..2 {
                low[i] = low[i].min(v[i]);
                high[i] = high[i].max(v[i]);
            }
        }
        let half = |i: usize| 0.5 * (high[i] - low[i]);
        ([low[0] + half(0), low[1] + half(1)], [half(0), half(1)])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_cut_to_a_triangle() {
        let mut cell = Cell::default();
        cell.restart(&Window { first: [0.0, 1.0], second: [0.0, 1.0] });
        assert!((crate::partition::area(&cell.vertices) - 1.0).abs() < 1e-15);
        let diagonal = HalfPlane { alpha: 1.0, beta: -1.0, gamma: -1.0 };
        assert_eq!(cell.clip(&diagonal), Clip::Cut);
        assert!((crate::partition::area(&cell.vertices) - 0.5).abs() < 1e-15);
        assert_eq!(cell.clip(&diagonal), Clip::Whole);
        let away = HalfPlane { alpha: -3.0, beta: 1.0, gamma: 1.0 };
        assert_eq!(cell.clip(&away), Clip::Nothing);
        assert!((crate::partition::area(&cell.vertices) - 0.5).abs() < 1e-15);
    }

    /// Two borders that meet far from the corners of a huge window still meet exactly.
    #[test]
    fn intersections_do_not_suffer_from_a_large_window() {
        let mut cell = Cell::default();
        cell.restart(&Window { first: [-1e7, 1e7], second: [-1e9, 1e9] });
        cell.clip(&HalfPlane { alpha: -0.1, beta: 1.0, gamma: 0.0 });
        cell.clip(&HalfPlane { alpha: 0.3, beta: 0.0, gamma: -1.0 });
        assert!(cell.vertices.contains(&[0.1, 0.3]), "{:?}", cell.vertices);
    }
}
