//! Butcher tableaux, one method a file.
//!
//! Every method has the same shape: `s` stages that make the step, and one **FSAL stage** (first same
//! as last) `k_{s+1} = f(t_{n+1}, y_{n+1})`. It is the first stage of the next step unless the input
//! jumps there (a **restart**), and it enters error estimate and interpolant. It is evaluated only when
//! something needs it.
//!
//! To add a method: one file with a constructor, named below, and one line in the list after [`Tableau`].

mod bogacki_shampine3;
mod dormand_prince5;
mod interpolant;
mod polynomial;
mod rk4;
mod transpose;
mod tsit5;

pub(crate) use interpolant::InterpolantTable;
pub(crate) use transpose::Transpose;

use crate::input::Side;
use pam_core::{ModelError, Scalar};
use polynomial::hermite;

/// An explicit Runge–Kutta method with optional error estimate and an interpolant.
///
/// ```
/// use pam_solvers::Tableau;
///
/// let tsit5 = Tableau::from_name("tsit5")?;
/// assert_eq!((tsit5.order, tsit5.embedded_order), (5, Some(4)));
/// let midpoint = Tableau::custom("midpoint", 2, &[0.0, 0.5], &[&[], &[0.5]], &[0.0, 1.0])?;
/// assert_eq!(midpoint.order, 2);
/// # Ok::<(), pam_core::ModelError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Tableau {
    /// Name, as files and commands know it.
    pub name: &'static str,
    /// Order of the step.
    pub order: usize,
    /// Order of the embedded method, if there is one.
    pub embedded_order: Option<usize>,
    /// Order of the interpolant: its error inside one step is O(h^(order+1)).
    pub interpolant_order: usize,
    /// Nodes c, one a stage.
    pub c: Vec<f64>,
    /// Strictly lower-triangular matrix a; row `i` has `i` entries.
    pub a: Vec<Vec<f64>>,
    /// Weights b, one a stage.
    pub b: Vec<f64>,
    /// Weights of the error estimate, `b − b̂`, one a stage and one for the FSAL stage.
    pub error: Option<Vec<f64>>,
    /// Interpolation weights `b_i(θ)`, one polynomial a stage and one for the FSAL stage;
    /// entry `p` is the coefficient of `θ^(p+1)`.
    pub interpolant: Vec<Vec<f64>>,
}

macro_rules! tableaux {
    ($($name:literal => $constructor:path),+ $(,)?) => {
        impl Tableau {
            /// Names of the built-in methods.
            pub const NAMES: &'static [&'static str] = &[$($name),+];

            /// The built-in method of this name.
            ///
            /// # Errors
            /// [`ModelError::UnknownName`] with the names that exist.
            pub fn from_name(name: &str) -> Result<Self, ModelError> {
                match name {
                    $($name => Ok($constructor()),)+
                    _ => Err(ModelError::UnknownName {
                        kind: "method",
                        name: name.to_owned(),
                        known: Self::NAMES.join(", "),
                    }),
                }
            }
        }
    };
}

tableaux! {
    "tsit5" => Tableau::tsit5,
    "rk4" => Tableau::rk4,
    "bs3" => Tableau::bogacki_shampine3,
    "dp5" => Tableau::dormand_prince5,
}

impl Tableau {
    /// A method from its nodes, matrix and weights, without error estimate and with the cubic
    /// Hermite interpolant, which any method has.
    ///
    /// # Errors
    /// [`ModelError::Shape`] if the lengths do not fit, a row of `a` does not sum to its node, or
    /// the weights do not sum to one.
    pub fn custom(
        name: &'static str,
        order: usize,
        c: &[f64],
        a: &[&[f64]],
        b: &[f64],
    ) -> Result<Self, ModelError> {
        let tableau = Self {
            name,
            order,
            embedded_order: None,
            interpolant_order: 3,
            c: c.to_vec(),
            a: a.iter().map(|row| row.to_vec()).collect(),
            b: b.to_vec(),
            error: None,
            interpolant: hermite(b),
        };
        tableau.validate()?;
        Ok(tableau)
    }

    /// Checks lengths and the row-sum conditions `Σ_j a_ij = c_i`, `Σ b_i = 1`, `Σ (b_i − b̂_i) = 0`.
    ///
    /// # Errors
    /// [`ModelError::Shape`] naming the condition that fails.
    pub fn validate(&self) -> Result<(), ModelError> {
        let s = self.stages();
        let fail = |what: String| Err(ModelError::Shape(format!("tableau {}: {what}", self.name)));
        if s == 0 || self.a.len() != s || self.b.len() != s || self.interpolant.len() != s + 1 {
            return fail(format!("a, b, c and the interpolant do not fit {s} stages"));
        }
        for (i, (row, &c)) in self.a.iter().zip(&self.c).enumerate() {
            if row.len() != i {
                return fail(format!("row {i} of a has {} entries, not {i}", row.len()));
            }
            if (row.iter().sum::<f64>() - c).abs() > 1e-12 {
                return fail(format!("row {i} of a does not sum to its node {c}"));
            }
        }
        if (self.b.iter().sum::<f64>() - 1.0).abs() > 1e-12 {
            return fail("the weights b do not sum to 1".into());
        }
        if let Some(error) = &self.error
            && (error.len() != s + 1 || error.iter().sum::<f64>().abs() > 1e-12)
        {
            return fail("the error weights do not fit or do not sum to 0".into());
        }
        Ok(())
    }

    /// Number of stages `s` that make the step, without the FSAL stage.
    #[must_use]
    pub fn stages(&self) -> usize {
        self.c.len()
    }

    /// Number of stages with the FSAL stage, `s + 1`.
    #[must_use]
    pub fn stages_with_fsal(&self) -> usize {
        self.c.len() + 1
    }

    /// Exponent of the step in the error estimate: one more than the order of the embedded method.
    pub(crate) fn error_order(&self) -> usize {
        self.embedded_order.unwrap_or(self.order - 1) + 1
    }

    /// Time of stage `i` (0 to `s`, the FSAL stage last) of a step from `t` to `t_new`, and the side from
    /// which it reads the input.
    #[inline]
    pub(crate) fn stage_time(&self, i: usize, t: f64, t_new: f64) -> (f64, Side) {
        match self.c.get(i) {
            // Only a stage at the very end of the step touches a jump there.
            None | Some(1.0) => (t_new, Side::Left),
            Some(c) => (t + c * (t_new - t), Side::Right),
        }
    }

    /// Weights of the stage derivatives in the state of stage `i`: a row of `a`, or `b` for the FSAL
    /// stage.
    #[inline]
    pub(crate) fn row(&self, i: usize) -> &[f64] {
        self.a.get(i).unwrap_or(&self.b)
    }

    /// The interpolation weight `b_i(θ)` of stage `i`.
    #[must_use]
    pub fn interpolation_weight(&self, i: usize, theta: f64) -> f64 {
        self.interpolant[i].iter().rev().fold(0.0, |sum, &c| (sum + c) * theta)
    }

    /// Writes `y0 + h Σ b_i(θ) k_i` to `out`; `k` holds the stage derivatives of the step one
    /// after the other, the FSAL stage last.
    pub fn interpolate_into<S: Scalar>(
        &self,
        theta: f64,
        h: f64,
        y0: &[S],
        k: &[S],
        out: &mut [S],
    ) {
        out.copy_from_slice(y0);
        for (i, ki) in k.chunks_exact(y0.len()).enumerate() {
            let weight = h * self.interpolation_weight(i, theta);
            for (o, &d) in out.iter_mut().zip(ki) {
                *o += d.scaled(weight);
            }
        }
    }
}
