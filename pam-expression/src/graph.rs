//! Expressions as a graph in which equal parts are one node.

use pam_vocabulary::expression::{Binary, Expression, Function};
use std::collections::HashMap;

/// A node of a [`Graph`].
pub type Id = usize;

/// A function of one number, or of one and a plain number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Unary {
    Negative,
    Square,
    Reciprocal,
    Abs,
    Sign,
    Step,
    Exp,
    Expm1,
    Log,
    Log1p,
    Sqrt,
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Floor,
    /// Times a number, whose bits these are.
    Scale(u64),
    /// Plus a number.
    Offset(u64),
    /// To a whole power.
    PowerI(i32),
    /// To a power.
    PowerF(u64),
}

/// A function of two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Dyadic {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Minimum,
    Maximum,
    Atan2,
    Less,
    LessEqual,
    Equal,
    /// The base model's force.
    Network,
}

/// A number of a graph.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Node {
    /// A plain number, by its bits.
    Constant(u64),
    /// An input, by its index.
    Input(usize),
    One(Unary, Id),
    Two(Dyadic, Id, Id),
    /// The second where the first is not 0, else the third.
    Choice(Id, Id, Id),
}

/// Expressions as nodes, each behind those that it uses; equal parts are one node.
#[derive(Debug, Default, Clone)]
pub struct Graph {
    pub(crate) nodes: Vec<Node>,
    known: HashMap<Node, Id>,
}

impl Graph {
    fn node(&mut self, node: Node) -> Id {
        *self.known.entry(node).or_insert_with(|| {
            self.nodes.push(node);
            self.nodes.len() - 1
        })
    }

    /// A plain number.
    pub fn constant(&mut self, value: f64) -> Id {
        self.node(Node::Constant(value.to_bits()))
    }

    /// An input by its index.
    pub fn input(&mut self, index: usize) -> Id {
        self.node(Node::Input(index))
    }

    /// The value of a node that is a plain number, also where it became one because nothing else is left of it.
    #[must_use]
    pub fn value(&self, id: Id) -> Option<f64> {
        match self.nodes[id] {
            Node::Constant(bits) => Some(f64::from_bits(bits)),
            _ => None,
        }
    }

    fn one(&mut self, function: Unary, a: Id) -> Id {
        match (function, self.value(a)) {
            (_, Some(value)) => self.constant(unary(function, value)),
            (Unary::Scale(bits), None) => self.scaled(a, f64::from_bits(bits)),
            (Unary::Negative, None) => self.scaled(a, -1.0),
            _ => self.node(Node::One(function, a)),
        }
    }

    /// Whether a node is this input as it is.
    #[must_use]
    pub fn is_input(&self, id: Id, index: usize) -> bool {
        self.nodes[id] == Node::Input(index)
    }

    /// `a + b`.
    pub fn add(&mut self, a: Id, b: Id) -> Id {
        self.two(Dyadic::Add, a, b)
    }

    /// `a − b`.
    pub fn subtract(&mut self, a: Id, b: Id) -> Id {
        self.two(Dyadic::Subtract, a, b)
    }

    /// `a · b`.
    pub fn multiply(&mut self, a: Id, b: Id) -> Id {
        self.two(Dyadic::Multiply, a, b)
    }

    /// The larger of two numbers; the first one on a tie.
    pub fn maximum(&mut self, a: Id, b: Id) -> Id {
        self.two(Dyadic::Maximum, a, b)
    }

    /// `factor · a`.
    pub fn scaled(&mut self, a: Id, factor: f64) -> Id {
        if let Some(value) = self.value(a) {
            return self.constant(factor * value);
        }
        match (factor, self.nodes[a]) {
            (0.0, _) => self.constant(0.0),
            (1.0, _) => a,
            (_, Node::One(Unary::Scale(bits), b)) => self.scaled(b, f64::from_bits(bits) * factor),
            (-1.0, Node::One(Unary::Negative, b)) => b,
            (-1.0, _) => self.node(Node::One(Unary::Negative, a)),
            (_, Node::One(Unary::Negative, b)) => self.scaled(b, -factor),
            _ => self.node(Node::One(Unary::Scale(factor.to_bits()), a)),
        }
    }

    fn two(&mut self, function: Dyadic, a: Id, b: Id) -> Id {
        use Dyadic::{Add, Divide, Multiply, Power, Subtract};
        let (left, right) = (self.value(a), self.value(b));
        if let (Some(x), Some(y)) = (left, right)
            && function != Dyadic::Network
        {
            return self.constant(dyadic(function, x, y));
        }
        match (function, left, right) {
            (Add | Subtract, _, Some(0.0)) | (Multiply | Divide | Power, _, Some(1.0)) => a,
            (Add, Some(0.0), _) => b,
            (Subtract, Some(0.0), _) => self.scaled(b, -1.0),
            (Add, _, Some(c)) => self.node(Node::One(Unary::Offset(c.to_bits()), a)),
            (Add, Some(c), _) => self.node(Node::One(Unary::Offset(c.to_bits()), b)),
            (Subtract, _, Some(c)) => self.node(Node::One(Unary::Offset((-c).to_bits()), a)),
            (Subtract, Some(c), _) => {
                let negative = self.scaled(b, -1.0);
                self.node(Node::One(Unary::Offset(c.to_bits()), negative))
            }
            (Multiply, _, Some(c)) => self.scaled(a, c),
            (Multiply, Some(c), _) => self.scaled(b, c),
            (Divide, Some(0.0), _) => self.constant(0.0),
            (Divide, _, Some(c)) => self.scaled(a, 1.0 / c),
            (Divide, Some(c), _) => {
                let reciprocal = self.node(Node::One(Unary::Reciprocal, b));
                self.scaled(reciprocal, c)
            }
            (Power, _, Some(0.0)) => self.constant(1.0),
            (Power, _, Some(2.0)) => self.node(Node::One(Unary::Square, a)),
            (Power, _, Some(c)) if c.fract() == 0.0 && c.abs() <= 64.0 => {
                self.node(Node::One(Unary::PowerI(c as i32), a))
            }
            (Power, _, Some(c)) => self.node(Node::One(Unary::PowerF(c.to_bits()), a)),
            (Multiply, None, None) if a == b => self.node(Node::One(Unary::Square, a)),
            // Equal parts are one node in either order.
            (Add | Multiply, None, None) if b < a => self.node(Node::Two(function, b, a)),
            _ => self.node(Node::Two(function, a, b)),
        }
    }

    fn choice(&mut self, condition: Id, a: Id, b: Id) -> Id {
        match self.value(condition) {
            Some(value) => {
                if value == 0.0 {
                    b
                } else {
                    a
                }
            }
            None if a == b => a,
            None => self.node(Node::Choice(condition, a, b)),
        }
    }

    /// Adds an expression; `name` gives the nodes of its names.
    pub fn expression(
        &mut self,
        tree: &Expression,
        name: &mut impl FnMut(&mut Self, usize) -> Id,
    ) -> Id {
        match tree {
            Expression::Number(value) => self.constant(*value),
            Expression::Name(k) => name(self, *k),
            Expression::Negative(a) => {
                let a = self.expression(a, name);
                self.scaled(a, -1.0)
            }
            Expression::Binary(operator, both) => {
                let a = self.expression(&both[0], name);
                let b = self.expression(&both[1], name);
                match operator {
                    Binary::Add => self.two(Dyadic::Add, a, b),
                    Binary::Subtract => self.two(Dyadic::Subtract, a, b),
                    Binary::Multiply => self.two(Dyadic::Multiply, a, b),
                    Binary::Divide => self.two(Dyadic::Divide, a, b),
                    Binary::Power => self.two(Dyadic::Power, a, b),
                    Binary::Less => self.two(Dyadic::Less, a, b),
                    Binary::LessEqual => self.two(Dyadic::LessEqual, a, b),
                    Binary::Greater => self.two(Dyadic::Less, b, a),
                    Binary::GreaterEqual => self.two(Dyadic::LessEqual, b, a),
                    Binary::Equal => self.two(Dyadic::Equal, a, b),
                    Binary::NotEqual => {
                        let equal = self.two(Dyadic::Equal, a, b);
                        let negative = self.scaled(equal, -1.0);
                        let one = self.constant(1.0);
                        self.two(Dyadic::Add, negative, one)
                    }
                }
            }
            Expression::Call(function, arguments) => {
                let of: Vec<Id> = arguments.iter().map(|a| self.expression(a, name)).collect();
                self.call(*function, &of)
            }
        }
    }

    fn call(&mut self, function: Function, of: &[Id]) -> Id {
        let unary = match function {
            Function::Abs => Unary::Abs,
            Function::Sign => Unary::Sign,
            Function::Step => Unary::Step,
            Function::Exp => Unary::Exp,
            Function::Expm1 => Unary::Expm1,
            Function::Log => Unary::Log,
            Function::Log1p => Unary::Log1p,
            Function::Sqrt => Unary::Sqrt,
            Function::Sin => Unary::Sin,
            Function::Cos => Unary::Cos,
            Function::Tan => Unary::Tan,
            Function::Asin => Unary::Asin,
            Function::Acos => Unary::Acos,
            Function::Atan => Unary::Atan,
            Function::Sinh => Unary::Sinh,
            Function::Cosh => Unary::Cosh,
            Function::Tanh => Unary::Tanh,
            Function::Floor => Unary::Floor,
            Function::Atan2 => return self.two(Dyadic::Atan2, of[0], of[1]),
            Function::Network => return self.two(Dyadic::Network, of[0], of[1]),
            Function::If => return self.choice(of[0], of[1], of[2]),
            Function::Min | Function::Max => {
                let dyadic =
                    if function == Function::Min { Dyadic::Minimum } else { Dyadic::Maximum };
                let (first, rest) = (of[0], &of[1..]);
                return rest.iter().fold(first, |a, &b| self.two(dyadic, a, b));
            }
            Function::Clamp => {
                let above = self.two(Dyadic::Maximum, of[0], of[1]);
                return self.two(Dyadic::Minimum, above, of[2]);
            }
        };
        self.one(unary, of[0])
    }

    /// The derivative of a node by an input; `None` if it needs one of the base model's force.
    pub fn derivative(&mut self, of: Id, by: usize) -> Option<Id> {
        let mut known = HashMap::new();
        self.derivative_of(of, by, &mut known)
    }

    fn derivative_of(
        &mut self,
        of: Id,
        by: usize,
        known: &mut HashMap<Id, Option<Id>>,
    ) -> Option<Id> {
        if let Some(&found) = known.get(&of) {
            return found;
        }
        let found = match self.nodes[of] {
            Node::Constant(_) => Some(self.constant(0.0)),
            Node::Input(k) => Some(self.constant(if k == by { 1.0 } else { 0.0 })),
            Node::One(function, a) => self.derivative_of(a, by, known).map(|da| {
                if self.value(da) == Some(0.0) {
                    return da;
                }
                let slope = self.slope(function, of, a);
                self.two(Dyadic::Multiply, slope, da)
            }),
            Node::Two(function, a, b) => {
                let da = self.derivative_of(a, by, known);
                let db = self.derivative_of(b, by, known);
                match (da, db) {
                    (Some(da), Some(db)) => self.slope_of_two(function, of, [a, b], [da, db]),
                    _ => None,
                }
            }
            Node::Choice(condition, a, b) => {
                let da = self.derivative_of(a, by, known);
                let db = self.derivative_of(b, by, known);
                da.zip(db).map(|(da, db)| self.choice(condition, da, db))
            }
        };
        known.insert(of, found);
        found
    }

    /// Slope of a function of one number; `of` is its value.
    fn slope(&mut self, function: Unary, of: Id, a: Id) -> Id {
        let one = self.constant(1.0);
        let square = |graph: &mut Self, id: Id| graph.one(Unary::Square, id);
        match function {
            Unary::Negative => self.constant(-1.0),
            Unary::Square => self.scaled(a, 2.0),
            Unary::Reciprocal => {
                let squared = square(self, of);
                self.scaled(squared, -1.0)
            }
            Unary::Abs => {
                let zero = self.constant(0.0);
                let below = self.two(Dyadic::Less, a, zero);
                let minus = self.constant(-1.0);
                self.choice(below, minus, one)
            }
            Unary::Sign | Unary::Step | Unary::Floor => self.constant(0.0),
            Unary::Exp => of,
            Unary::Expm1 => self.two(Dyadic::Add, of, one),
            Unary::Log => self.two(Dyadic::Divide, one, a),
            Unary::Log1p => {
                let sum = self.two(Dyadic::Add, a, one);
                self.two(Dyadic::Divide, one, sum)
            }
            Unary::Sqrt => {
                let half = self.constant(0.5);
                self.two(Dyadic::Divide, half, of)
            }
            Unary::Sin => self.one(Unary::Cos, a),
            Unary::Cos => {
                let sine = self.one(Unary::Sin, a);
                self.scaled(sine, -1.0)
            }
            Unary::Tan => {
                let squared = square(self, of);
                self.two(Dyadic::Add, squared, one)
            }
            Unary::Asin | Unary::Acos => {
                let squared = square(self, a);
                let rest = self.two(Dyadic::Subtract, one, squared);
                let root = self.one(Unary::Sqrt, rest);
                let sign = self.constant(if function == Unary::Asin { 1.0 } else { -1.0 });
                self.two(Dyadic::Divide, sign, root)
            }
            Unary::Atan => {
                let squared = square(self, a);
                let sum = self.two(Dyadic::Add, squared, one);
                self.two(Dyadic::Divide, one, sum)
            }
            Unary::Sinh => self.one(Unary::Cosh, a),
            Unary::Cosh => self.one(Unary::Sinh, a),
            Unary::Tanh => {
                let squared = square(self, of);
                self.two(Dyadic::Subtract, one, squared)
            }
            Unary::Scale(bits) => self.constant(f64::from_bits(bits)),
            Unary::Offset(_) => one,
            Unary::PowerI(_) | Unary::PowerF(_) => {
                let exponent = match function {
                    Unary::PowerI(n) => f64::from(n),
                    Unary::PowerF(bits) => f64::from_bits(bits),
                    _ => unreachable!("the arm has powers alone"),
                };
                let less = self.constant(exponent - 1.0);
                let power = self.two(Dyadic::Power, a, less);
                self.scaled(power, exponent)
            }
        }
    }

    fn slope_of_two(
        &mut self,
        function: Dyadic,
        of: Id,
        [a, b]: [Id; 2],
        [da, db]: [Id; 2],
    ) -> Option<Id> {
        let constant = self.value(da) == Some(0.0) && self.value(db) == Some(0.0);
        if constant {
            return Some(da);
        }
        let times = |graph: &mut Self, x: Id, y: Id| graph.two(Dyadic::Multiply, x, y);
        Some(match function {
            Dyadic::Add | Dyadic::Subtract => self.two(function, da, db),
            Dyadic::Multiply => {
                let (left, right) = (times(self, da, b), times(self, a, db));
                self.two(Dyadic::Add, left, right)
            }
            Dyadic::Divide => {
                // (da − (a/b) db)/b.
                let change = times(self, of, db);
                let top = self.two(Dyadic::Subtract, da, change);
                self.two(Dyadic::Divide, top, b)
            }
            Dyadic::Power => {
                // aᵇ (db ln a + b da/a); at a = 0 the bracket does not exist, and the slope is set to zero.
                let log = self.one(Unary::Log, a);
                let first = times(self, db, log);
                let ratio = self.two(Dyadic::Divide, da, a);
                let second = times(self, b, ratio);
                let sum = self.two(Dyadic::Add, first, second);
                let slope = times(self, of, sum);
                let zero = self.constant(0.0);
                let is_zero = self.two(Dyadic::Equal, a, zero);
                self.choice(is_zero, zero, slope)
            }
            Dyadic::Minimum => {
                let taken = self.two(Dyadic::Less, b, a);
                self.choice(taken, db, da)
            }
            Dyadic::Maximum => {
                let taken = self.two(Dyadic::Less, a, b);
                self.choice(taken, db, da)
            }
            Dyadic::Atan2 => {
                let (left, right) = (times(self, b, da), times(self, a, db));
                let top = self.two(Dyadic::Subtract, left, right);
                let squares = [a, b].map(|id| self.one(Unary::Square, id));
                let bottom = self.two(Dyadic::Add, squares[0], squares[1]);
                self.two(Dyadic::Divide, top, bottom)
            }
            Dyadic::Less | Dyadic::LessEqual | Dyadic::Equal => self.constant(0.0),
            Dyadic::Network => return None,
        })
    }
}

/// A function of one plain number.
fn unary(function: Unary, a: f64) -> f64 {
    crate::program::unary(function, &a)
}

/// A function of two plain numbers.
fn dyadic(function: Dyadic, a: f64, b: f64) -> f64 {
    crate::program::dyadic(function, &a, &b)
}
