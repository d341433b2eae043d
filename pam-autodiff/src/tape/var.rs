//! The reverse-mode variable.

use super::Element;
use super::arena::Arena;
use crate::numbers::ChainRule;
use num_dual::{DualNum, DualNumFloat};
use pam_core::Scalar;
use std::fmt;
use std::marker::PhantomData;

/// A number whose operations are recorded on a [`Tape`](super::Tape): value, node and tape, 16 bytes
/// for `f64`.
///
/// A constant has no node, and operations on constants alone record nothing; they need no tape. An
/// operation on a variable panics unless the variable's own tape is recording.
///
/// A variable means something on the thread of its tape alone, and the compiler keeps it there:
///
/// ```compile_fail
/// use pam_autodiff::{Tape, Var};
/// let x: Var = Tape::new().variable(1.0);
/// std::thread::spawn(move || x + x);
/// ```
///
/// ```
/// use pam_autodiff::{Tape, Var};
/// let x: Var = Tape::new().variable(1.0);
/// assert_eq!(x.value(), 1.0);
/// ```
#[derive(Debug, Clone, Copy)]
pub struct Var<T: Element = f64> {
    value: T,
    /// Tape and node, 32 bits each; 0 for a constant. One number, because all weights of a layer are
    /// compared with their expected places in every run.
    place: u64,
    thread: PhantomData<*const ()>,
}

impl<T: Element> Var<T> {
    /// A number without a node.
    #[inline]
    pub fn constant_of(value: T) -> Self {
        Self::at(value, 0, 0)
    }

    /// The value.
    #[inline]
    pub fn value(self) -> T {
        self.value
    }

    /// A number that was computed elsewhere, with its derivatives by others.
    ///
    /// ```
    /// use pam_autodiff::{Tape, Var};
    /// let mut tape = Tape::<f64>::new();
    /// let (x, y) = (tape.variable(3.0), tape.variable(4.0));
    /// let length = tape.record(|| Var::computed(5.0, [(x, 0.6), (y, 0.8)]));
    /// assert_eq!((length.value(), tape.reverse([(length, 1.0)]).of(y)), (5.0, 0.8));
    /// ```
    ///
    /// # Panics
    /// If an argument's tape is not recording.
    #[inline]
    pub fn computed<const N: usize>(value: T, by: [(Self, T); N]) -> Self {
        let start = Self::constant_of(value);
        by.into_iter().fold(start, |sum, (var, slope)| sum.chain2(var, value, T::one(), slope))
    }

    /// Returns `true` if the number depends on nothing that was recorded.
    #[inline]
    pub fn is_constant(self) -> bool {
        self.place == 0
    }

    #[inline]
    pub(super) fn at(value: T, node: u32, tape: u32) -> Self {
        Self { value, place: u64::from(tape) << 32 | u64::from(node), thread: PhantomData }
    }

    /// 0 for a constant.
    #[inline]
    pub(super) fn node(self) -> u32 {
        self.place as u32
    }

    /// 0 for a constant.
    #[inline]
    pub(super) fn tape(self) -> u32 {
        (self.place >> 32) as u32
    }

    /// Returns `true` if `vars` are consecutive results of one tape from `first` on.
    pub(super) fn lie_side_by_side(first: Self, vars: &[Self]) -> bool {
        let mut expected = first.place;
        for stretch in vars.chunks(64) {
            // No branch within a stretch, so that it runs on vectors.
            let mut differences = 0;
            for (var, place) in stretch.iter().zip(expected..) {
                differences |= var.place ^ place;
            }
            if differences != 0 {
                return false;
            }
            expected += stretch.len() as u64;
        }
        true
    }

    /// The node, none for a constant.
    #[inline]
    pub(super) fn node_on(self, tape: u32) -> Option<usize> {
        if self.is_constant() {
            return None;
        }
        if self.tape() != tape {
            wrong_tape();
        }
        Some(self.node() as usize)
    }
}

/// Variables whose tape is not the one at hand.
#[cold]
pub(super) fn wrong_tape() -> ! {
    panic!("a variable was used without its own tape recording (another tape, or none, is)");
}

impl<T: Element> ChainRule for Var<T> {
    type Inner = T;

    #[inline]
    fn lifted(value: T) -> Self {
        Self::constant_of(value)
    }
    #[inline]
    fn inner(self) -> T {
        self.value
    }
    #[inline]
    fn chain(self, value: T, slope: T) -> Self {
        if self.is_constant() {
            return Self::constant_of(value);
        }
        T::with(|arena: &mut Arena<T>| {
            if self.tape() != arena.id() {
                wrong_tape();
            }
            arena.push(value, [self.node(), 0], [slope, T::zero()])
        })
    }
    #[inline]
    fn chain2(self, other: Self, value: T, d_self: T, d_other: T) -> Self {
        if other.is_constant() {
            return self.chain(value, d_self);
        }
        if self.is_constant() {
            return other.chain(value, d_other);
        }
        T::with(|arena: &mut Arena<T>| {
            if self.tape() != arena.id() || other.tape() != arena.id() {
                wrong_tape();
            }
            arena.push(value, [self.node(), other.node()], [d_self, d_other])
        })
    }
}

number_operators!(impl[T: Element + DualNum<Primitive = F>, F: DualNumFloat] Var<T>, T, F);
dual_num_by_chain_rule!(impl[T: Element + DualNum<Primitive = F>, F: DualNumFloat] Var<T>, T, F);

impl<T: Element> Scalar for Var<T> {
    dual_num_by_chain_rule!(@scalar);

    /// One result of the tape for each argument.
    #[inline]
    fn with_slopes<const K: usize>(value: f64, arguments: [&Self; K], slopes: [f64; K]) -> Self {
        let slopes = slopes.map(T::constant);
        let by = std::array::from_fn(|k| (*arguments[k], slopes[k]));
        Self::computed::<K>(T::constant(value), by)
    }

    /// One result of the tape for each term.
    #[inline]
    fn combination<const K: usize>(terms: [&Self; K], factors: [f64; K]) -> Self {
        let value = T::combination(terms.map(|t| &t.value), factors);
        Self::computed::<K>(value, std::array::from_fn(|k| (*terms[k], T::constant(factors[k]))))
    }

    /// One block of the tape; see its [module](super) for what it costs.
    fn affine_into(columns: &[Self], bias: &[Self], input: &[Self], out: &mut [Self]) {
        assert_eq!(columns.len(), input.len() * out.len(), "weights do not fit the layer");
        assert_eq!(bias.len(), out.len(), "bias does not fit the layer");
        T::with(|arena: &mut Arena<T>| arena.affine(columns, bias, input, out));
    }
}

impl<T: Element> fmt::Display for Var<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} (node {})", self.value, self.node())
    }
}
