//! A dense layer as one block.
//!
//! Recorded one by one, each of the layer's multiply-adds would take two operations of 32 bytes. The
//! block takes none for them: it says where weights, bias and input lie, which for weights that were
//! made in one go is a range of nodes, and the outputs are the block's nodes. Values come from the
//! element's own layer, so they equal those of a plain run, and the sweeps are two loops over columns.

use super::arena::{Arena, BlockKind, node};
use super::var::wrong_tape;
use super::{Element, Var};

/// `out = W input + bias` with `W` `[outputs, inputs]` column by column.
#[derive(Debug, Clone, Copy)]
pub(super) struct Affine {
    pub(super) outputs: usize,
    pub(super) inputs: usize,
    pub(super) weights: Operand,
    pub(super) bias: Operand,
    pub(super) input: Operand,
}

/// Where a list of numbers lies.
#[derive(Debug, Clone, Copy)]
pub(super) enum Operand {
    /// Consecutive nodes from this one on.
    Range(usize),
    /// Any nodes: the lists of gathered nodes and values hold them from these places on.
    Gathered { nodes: usize, values: usize },
    /// Constants: the list of gathered values holds them from this place on.
    Constant { values: usize },
}

/// The `len` values of an operand, from those of all nodes and those that were gathered.
fn operand_values<'a, T>(
    operand: Operand,
    len: usize,
    by_node: &'a [T],
    gathered: &'a [T],
) -> &'a [T] {
    match operand {
        Operand::Range(first) => &by_node[first..first + len],
        Operand::Gathered { values, .. } | Operand::Constant { values } => {
            &gathered[values..values + len]
        }
    }
}

impl<T: Element> Arena<T> {
    /// The values of an operand of `len` numbers.
    pub(super) fn values_of(&self, operand: Operand, len: usize) -> &[T] {
        operand_values(operand, len, &self.values, &self.gathered_values)
    }

    /// Records a layer and writes its outputs.
    pub(super) fn affine(
        &mut self,
        columns: &[Var<T>],
        bias: &[Var<T>],
        input: &[Var<T>],
        out: &mut [Var<T>],
    ) {
        let before = self.lengths();
        let idle = self.id() == 0;
        if idle && columns.iter().chain(bias).chain(input).any(|var| !var.is_constant()) {
            wrong_tape();
        }
        let (weights, bias) = (self.operand(columns), self.operand(bias));
        let layer = Affine {
            outputs: out.len(),
            inputs: input.len(),
            weights,
            bias,
            input: self.operand(input),
        };
        let first = self.values.len();
        self.push_block(BlockKind::Affine(layer));
        self.values.resize(first + out.len(), T::zero());
        let _fits = node(self.values.len());
        let id = self.id();
        let (earlier, outputs) = self.values.split_at_mut(first);
        let place = |operand, len| operand_values(operand, len, earlier, &self.gathered_values);
        T::affine_into(
            place(layer.weights, columns.len()),
            place(layer.bias, out.len()),
            place(layer.input, input.len()),
            outputs,
        );
        let constant = [layer.weights, layer.bias, layer.input]
            .iter()
            .all(|operand| matches!(operand, Operand::Constant { .. }));
        for (k, (var, &value)) in out.iter_mut().zip(&*outputs).enumerate() {
            *var = if constant {
                Var::constant_of(value)
            } else {
                Var::at(value, (first + k) as u32, id)
            };
        }
        if idle {
            // An idle arena is never dropped, so it must not own memory.
            *self = Self::idle();
        } else if constant {
            self.rewind(before);
        }
    }

    /// Finds out where `vars` lie and gathers them if need be.
    fn operand(&mut self, vars: &[Var<T>]) -> Operand {
        if let Some(&first) = vars.first()
            && first.tape() == self.id()
            && Var::lie_side_by_side(first, vars)
        {
            return Operand::Range(first.node() as usize);
        }
        let (nodes, values) = (self.gathered_nodes.len(), self.gathered_values.len());
        self.gathered_values.extend(vars.iter().map(|var| var.value()));
        if vars.iter().all(|var| var.is_constant()) {
            return Operand::Constant { values };
        }
        if vars.iter().any(|var| !var.is_constant() && var.tape() != self.id()) {
            wrong_tape();
        }
        self.gathered_nodes.extend(vars.iter().map(|var| var.node()));
        Operand::Gathered { nodes, values }
    }
}
