//! Any differentiable field as a batched field, point by point.

use super::{BatchField, ParameterSums, Points};
use crate::field::{Cotangent, DifferentiableField};
use std::marker::PhantomData;

/// Any [`DifferentiableField`] as a batched field, point by point: nothing is shared between points,
/// but every field can run in batches. The condition of a trajectory is its field, and all parameters
/// are the condition's own.
#[derive(Debug, Clone, Copy)]
pub struct Pointwise<D> {
    state_len: usize,
    input_len: usize,
    parameter_len: usize,
    field: PhantomData<fn() -> D>,
}

impl<D: DifferentiableField> Pointwise<D> {
    /// A batched field for trajectories of fields shaped like `field`.
    pub fn like(field: &D) -> Self {
        Self {
            state_len: field.state_len(),
            input_len: field.input_len(),
            parameter_len: field.parameter_len(),
            field: PhantomData,
        }
    }
}

/// The field of each member and its scratch memory.
#[derive(Debug)]
pub struct PointwiseBatch<D: DifferentiableField> {
    fields: Vec<Option<(D, D::Workspace)>>,
}

/// Scratch memory of a block.
#[derive(Debug)]
pub struct PointwiseBlock {
    cotangent: Vec<f64>,
    input_sum: Vec<f64>,
    parameter_sum: Vec<f64>,
}

impl<D> BatchField for Pointwise<D>
where
    D: DifferentiableField + Clone + Send + Sync,
    D::Workspace: Send,
{
    type Condition = D;
    type Batch = PointwiseBatch<D>;
    type Block = PointwiseBlock;
    type Kept = ();

    fn state_len(&self) -> usize {
        self.state_len
    }
    fn input_len(&self) -> usize {
        self.input_len
    }
    fn parameter_len(&self) -> usize {
        0
    }
    fn condition_len(&self) -> usize {
        self.parameter_len
    }

    fn kept_len(&self) -> usize {
        0
    }

    fn batch(&self, capacity: usize) -> Self::Batch {
        PointwiseBatch { fields: (0..capacity).map(|_| None).collect() }
    }

    fn set_condition(&self, member: usize, condition: &D, batch: &mut Self::Batch) {
        batch.fields[member] = Some((condition.clone(), condition.workspace()));
    }

    fn move_condition(&self, from: usize, to: usize, batch: &mut Self::Batch) {
        batch.fields.swap(from, to);
    }

    fn eval_batch(
        &self,
        points: Points<'_>,
        dy: &mut [f64],
        _kept: &mut [()],
        batch: &mut Self::Batch,
    ) {
        let n = self.state_len;
        let each = points.each(n, self.input_len).zip(dy.chunks_exact_mut(n));
        for ((at, dy), slot) in each.zip(&mut batch.fields) {
            let (field, work) = slot.as_mut().expect("the member has a condition");
            field.eval_into(at, dy, work);
        }
    }

    fn block(&self, _capacity: usize) -> PointwiseBlock {
        PointwiseBlock {
            cotangent: vec![0.0; self.state_len],
            input_sum: vec![0.0; self.input_len],
            parameter_sum: vec![0.0; self.parameter_len],
        }
    }

    fn linearise(
        &self,
        condition: &D,
        points: Points<'_>,
        _kept: &[()],
        jacobians: &mut [f64],
        block: &mut PointwiseBlock,
    ) {
        let n = self.state_len;
        let mut work = condition.workspace();
        let each = points.each(n, self.input_len).zip(jacobians.chunks_exact_mut(n * n));
        for (at, jacobian) in each {
            jacobian.fill(0.0);
            for (row, y) in jacobian.chunks_exact_mut(n).enumerate() {
                block.cotangent.fill(0.0);
                block.cotangent[row] = 1.0;
                let (u, p) = (&mut block.input_sum, &mut block.parameter_sum);
                let sums = Cotangent { y, u, p };
                condition.vjp_into(at, &block.cotangent, sums, &mut work);
            }
        }
    }

    fn accumulate(
        &self,
        condition: &D,
        points: Points<'_>,
        _kept: &[()],
        w: &[f64],
        sums: &mut ParameterSums<'_>,
        block: &mut PointwiseBlock,
    ) {
        let n = self.state_len;
        let mut work = condition.workspace();
        for (at, w) in points.each(n, self.input_len).zip(w.chunks_exact(n)) {
            let sums = Cotangent { y: &mut block.cotangent, u: &mut block.input_sum, p: sums.own };
            condition.vjp_into(at, w, sums, &mut work);
        }
    }

    fn drain(&self, _condition: &D, _sums: &mut ParameterSums<'_>, _block: &mut PointwiseBlock) {}
}
