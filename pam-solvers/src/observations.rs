//! The observations of each step.

/// The observation times (s, increasing) of a solve, sorted into its steps forward or backward.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Observations<'a> {
    pub(crate) times_s: &'a [f64],
}

/// The observations of one step, as index ranges into the observation times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct OfStep {
    /// First observation after the start of the step.
    pub(crate) first: usize,
    /// First observation at the end of the step or later: those before it lie inside the step and are
    /// read from the interpolant.
    pub(crate) end: usize,
    /// Observation `end` is at the end of the step, where the state itself is taken.
    pub(crate) at_end: bool,
}

impl OfStep {
    /// Returns `true` if an observation lies inside the step.
    pub(crate) fn any_inside(self) -> bool {
        self.end > self.first
    }
}

impl Observations<'_> {
    /// Number of observations at the start of the grid: one or none.
    pub(crate) fn at_start(&self, t0: f64) -> usize {
        usize::from(self.times_s.first() == Some(&t0))
    }

    /// Those of the step that ends at `t_new`, of which `first` is the first one; for walking forward.
    pub(crate) fn from(&self, t_new: f64, first: usize) -> OfStep {
        let mut end = first;
        while self.times_s.get(end).is_some_and(|&s| s < t_new) {
            end += 1;
        }
        OfStep { first, end, at_end: self.times_s.get(end) == Some(&t_new) }
    }

    /// Those of the step from `t` to `t_new`, when all from `after` on are later; for walking backward.
    #[inline]
    pub(crate) fn until(&self, t: f64, t_new: f64, after: usize) -> OfStep {
        let at_end = after > 0 && self.times_s[after - 1] == t_new;
        let end = if at_end { after - 1 } else { after };
        let mut first = end;
        while first > 0 && self.times_s[first - 1] > t {
            first -= 1;
        }
        OfStep { first, end, at_end }
    }
}
