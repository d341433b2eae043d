use crate::grid::Grid;

/// The observation times sorted into the steps of a grid, walked forward or backward.
#[derive(Debug, Clone, Copy)]
pub(super) struct Observations<'a> {
    pub(super) times_s: &'a [f64],
}

/// The observations of one step, as index ranges into the observation times.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OfStep {
    /// First observation after the start of the step.
    pub(super) first: usize,
    /// First observation at the end of the step or later: those before it lie inside the step and are
    /// read from the interpolant.
    pub(super) end: usize,
    /// Whether observation `end` is the end of the step, where the state itself is taken.
    pub(super) at_end: bool,
}

impl OfStep {
    /// Whether one lies inside.
    pub(super) fn any_inside(self) -> bool {
        self.end > self.first
    }
}

impl Observations<'_> {
    /// Number of observations at the start of the grid: one or none.
    pub(super) fn at_start(&self, t0: f64) -> usize {
        usize::from(self.times_s.first() == Some(&t0))
    }

    /// Those of step `step`, of which `first` is the first one; for walking forward.
    pub(super) fn from(&self, grid: &Grid, step: usize, first: usize) -> OfStep {
        let (_, t_new) = grid.step_s(step);
        let mut end = first;
        while self.times_s.get(end).is_some_and(|&s| s < t_new) {
            end += 1;
        }
        OfStep { first, end, at_end: self.times_s.get(end) == Some(&t_new) }
    }

    /// Those of step `step`, when all from `after` on are later ones; for walking backward.
    pub(super) fn until(&self, grid: &Grid, step: usize, after: usize) -> OfStep {
        let (t, t_new) = grid.step_s(step);
        let at_end = after > 0 && self.times_s[after - 1] == t_new;
        let end = if at_end { after - 1 } else { after };
        let mut first = end;
        while first > 0 && self.times_s[first - 1] > t {
            first -= 1;
        }
        OfStep { first, end, at_end }
    }
}
