//! Any differentiable field in lanes, point by point.

use super::{BatchField, ParameterSums};
use crate::field::{At, Cotangent, DifferentiableField};
use std::marker::PhantomData;

/// Any [`DifferentiableField`] as a batched field, point by point: nothing is shared between points,
/// but every field can run in lanes. The condition of a trajectory is its field, and all parameters
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

/// The field of each lane and its scratch memory.
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

    fn set_condition(&self, lane: usize, condition: &D, lanes: &mut Self::Batch) {
        lanes.fields[lane] = Some((condition.clone(), condition.workspace()));
    }

    fn move_condition(&self, from: usize, to: usize, lanes: &mut Self::Batch) {
        lanes.fields.swap(from, to);
    }

    fn eval_batch(
        &self,
        t: &[f64],
        y: &[f64],
        u: &[f64],
        dy: &mut [f64],
        _kept: &mut [()],
        lanes: &mut Self::Batch,
    ) {
        let (n, m) = (self.state_len, self.input_len);
        for (i, (&t, slot)) in t.iter().zip(&mut lanes.fields).enumerate() {
            let (field, work) = slot.as_mut().expect("the lane has a condition");
            let at = At { t, y: &y[i * n..(i + 1) * n], u: &u[i * m..(i + 1) * m] };
            field.eval_into(at, &mut dy[i * n..(i + 1) * n], work);
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
        t: &[f64],
        y: &[f64],
        u: &[f64],
        _kept: &[()],
        jacobians: &mut [f64],
        block: &mut PointwiseBlock,
    ) {
        let (n, m) = (self.state_len, self.input_len);
        let mut work = condition.workspace();
        jacobians[..t.len() * n * n].fill(0.0);
        for (i, &t) in t.iter().enumerate() {
            let at = At { t, y: &y[i * n..(i + 1) * n], u: &u[i * m..(i + 1) * m] };
            for row in 0..n {
                block.cotangent.fill(0.0);
                block.cotangent[row] = 1.0;
                let start = (i * n + row) * n;
                let sums = Cotangent {
                    y: &mut jacobians[start..start + n],
                    u: &mut block.input_sum,
                    p: &mut block.parameter_sum,
                };
                condition.vjp_into(at, &block.cotangent, sums, &mut work);
            }
        }
    }

    fn accumulate(
        &self,
        condition: &D,
        t: &[f64],
        y: &[f64],
        u: &[f64],
        _kept: &[()],
        w: &[f64],
        sums: &mut ParameterSums<'_>,
        block: &mut PointwiseBlock,
    ) {
        let (n, m) = (self.state_len, self.input_len);
        let mut work = condition.workspace();
        for (i, &t) in t.iter().enumerate() {
            let at = At { t, y: &y[i * n..(i + 1) * n], u: &u[i * m..(i + 1) * m] };
            let sums = Cotangent { y: &mut block.cotangent, u: &mut block.input_sum, p: sums.own };
            condition.vjp_into(at, &w[i * n..(i + 1) * n], sums, &mut work);
        }
    }

    fn drain(&self, _condition: &D, _sums: &mut ParameterSums<'_>, _block: &mut PointwiseBlock) {}
}
