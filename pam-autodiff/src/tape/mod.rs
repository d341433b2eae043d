//! Reverse mode: a record of the operations of a run, and sweeps over it.
//!
//! While a [`Tape`] records, every operation on a [`Var`] that depends on a variable is written to
//! it: the numbers of its (at most two) arguments and the partial derivatives with respect to them.
//! A sweep backwards through this record turns a cotangent of the outputs into the cotangent of
//! everything that was recorded, at a cost of a few times the run, whatever the number of variables
//! ([`Tape::reverse`]); a sweep forwards turns a tangent of the variables into that of everything
//! ([`Tape::forward`]). Source: A. Griewank and A. Walther, *Evaluating Derivatives* (2nd ed. 2008),
//! chapters 3 and 4.
//!
//! ```
//! use num_dual::DualNum;
//! use pam_autodiff::Tape;
//! let mut tape = Tape::<f64>::new();
//! let x = tape.variable(0.5);
//! let y = tape.variable(4.0);
//! let z = tape.record(|| x.sin() * y.sqrt());
//! let adjoints = tape.reverse([(z, 1.0)]);
//! assert_eq!(adjoints.of(x), 0.5_f64.cos() * 2.0);
//! assert_eq!(adjoints.of(y), 0.5_f64.sin() / 4.0);
//! ```
//!
//! **Memory.** An operation takes 32 bytes for `f64`, and memory is kept from run to run: a second run
//! of the same length allocates nothing. A dense layer is one block that refers to its weights where
//! they lie. [`Tape::mark`] and [`Tape::rewind`] keep what was recorded first, say the parameters of
//! a model, and throw away what came later.
//!
//! **Elements.** A tape of [`num_dual::Dual64`] differentiates its own reverse sweep along one
//! direction: forward over reverse, a product of a Hessian with a vector.

mod affine;
mod arena;
mod element;
mod kernels;
mod sweep;
mod var;

pub use element::Element;
pub use sweep::Derivatives;
pub use var::Var;

use arena::Arena;

/// A record of operations on [`Var`]s; see the [module](self).
#[derive(Debug)]
pub struct Tape<T: Element = f64> {
    arena: Arena<T>,
    /// The derivatives of the last sweep, by node.
    derivatives: Vec<T>,
    scratch: Vec<T>,
}

/// A place in a [`Tape`] to [rewind](Tape::rewind) to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mark(arena::Lengths);

/// Adjoints of what a tape held up to a [`Mark`]; see [`Tape::reverse_since`].
#[derive(Debug, Clone, Default)]
pub struct Gathered<T: Element = f64>(Vec<T>);

impl<T: Element> Gathered<T> {
    /// Forgets what was gathered; memory is kept.
    pub fn clear(&mut self) {
        self.0.clear();
    }
}

impl<T: Element> Tape<T> {
    /// An empty tape.
    #[must_use]
    pub fn new() -> Self {
        Self { arena: Arena::new(), derivatives: Vec::new(), scratch: Vec::new() }
    }

    /// A new variable.
    pub fn variable(&mut self, value: T) -> Var<T> {
        let mut var = [Var::constant_of(value)];
        self.arena.variables(&[value], &mut var);
        var[0]
    }

    /// New variables, one for each value.
    pub fn variables(&mut self, values: &[T]) -> Vec<Var<T>> {
        let mut vars = vec![Var::constant_of(T::zero()); values.len()];
        self.variables_into(values, &mut vars);
        vars
    }

    /// Writes new variables to `vars`, one for each value. Weights that were made in one call, column by
    /// column, are used in place by [`affine_into`](pam_core::Scalar::affine_into).
    ///
    /// # Panics
    /// If the lengths differ.
    pub fn variables_into(&mut self, values: &[T], vars: &mut [Var<T>]) {
        self.arena.variables(values, vars);
    }

    /// Runs `run` with this tape recording on this thread, and returns what `run` returns.
    ///
    /// Recordings nest: within `run` another tape may record, and this one goes on when that one is
    /// done. If `run` panics, this tape stops recording and keeps what was written so far.
    ///
    /// # Panics
    /// If `run` operates on a variable of another tape.
    pub fn record<R>(&mut self, run: impl FnOnce() -> R) -> R {
        /// Exchanges the tape's arena with the thread's, on creation and again on drop.
        struct Exchanged<'a, T: Element>(&'a mut Arena<T>);
        impl<T: Element> Drop for Exchanged<'_, T> {
            fn drop(&mut self) {
                T::exchange(self.0);
            }
        }
        T::exchange(&mut self.arena);
        let _until_dropped = Exchanged(&mut self.arena);
        run()
    }

    /// The present end of the record.
    #[must_use]
    pub fn mark(&self) -> Mark {
        Mark(self.arena.lengths())
    }

    /// Throws away what was recorded after `mark`; memory is kept. Variables from then on must not
    /// be used again: their numbers are given to others.
    ///
    /// # Panics
    /// If the record is shorter than at the mark.
    pub fn rewind(&mut self, mark: Mark) {
        self.arena.rewind(mark.0);
    }

    /// Throws away everything; memory is kept.
    pub fn clear(&mut self) {
        self.arena.clear();
    }

    /// Number of variables and results in the record.
    #[must_use]
    pub fn len(&self) -> usize {
        self.arena.len()
    }

    /// Returns `true` if nothing is recorded.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of the record, without what is reserved.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.arena.bytes()
    }

    /// The reverse sweep: for `L = Σ_k w_k z_k` over the seeds `(z_k, w_k)`, the derivative of `L` with
    /// respect to every variable and result. Costs about as much as a run; seeds that are constants
    /// count for nothing.
    ///
    /// # Panics
    /// If a seed belongs to another tape.
    pub fn reverse(&mut self, seeds: impl IntoIterator<Item = (Var<T>, T)>) -> Derivatives<'_, T> {
        self.start(seeds);
        let all = arena::Lengths::default();
        sweep::reverse(&self.arena, all, &mut self.derivatives, &mut self.scratch);
        Derivatives::new(self.arena.id(), &self.derivatives)
    }

    /// The reverse sweep over what was recorded after `mark` alone. Adjoints of what came before are added
    /// to `gathered`, over many runs behind one common beginning;
    /// [`reverse_gathered`](Self::reverse_gathered) carries them the rest of the way.
    ///
    /// ```
    /// use pam_autodiff::{Gathered, Tape};
    /// // Σ_k sin(k a²): the square is recorded once.
    /// let mut tape = Tape::<f64>::new();
    /// let a = tape.variable(0.7);
    /// let square = tape.record(|| a * a);
    /// let (mark, mut gathered) = (tape.mark(), Gathered::default());
    /// for k in 1..4 {
    ///     tape.rewind(mark);
    ///     let term = tape.record(|| (square * f64::from(k)).sin());
    ///     tape.reverse_since(mark, &mut gathered, [(term, 1.0)]);
    /// }
    /// tape.rewind(mark);
    /// let by_a = tape.reverse_gathered(&gathered, []).of(a);
    /// let exact: f64 = (1..4).map(f64::from).map(|k| 1.4 * k * (k * 0.49).cos()).sum();
    /// assert!((by_a - exact).abs() < 1e-14);
    /// # use num_dual::DualNum;
    /// ```
    ///
    /// # Panics
    /// If a seed belongs to another tape, or the record is shorter than at the mark.
    pub fn reverse_since(
        &mut self,
        mark: Mark,
        gathered: &mut Gathered<T>,
        seeds: impl IntoIterator<Item = (Var<T>, T)>,
    ) -> Derivatives<'_, T> {
        gathered.0.resize(mark.0.values, T::zero());
        self.start_from(gathered, seeds);
        sweep::reverse(&self.arena, mark.0, &mut self.derivatives, &mut self.scratch);
        gathered.0.copy_from_slice(&self.derivatives[..mark.0.values]);
        Derivatives::new(self.arena.id(), &self.derivatives)
    }

    /// The reverse sweep from gathered adjoints and more seeds; see
    /// [`reverse_since`](Self::reverse_since).
    ///
    /// # Panics
    /// If a seed belongs to another tape, or the record is shorter than what was gathered for.
    pub fn reverse_gathered(
        &mut self,
        gathered: &Gathered<T>,
        seeds: impl IntoIterator<Item = (Var<T>, T)>,
    ) -> Derivatives<'_, T> {
        self.start_from(gathered, seeds);
        let all = arena::Lengths::default();
        sweep::reverse(&self.arena, all, &mut self.derivatives, &mut self.scratch);
        Derivatives::new(self.arena.id(), &self.derivatives)
    }

    /// The forward sweep: the tangents of everything for the tangents of some variables, the seeds
    /// `(x_k, v_k)`; all other variables stay put. Costs about as much as a run.
    ///
    /// # Panics
    /// If a seed belongs to another tape.
    pub fn forward(&mut self, seeds: impl IntoIterator<Item = (Var<T>, T)>) -> Derivatives<'_, T> {
        self.start(seeds);
        sweep::forward(&self.arena, &mut self.derivatives, &mut self.scratch);
        Derivatives::new(self.arena.id(), &self.derivatives)
    }

    /// [`forward`](Self::forward) with seeds for variables that were made side by side: the first of them
    /// and the tangents of all.
    pub(crate) fn forward_from(&mut self, seeds: &[(Option<Var<T>>, &[T])]) -> Derivatives<'_, T> {
        self.start([]);
        for (first, tangents) in seeds {
            if let Some(first) = first.and_then(|var| var.node_on(self.arena.id())) {
                self.derivatives[first..first + tangents.len()].copy_from_slice(tangents);
            }
        }
        sweep::forward(&self.arena, &mut self.derivatives, &mut self.scratch);
        Derivatives::new(self.arena.id(), &self.derivatives)
    }

    /// The gathered values, zeros behind them, and seeds.
    fn start_from(&mut self, gathered: &Gathered<T>, seeds: impl IntoIterator<Item = (Var<T>, T)>) {
        let len = self.arena.len() + 1;
        assert!(gathered.0.len() <= len, "the tape is shorter than what was gathered for");
        self.derivatives.clear();
        self.derivatives.extend_from_slice(&gathered.0);
        self.derivatives.resize(len, T::zero());
        for (var, seed) in seeds {
            if let Some(node) = var.node_on(self.arena.id()) {
                self.derivatives[node] += seed;
            }
        }
    }

    /// Zeros and seeds.
    fn start(&mut self, seeds: impl IntoIterator<Item = (Var<T>, T)>) {
        self.derivatives.clear();
        self.derivatives.resize(self.arena.len() + 1, T::zero());
        for (var, seed) in seeds {
            if let Some(node) = var.node_on(self.arena.id()) {
                self.derivatives[node] += seed;
            }
        }
    }
}

impl<T: Element> Default for Tape<T> {
    fn default() -> Self {
        Self::new()
    }
}
