//! The value of a tree.

use pam_vocabulary::definition::{EffectDefinition, Symbol};
use pam_vocabulary::expression::{Binary, Expression, Function};
use std::cell::RefCell;

/// Numbers that an expression reads.
pub(super) struct Known<'a> {
    pub(super) definition: &'a EffectDefinition,
    /// Variables of the language, in its order; those that are not known here are NaN.
    pub(super) variables: [f64; VARIABLES],
    pub(super) values: &'a [f64],
    pub(super) memory: &'a [f64],
    /// The elastic restoring force of the plant (N) at a displacement (mm).
    pub(super) restoring_n: &'a dyn Fn(f64) -> f64,
    /// Named parts that were worked out.
    parts: RefCell<Vec<Option<f64>>>,
}

/// Number of the language's variables.
pub(super) const VARIABLES: usize = 12;

impl<'a> Known<'a> {
    pub(super) fn new(
        definition: &'a EffectDefinition,
        variables: [f64; VARIABLES],
        values: &'a [f64],
        memory: &'a [f64],
        restoring_n: &'a dyn Fn(f64) -> f64,
    ) -> Self {
        let parts = RefCell::new(vec![None; definition.lets.len()]);
        Self { definition, variables, values, memory, restoring_n, parts }
    }

    /// The value of an expression.
    pub(super) fn value(&self, tree: &Expression) -> f64 {
        match tree {
            Expression::Number(number) => *number,
            Expression::Name(k) => self.name(*k),
            Expression::Negative(a) => -self.value(a),
            Expression::Binary(operator, both) => {
                let (a, b) = (self.value(&both[0]), self.value(&both[1]));
                match operator {
                    Binary::Add => a + b,
                    Binary::Subtract => a - b,
                    Binary::Multiply => a * b,
                    Binary::Divide => a / b,
                    Binary::Power => a.powf(b),
                    Binary::Less => f64::from(a < b),
                    Binary::LessEqual => f64::from(a <= b),
                    Binary::Greater => f64::from(a > b),
                    Binary::GreaterEqual => f64::from(a >= b),
                    Binary::Equal => f64::from(a == b),
                    Binary::NotEqual => f64::from(a != b),
                }
            }
            Expression::Call(Function::If, of) => {
                let taken = if self.value(&of[0]) != 0.0 { 1 } else { 2 };
                self.value(&of[taken])
            }
            Expression::Call(function, of) => {
                let of: Vec<f64> = of.iter().map(|a| self.value(a)).collect();
                self.call(*function, &of)
            }
        }
    }

    fn name(&self, k: usize) -> f64 {
        match self.definition.symbol(k) {
            Symbol::Variable(k) => self.variables[k],
            Symbol::Value(k) => self.values[k],
            Symbol::Memory(k) => self.memory[k],
            Symbol::Let(k) => {
                let known = self.parts.borrow()[k];
                known.unwrap_or_else(|| {
                    let value = self.value(&self.definition.lets[k].1.tree);
                    self.parts.borrow_mut()[k] = Some(value);
                    value
                })
            }
        }
    }

    fn call(&self, function: Function, of: &[f64]) -> f64 {
        let a = of[0];
        match function {
            Function::Abs => a.abs(),
            Function::Sign if a == 0.0 => 0.0,
            Function::Sign => a.signum(),
            Function::Step => f64::from(a >= 0.0),
            Function::Exp => a.exp(),
            Function::Expm1 => a.exp_m1(),
            Function::Log => a.ln(),
            Function::Log1p => a.ln_1p(),
            Function::Sqrt => a.sqrt(),
            Function::Sin => a.sin(),
            Function::Cos => a.cos(),
            Function::Tan => a.tan(),
            Function::Asin => a.asin(),
            Function::Acos => a.acos(),
            Function::Atan => a.atan(),
            Function::Sinh => a.sinh(),
            Function::Cosh => a.cosh(),
            Function::Tanh => a.tanh(),
            Function::Floor => a.floor(),
            Function::Atan2 => a.atan2(of[1]),
            Function::Min => of.iter().copied().fold(f64::INFINITY, f64::min),
            Function::Max => of.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            Function::Clamp => a.max(of[1]).min(of[2]),
            Function::If => {
                if a != 0.0 {
                    of[1]
                } else {
                    of[2]
                }
            }
            // The plant's restoring force is that of slow motion.
            Function::Network => (self.restoring_n)(a),
        }
    }
}
