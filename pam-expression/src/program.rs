//! A graph as a flat program over a few registers.

use crate::graph::{Dyadic, Graph, Id, Node, Unary};
use crate::slopes::Slopes;
use pam_core::Scalar;

/// Numbers that a program reads.
pub trait Inputs<S: Scalar> {
    /// An input by its index.
    fn input(&self, index: usize) -> S;

    /// The real part of an input.
    #[inline(always)]
    fn real(&self, index: usize) -> f64 {
        self.input(index).real()
    }

    /// Adds the derivatives of `slope` times an input to those of a number.
    #[inline(always)]
    fn add_along(&self, index: usize, slope: f64, to: &mut S) {
        to.add_along(&self.input(index), slope);
    }

    /// The value of `network(x, v)`, for scopes that have it: the base model's restoring force (N) at a displacement and a
    /// velocity.
    fn network_n(&self, x: S, v: S) -> S {
        let _ = (x, v);
        S::zero()
    }
}

/// Inputs in a row.
impl<S: Scalar> Inputs<S> for &[S] {
    #[inline]
    fn input(&self, index: usize) -> S {
        self[index]
    }

    #[inline(always)]
    fn real(&self, index: usize) -> f64 {
        self[index].real()
    }

    #[inline(always)]
    fn add_along(&self, index: usize, slope: f64, to: &mut S) {
        to.add_along(&self[index], slope);
    }
}

/// Operation of an instruction.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Operation {
    Constant(f64),
    Input(u32),
    Scale(f64),
    Offset(f64),
    One(Unary),
    Add,
    Subtract,
    Multiply,
    Divide,
    Negative,
    Square,
    Exp,
    Two(Dyadic),
    Choice,
}

/// One number of a program: from the registers `a`, `b`, `c` into the register `to`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Instruction {
    operation: Operation,
    to: u8,
    a: u8,
    b: u8,
    c: u8,
}

/// An input that is read before the first instruction.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Load {
    input: u32,
    to: u8,
}

/// Expressions, ready to be evaluated with any scalar.
#[derive(Debug, Clone, Default)]
pub struct Program {
    /// Inputs of a short program, which are read in a loop of their own; those of a long one are read where they are used.
    loads: Vec<Load>,
    code: Vec<Instruction>,
    outputs: Vec<u8>,
    registers: usize,
    inputs: Vec<usize>,
    /// The same for numbers with several first derivatives.
    slopes: Option<Slopes>,
}

/// Most registers of a program.
pub const MOST_REGISTERS: usize = 64;
/// Registers of short programs: powers of two, so that no index has to be checked.
const FEW_REGISTERS: usize = 8;
const SOME_REGISTERS: usize = 16;
/// Instructions up to which plain numbers take them one by one.
const SHORT: usize = 16;

impl Program {
    /// The program of these nodes; `None` if it takes more than [`MOST_REGISTERS`].
    #[must_use]
    pub fn new(graph: &Graph, outputs: &[Id]) -> Option<Self> {
        // Inputs that are read first keep a register until their last use, which long programs cannot afford.
        let program = Self::with_registers(graph, outputs, true, SOME_REGISTERS)
            .or_else(|| Self::with_registers(graph, outputs, false, MOST_REGISTERS))?;
        Some(Self { slopes: Slopes::new(graph, outputs), ..program })
    }

    fn with_registers(
        graph: &Graph,
        outputs: &[Id],
        inputs_first: bool,
        most: usize,
    ) -> Option<Self> {
        // Which nodes are needed, and how often.
        let mut uses = vec![0_u32; graph.nodes.len()];
        for &id in outputs {
            // An output keeps its register.
            uses[id] = u32::MAX / 2;
        }
        for id in (0..graph.nodes.len()).rev() {
            if uses[id] > 0 {
                operands(graph.nodes[id]).into_iter().flatten().for_each(|a| uses[a] += 1);
            }
        }
        let is_first = |id: &usize| {
            inputs_first && matches!(graph.nodes[*id], Node::Input(_)) && uses[*id] > 0
        };
        let (first, rest): (Vec<usize>, Vec<usize>) =
            (0..graph.nodes.len()).filter(|id| uses[*id] > 0).partition(is_first);
        let mut program = Self::default();
        let mut register = vec![0_u8; graph.nodes.len()];
        let mut free: Vec<u8> = Vec::new();
        for id in first.into_iter().chain(rest) {
            let node = graph.nodes[id];
            let [a, b, c] = operands(node).map(|operand| operand.map_or(0, |a| register[a]));
            for operand in operands(node).into_iter().flatten() {
                uses[operand] -= 1;
                if uses[operand] == 0 {
                    free.push(register[operand]);
                }
            }
            let to = match free.pop() {
                Some(to) => to,
                None if program.registers < most => {
                    program.registers += 1;
                    (program.registers - 1) as u8
                }
                None => return None,
            };
            register[id] = to;
            let operation = match node {
                Node::Constant(bits) => Operation::Constant(f64::from_bits(bits)),
                Node::Input(k) => {
                    program.inputs.push(k);
                    if inputs_first {
                        program.loads.push(Load { input: k as u32, to });
                        continue;
                    }
                    Operation::Input(k as u32)
                }
                Node::One(Unary::Scale(bits), _) => Operation::Scale(f64::from_bits(bits)),
                Node::One(Unary::Offset(bits), _) => Operation::Offset(f64::from_bits(bits)),
                Node::One(Unary::Negative, _) => Operation::Negative,
                Node::One(Unary::Square, _) => Operation::Square,
                Node::One(Unary::Exp, _) => Operation::Exp,
                Node::One(function, _) => Operation::One(function),
                Node::Two(Dyadic::Add, ..) => Operation::Add,
                Node::Two(Dyadic::Subtract, ..) => Operation::Subtract,
                Node::Two(Dyadic::Multiply, ..) => Operation::Multiply,
                Node::Two(Dyadic::Divide, ..) => Operation::Divide,
                Node::Two(function, ..) => Operation::Two(function),
                Node::Choice(..) => Operation::Choice,
            };
            program.code.push(Instruction { operation, to, a, b, c });
        }
        program.outputs = outputs.iter().map(|&id| register[id]).collect();
        Some(program)
    }

    /// Whether an input is read.
    #[must_use]
    pub fn reads(&self, input: usize) -> bool {
        self.inputs.contains(&input)
    }

    /// The first output.
    #[inline]
    #[must_use]
    pub fn value<S: Scalar>(&self, inputs: &impl Inputs<S>) -> S {
        let mut out = [S::zero()];
        self.values(inputs, &mut out);
        out[0]
    }

    /// As many outputs as `out` has room for.
    #[inline]
    pub fn values<S: Scalar>(&self, inputs: &impl Inputs<S>, out: &mut [S]) {
        if (S::HAS_SEVERAL_SLOPES || (S::NDERIV == 0 && self.code.len() > SHORT))
            && let Some(slopes) = &self.slopes
        {
            return slopes.values(inputs, out);
        }
        // Registers are cleared, so that few are taken for short programs.
        if self.registers <= FEW_REGISTERS {
            self.run::<FEW_REGISTERS, S>(inputs, out);
        } else if self.registers <= SOME_REGISTERS {
            self.run::<SOME_REGISTERS, S>(inputs, out);
        } else {
            self.run::<MOST_REGISTERS, S>(inputs, out);
        }
    }

    fn run<const N: usize, S: Scalar>(&self, inputs: &impl Inputs<S>, out: &mut [S]) {
        const { assert!(N.is_power_of_two()) };
        // Every index is below N as it is; the compiler sees it by the mask.
        let within = |register: u8| register as usize & (N - 1);
        let mut r = [S::zero(); N];
        for load in &self.loads {
            r[within(load.to)] = inputs.input(load.input as usize);
        }
        for step in &self.code {
            let (a, b) = (within(step.a), within(step.b));
            r[within(step.to)] = match step.operation {
                Operation::Constant(value) => S::constant(value),
                Operation::Input(k) => inputs.input(k as usize),
                Operation::Scale(factor) => r[a].scaled(factor),
                Operation::Offset(value) => r[a] + S::constant(value),
                Operation::Add => r[a] + r[b],
                Operation::Subtract => r[a] - r[b],
                Operation::Multiply => r[a] * r[b],
                Operation::Divide => r[a] / r[b],
                Operation::Negative => -r[a],
                Operation::Square => r[a] * r[a],
                Operation::Exp => r[a].exp(),
                Operation::One(function) => unary(function, &r[a]),
                Operation::Two(Dyadic::Network) => inputs.network_n(r[a], r[b]),
                Operation::Two(function) => dyadic(function, &r[a], &r[b]),
                Operation::Choice => r[if r[a].real() == 0.0 { within(step.c) } else { b }],
            };
        }
        for (out, &register) in out.iter_mut().zip(&self.outputs) {
            *out = r[within(register)];
        }
    }
}

pub(crate) fn operands(node: Node) -> [Option<Id>; 3] {
    match node {
        Node::Constant(_) | Node::Input(_) => [None; 3],
        Node::One(_, a) => [Some(a), None, None],
        Node::Two(_, a, b) => [Some(a), Some(b), None],
        Node::Choice(a, b, c) => [Some(a), Some(b), Some(c)],
    }
}

/// A function of one number. It stays a function: in the loop, its many cases would take more room on the stack than the
/// registers.
#[inline(never)]
pub(crate) fn unary<S: Scalar>(function: Unary, a: &S) -> S {
    let real = a.real();
    match function {
        Unary::Negative => -*a,
        Unary::Square => *a * *a,
        Unary::Reciprocal => a.recip(),
        Unary::Abs => a.abs(),
        Unary::Sign => S::constant(if real == 0.0 { 0.0 } else { real.signum() }),
        Unary::Step => S::constant(if real >= 0.0 { 1.0 } else { 0.0 }),
        Unary::Exp => a.exp(),
        Unary::Expm1 => a.exp_m1(),
        Unary::Log => a.ln(),
        Unary::Log1p => a.ln_1p(),
        Unary::Sqrt => a.sqrt(),
        Unary::Sin => a.sin(),
        Unary::Cos => a.cos(),
        Unary::Tan => a.tan(),
        Unary::Asin => a.asin(),
        Unary::Acos => a.acos(),
        Unary::Atan => a.atan(),
        Unary::Sinh => a.sinh(),
        Unary::Cosh => a.cosh(),
        Unary::Tanh => a.tanh(),
        Unary::Floor => S::constant(real.floor()),
        Unary::Scale(bits) => a.scaled(f64::from_bits(bits)),
        Unary::Offset(bits) => *a + S::constant(f64::from_bits(bits)),
        Unary::PowerI(n) => a.powi(n),
        Unary::PowerF(bits) => {
            // The base is a plain number or has derivatives; the exponent has none.
            let exponent = f64::from_bits(bits);
            if real == 0.0 && exponent > 1.0 { S::zero() } else { (a.ln().scaled(exponent)).exp() }
        }
    }
}

/// A function of two numbers; the base model's force is none of them.
#[inline(never)]
pub(crate) fn dyadic<S: Scalar>(function: Dyadic, a: &S, b: &S) -> S {
    let truth = |is: bool| S::constant(if is { 1.0 } else { 0.0 });
    match function {
        Dyadic::Add => *a + *b,
        Dyadic::Subtract => *a - *b,
        Dyadic::Multiply => *a * *b,
        Dyadic::Divide => *a / *b,
        // As in the slope of a graph, a base of zero has none.
        Dyadic::Power if a.real() == 0.0 && b.real() > 0.0 => S::zero(),
        Dyadic::Power => (*b * a.ln()).exp(),
        Dyadic::Minimum => a.minimum(*b),
        Dyadic::Maximum => a.maximum(*b),
        Dyadic::Atan2 => a.atan2(*b),
        Dyadic::Less => truth(a.real() < b.real()),
        Dyadic::LessEqual => truth(a.real() <= b.real()),
        Dyadic::Equal => truth(a.real() == b.real()),
        Dyadic::Network => S::zero(),
    }
}
