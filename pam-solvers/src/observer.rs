//! What a solve shows of its accepted steps while it runs.

/// An accepted step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AcceptedStep<'a, S> {
    /// Its end, s.
    pub(crate) t_new: f64,
    /// Whether its first stage was evaluated afresh: it is the first step, or the input jumps where
    /// it starts.
    pub(crate) fresh: bool,
    /// The state it starts from.
    pub(crate) y: &'a [S],
    /// Its derivatives, one after the other. The closing one is last and holds nothing of use unless
    /// something needed it.
    pub(crate) k: &'a [S],
}

/// Looks at every accepted step.
pub(crate) trait StepObserver<S> {
    /// Whether it looks at closing derivatives.
    fn needs_closing(&self) -> bool {
        false
    }

    /// Called once a step, in order.
    fn accepted(&mut self, step: AcceptedStep<'_, S>);
}

impl<S> StepObserver<S> for () {
    #[inline]
    fn accepted(&mut self, _step: AcceptedStep<'_, S>) {}
}
