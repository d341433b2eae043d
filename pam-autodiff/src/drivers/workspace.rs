use crate::tape::{Derivatives, Element, Tape, Var};
use pam_core::Scalar;

/// Memory for drivers in reverse mode: a tape with the variables and results of one evaluation.
#[derive(Debug)]
pub struct Recorder<T: Element = f64> {
    tape: Tape<T>,
    x: Vec<Var<T>>,
    out: Vec<Var<T>>,
}

impl<T: Element> Recorder<T> {
    /// No memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self { tape: Tape::new(), x: Vec::new(), out: Vec::new() }
    }

    /// Records `f` at `x`, with `outputs` results.
    pub(super) fn record(
        &mut self,
        f: impl FnOnce(&[Var<T>], &mut [Var<T>]),
        x: impl ExactSizeIterator<Item = T>,
        outputs: usize,
    ) {
        let Self { tape, x: vars, out } = self;
        tape.clear();
        vars.clear();
        vars.extend(x.map(|value| tape.variable(value)));
        out.clear();
        out.resize(outputs, Var::constant_of(T::zero()));
        tape.record(|| f(vars, out));
    }

    /// The values of the results.
    pub(super) fn values(&self) -> impl Iterator<Item = T> + '_ {
        self.out.iter().map(|var| var.value())
    }

    /// The sweep for the cotangents `w` of the results, and the variables.
    pub(super) fn reverse(
        &mut self,
        w: impl Iterator<Item = T>,
    ) -> (Derivatives<'_, T>, &[Var<T>]) {
        (self.tape.reverse(self.out.iter().copied().zip(w)), &self.x)
    }
}

/// Memory for drivers in forward mode: arguments and results of one evaluation.
#[derive(Debug)]
pub struct Point<S> {
    pub(super) x: Vec<S>,
    pub(super) out: Vec<S>,
}

impl<S: Scalar> Point<S> {
    /// No memory yet.
    #[must_use]
    pub fn new() -> Self {
        Self { x: Vec::new(), out: Vec::new() }
    }

    /// Evaluates `f` at `x`, with `outputs` results.
    pub(crate) fn eval(
        &mut self,
        f: impl FnOnce(&[S], &mut [S]),
        x: impl Iterator<Item = S>,
        outputs: usize,
    ) -> &[S] {
        self.x.clear();
        self.x.extend(x);
        self.out.clear();
        self.out.resize(outputs, S::zero());
        f(&self.x, &mut self.out);
        &self.out
    }
}

impl<T: Element> Default for Recorder<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<S: Scalar> Default for Point<S> {
    fn default() -> Self {
        Self::new()
    }
}
