//! Observers of the accepted steps of a running solve.

/// An accepted step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AcceptedStep<'a, S> {
    /// Its end, s.
    pub(crate) t_new: f64,
    /// The step restarts: it is the first one, or the input jumps where it starts, so its first stage
    /// is not the FSAL stage of its predecessor.
    pub(crate) restarts: bool,
    /// The state it starts from.
    pub(crate) y: &'a [S],
    /// Its stage derivatives, one after the other. That of the FSAL stage is last and holds nothing of
    /// use unless something needed it.
    pub(crate) k: &'a [S],
}

/// Is called with every accepted step.
pub(crate) trait StepObserver<S> {
    /// Returns `true` if the observer reads FSAL stages.
    fn needs_fsal(&self) -> bool {
        false
    }

    /// Called once a step, in order.
    fn accepted(&mut self, step: AcceptedStep<'_, S>);
}

impl<S> StepObserver<S> for () {
    #[inline]
    fn accepted(&mut self, _step: AcceptedStep<'_, S>) {}
}
