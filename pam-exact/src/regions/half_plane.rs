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

    /// The intersection of the borders of two half-planes; infinite if they are parallel.
    pub(crate) fn intersection(&self, other: &Self) -> [f64; 2] {
        let d = self.beta * other.gamma - self.gamma * other.beta;
        [
            (self.gamma * other.alpha - self.alpha * other.gamma) / d,
            (self.alpha * other.beta - self.beta * other.alpha) / d,
        ]
    }
}

/// A rectangle of a plane.
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

    pub(crate) fn centre(&self) -> [f64; 2] {
        [self.first, self.second].map(|range| 0.5 * (range[0] + range[1]))
    }

    pub(crate) fn widths(&self) -> [f64; 2] {
        [self.first[1] - self.first[0], self.second[1] - self.second[0]]
    }

    pub(crate) fn area(&self) -> f64 {
        let [first, second] = self.widths();
        first * second
    }
}
