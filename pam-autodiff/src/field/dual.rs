//! Fields differentiated by dual numbers.

use super::{At, Cotangent, DifferentiableField, Differentiation, Tangent};
use crate::numbers::Chunk;
use num_dual::Dual64;
use pam_core::{ParametricField, Scalar, VectorField, scalar};

/// Differentiates any [`ParametricField`] by dual numbers, eight directions at a time; see
/// [`ByChunk`] for the cost and for other numbers of directions.
///
/// ```
/// use pam_autodiff::{At, ByDual, DifferentiableField, Differentiation, Tangent};
/// use pam_core::{Chambers, JointField, JointModel, SpringDamper};
/// let model = JointModel::datasheet(SpringDamper::constant(150e3, 6000.0));
/// let joint = JointField::new(model, Chambers::OpenValves);
/// let field = ByDual.of(&joint);
/// let mut work = field.workspace();
/// let mut dy = [0.0; 6];
/// let at = At { t: 0.0, y: &[0.5, 1.0, 300.0, 300.0, 0.06, 0.07], u: &[0.0; 3] };
/// // One more millinewton of force.
/// let v = Tangent { y: &[0.0; 6], u: &[1.0, 0.0, 0.0], p: &vec![0.0; field.parameter_len()] };
/// field.jvp_into(at, v, &mut dy, &mut work);
/// assert_eq!(dy[1], 1.0 / joint.physical().mass_kg);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ByDual;

/// Differentiates any [`ParametricField`] by dual numbers, `N` directions at a time.
///
/// - A product from the right is one evaluation with [`Dual64`]. The field must be bound to the
///   parameters' tangent first; the last binding is kept, so a direction that is followed along a
///   trajectory, or a change of state and input alone, binds once and then allocates nothing. A new
///   parameter direction binds anew, which allocates what the field's own numbers take.
/// - A product from the left goes through the columns of the Jacobian: `⌈(states + inputs)/N⌉ +
///   ⌈parameters/N⌉` evaluations with [`Chunk`]. The bindings of all columns are made at the first
///   product and kept, so that later ones allocate nothing, as long as they take less than
///   [`KEPT_BYTES`](Self::KEPT_BYTES); past that (some 2000 parameters) every product binds anew.
///
/// For a field with many parameters use [`ByTape`](super::ByTape).
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct ByChunk<const N: usize>;

impl<const N: usize> ByChunk<N> {
    /// Bindings to parameters are kept up to this size.
    pub const KEPT_BYTES: usize = 64 << 20;
}

/// A field that [`ByDual`] or [`ByChunk`] differentiates.
#[derive(Debug, Clone)]
pub struct DualField<'a, F, const N: usize = 8> {
    field: &'a F,
    parameters: Vec<f64>,
}

impl<F: ParametricField> Differentiation<F> for ByDual {
    type Field<'a>
        = DualField<'a, F>
    where
        F: 'a;

    fn name(&self) -> &'static str {
        "dual"
    }

    fn of<'a>(&'a self, field: &'a F) -> DualField<'a, F> {
        DualField { field, parameters: field.parameters() }
    }
}

impl<F: ParametricField, const N: usize> Differentiation<F> for ByChunk<N> {
    type Field<'a>
        = DualField<'a, F, N>
    where
        F: 'a;

    fn name(&self) -> &'static str {
        "dual_chunk"
    }

    fn of<'a>(&'a self, field: &'a F) -> DualField<'a, F, N> {
        const { assert!(N > 0, "a chunk has at least one direction") };
        DualField { field, parameters: field.parameters() }
    }
}

/// Arguments, result and scratch memory of one evaluation.
#[derive(Debug)]
struct Evaluation<S> {
    y: Vec<S>,
    u: Vec<S>,
    dy: Vec<S>,
    scratch: Vec<S>,
}

impl<S: Scalar> Evaluation<S> {
    fn new(states: usize, inputs: usize) -> Self {
        let zeros = scalar::zeros;
        Self { y: zeros(states), u: zeros(inputs), dy: zeros(states), scratch: Vec::new() }
    }

    /// Evaluates `field` with `argument(k, x_k)` for the k-th of all states and inputs.
    fn run(&mut self, field: &impl VectorField<S>, at: At<'_>, argument: impl Fn(usize, f64) -> S) {
        let arguments = self.y.iter_mut().chain(&mut self.u);
        for (k, (number, &value)) in arguments.zip(at.y.iter().chain(at.u)).enumerate() {
            *number = argument(k, value);
        }
        self.scratch.resize(field.work_len().max(self.scratch.len()), S::zero());
        field.eval_into(at.t, &self.y, &self.u, &mut self.dy, &mut self.scratch);
    }
}

/// The field bound to dual numbers.
#[derive(Debug)]
pub struct DualWorkspace<D, C, const N: usize> {
    plain_scratch: Vec<f64>,
    dual: Evaluation<Dual64>,
    /// The last direction of the parameters, and the field bound to it.
    direction: Vec<f64>,
    along_direction: D,
    dual_parameters: Vec<Dual64>,
    chunk: Evaluation<Chunk<N>>,
    /// The field with parameters that do not move.
    fixed: C,
    /// The field with the `k`-th `N` parameters as variables, as far as they are kept.
    moving: Vec<Option<C>>,
    chunk_parameters: Vec<Chunk<N>>,
}

impl<F: ParametricField, const N: usize> DualField<'_, F, N> {
    /// Adds `wᵀ ∂f/∂ε_k` to the sums of the directions `k`.
    fn add_columns<'s>(
        dy: &[Chunk<N>],
        w: &[f64],
        sums: impl Iterator<Item = &'s mut f64>,
        first: usize,
    ) {
        for (k, sum) in sums.skip(first).take(N).enumerate() {
            *sum += dy.iter().zip(w).map(|(d, &w)| w * d.derivatives[k]).sum::<f64>();
        }
    }

    /// The field with the parameters from `first` on as variables.
    fn bind(&self, first: usize, parameters: &mut [Chunk<N>]) -> F::With<Chunk<N>> {
        for (k, (number, &value)) in parameters.iter_mut().zip(&self.parameters).enumerate() {
            *number = Chunk::seeded(value, k, first);
        }
        self.field.with_parameters(parameters)
    }
}

impl<F: ParametricField, const N: usize> DifferentiableField for DualField<'_, F, N> {
    type Workspace = DualWorkspace<F::With<Dual64>, F::With<Chunk<N>>, N>;

    fn state_len(&self) -> usize {
        self.field.state_len()
    }

    fn input_len(&self) -> usize {
        self.field.input_len()
    }

    fn parameter_len(&self) -> usize {
        self.parameters.len()
    }

    fn workspace(&self) -> Self::Workspace {
        let (states, inputs) = (self.state_len(), self.input_len());
        let dual: Vec<_> = self.parameters.iter().map(|&p| Dual64::constant(p)).collect();
        let chunk: Vec<_> = self.parameters.iter().map(|&p| Chunk::constant(p)).collect();
        let chunks = self.parameters.len().div_ceil(N);
        let bytes = chunks * self.parameters.len() * size_of::<Chunk<N>>();
        let kept = if bytes <= ByChunk::<N>::KEPT_BYTES { chunks } else { 0 };
        DualWorkspace {
            plain_scratch: vec![0.0; self.field.work_len()],
            dual: Evaluation::new(states, inputs),
            direction: vec![0.0; self.parameters.len()],
            along_direction: self.field.with_parameters(&dual),
            dual_parameters: dual,
            chunk: Evaluation::new(states, inputs),
            fixed: self.field.with_parameters(&chunk),
            moving: (0..kept).map(|_| None).collect(),
            chunk_parameters: chunk,
        }
    }

    fn eval_into(&self, at: At<'_>, dy: &mut [f64], work: &mut Self::Workspace) {
        self.field.eval_into(at.t, at.y, at.u, dy, &mut work.plain_scratch);
    }

    fn vjp_into(&self, at: At<'_>, w: &[f64], sums: Cotangent<'_>, work: &mut Self::Workspace) {
        for first in (0..sums.y.len() + sums.u.len()).step_by(N) {
            work.chunk.run(&work.fixed, at, |k, value| Chunk::seeded(value, k, first));
            let both = sums.y.iter_mut().chain(&mut *sums.u);
            Self::add_columns(&work.chunk.dy, w, both, first);
        }
        for first in (0..sums.p.len()).step_by(N) {
            let constant = |_, value| Chunk::constant(value);
            if let Some(kept) = work.moving.get_mut(first / N) {
                let bound =
                    kept.get_or_insert_with(|| self.bind(first, &mut work.chunk_parameters));
                work.chunk.run(bound, at, constant);
            } else {
                let bound = self.bind(first, &mut work.chunk_parameters);
                work.chunk.run(&bound, at, constant);
            }
            Self::add_columns(&work.chunk.dy, w, sums.p.iter_mut(), first);
        }
    }

    fn jvp_into(&self, at: At<'_>, v: Tangent<'_>, dy: &mut [f64], work: &mut Self::Workspace) {
        if work.direction != v.p {
            work.direction.copy_from_slice(v.p);
            for (number, &change) in work.dual_parameters.iter_mut().zip(v.p) {
                number.eps = change;
            }
            work.along_direction = self.field.with_parameters(&work.dual_parameters);
        }
        let states = v.y.len();
        work.dual.run(&work.along_direction, at, |k, value| {
            Dual64::new(value, if k < states { v.y[k] } else { v.u[k - states] })
        });
        for (out, result) in dy.iter_mut().zip(&work.dual.dy) {
            *out = result.eps;
        }
    }
}
