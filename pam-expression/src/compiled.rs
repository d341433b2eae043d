//! An expression over any named numbers.

use crate::graph::Graph;
use crate::program::{MOST_REGISTERS, Program};
use pam_core::Scalar;
use pam_vocabulary::expression::{Expression, ExpressionError, Scope};

/// An expression over named numbers, evaluated with any scalar.
///
/// ```
/// use pam_expression::Compiled;
///
/// let friction = Compiled::new("-c * tanh(v / 0.5)", &["v", "c"])?;
/// assert_eq!(friction.value(&[0.0, 3.0]), 0.0);
/// let sliding: f64 = friction.value(&[10.0, 3.0]);
/// assert!((sliding + 3.0).abs() < 1e-12);
/// let error = Compiled::new("-c * tanh(w)", &["v", "c"]).expect_err("there is no w");
/// assert_eq!(error.column, 11);
/// # Ok::<(), pam_vocabulary::expression::ExpressionError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Compiled {
    program: Program,
}

impl Compiled {
    /// Reads and compiles a text over these names.
    ///
    /// # Errors
    /// [`ExpressionError`] with line, column and the unknown word.
    pub fn new(text: &str, names: &[&str]) -> Result<Self, ExpressionError> {
        let names: Vec<String> = names.iter().map(|n| (*n).to_owned()).collect();
        let tree = Expression::parse(text, &Scope::of(&names))?;
        Self::of_tree(&tree).ok_or_else(|| ExpressionError::at(text, 0, too_long()))
    }

    /// Compiles a tree, whose names are the inputs; `None` if it takes more than [`MOST_REGISTERS`] intermediate numbers at
    /// once.
    #[must_use]
    pub fn of_tree(tree: &Expression) -> Option<Self> {
        let mut graph = Graph::default();
        let id = graph.expression(tree, &mut |graph, k| graph.input(k));
        Program::new(&graph, &[id]).map(|program| Self { program })
    }

    /// The value for these numbers, in the order of the names.
    ///
    /// # Panics
    /// If there are fewer numbers than the expression uses.
    #[inline]
    #[must_use]
    pub fn value<S: Scalar>(&self, inputs: &[S]) -> S {
        self.program.value(&inputs)
    }
}

/// The message for an expression that has too many intermediate numbers at once.
#[must_use]
pub fn too_long() -> String {
    format!("needs more than {MOST_REGISTERS} intermediate numbers at once; make it simpler")
}
