//! The tree of an expression.

/// An operator with two operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Binary {
    /// `a + b`.
    Add,
    /// `a - b`.
    Subtract,
    /// `a * b`.
    Multiply,
    /// `a / b`.
    Divide,
    /// `a ^ b`.
    Power,
    /// `a < b`, 1 or 0.
    Less,
    /// `a <= b`, 1 or 0.
    LessEqual,
    /// `a > b`, 1 or 0.
    Greater,
    /// `a >= b`, 1 or 0.
    GreaterEqual,
    /// `a == b`, 1 or 0.
    Equal,
    /// `a != b`, 1 or 0.
    NotEqual,
}

macro_rules! functions {
    ($($name:literal => $variant:ident($fewest:literal..=$most:literal): $meaning:literal,)+) => {
        /// A function.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
        pub enum Function {
            $(#[doc = $meaning] $variant,)+
        }

        impl Function {
            /// Every function: its name, itself, its fewest and its most arguments.
            pub const ALL: &'static [(&'static str, Self, usize, usize)] =
                &[$(($name, Self::$variant, $fewest, $most)),+];

            /// The name in text.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),+ }
            }
        }
    };
}

functions! {
    "abs" => Abs(1..=1): "Absolute value.",
    "sign" => Sign(1..=1): "−1, 0 or 1.",
    "step" => Step(1..=1): "1 for an argument of at least 0, else 0.",
    "exp" => Exp(1..=1): "eᵘ.",
    "expm1" => Expm1(1..=1): "eᵘ − 1.",
    "log" => Log(1..=1): "Natural logarithm.",
    "log1p" => Log1p(1..=1): "ln(1 + u).",
    "sqrt" => Sqrt(1..=1): "Square root.",
    "sin" => Sin(1..=1): "Sine.",
    "cos" => Cos(1..=1): "Cosine.",
    "tan" => Tan(1..=1): "Tangent.",
    "asin" => Asin(1..=1): "Inverse of the sine.",
    "acos" => Acos(1..=1): "Inverse of the cosine.",
    "atan" => Atan(1..=1): "Inverse of the tangent.",
    "sinh" => Sinh(1..=1): "Hyperbolic sine.",
    "cosh" => Cosh(1..=1): "Hyperbolic cosine.",
    "tanh" => Tanh(1..=1): "Hyperbolic tangent.",
    "floor" => Floor(1..=1): "Largest whole number that is not greater.",
    "atan2" => Atan2(2..=2): "Angle of the point (second, first).",
    "min" => Min(2..=16): "Smallest of the arguments.",
    "max" => Max(2..=16): "Largest of the arguments.",
    "clamp" => Clamp(3..=3): "First argument, limited to the second and the third.",
    "if" => If(3..=3): "Second argument where the first is not 0, else the third.",
    "network" => Network(2..=2): "The base model's restoring force (N) at another displacement (mm) and velocity (mm/s).",
}

/// A formula over named numbers; names are indices into the list that the text was read with.
#[derive(Debug, Clone, PartialEq)]
pub enum Expression {
    /// A number.
    Number(f64),
    /// A named number.
    Name(usize),
    /// `-a`.
    Negative(Box<Self>),
    /// Two operands.
    Binary(Binary, Box<[Self; 2]>),
    /// A function of arguments.
    Call(Function, Vec<Self>),
}

impl Expression {
    /// Calls `visit` for the expression and all parts of it.
    pub fn visit(&self, visit: &mut impl FnMut(&Self)) {
        visit(self);
        match self {
            Self::Number(_) | Self::Name(_) => {}
            Self::Negative(a) => a.visit(visit),
            Self::Binary(_, ab) => ab.iter().for_each(|part| part.visit(visit)),
            Self::Call(_, arguments) => arguments.iter().for_each(|part| part.visit(visit)),
        }
    }

    /// The names that occur, in ascending order.
    #[must_use]
    pub fn names(&self) -> Vec<usize> {
        let mut names = Vec::new();
        self.visit(&mut |part| {
            if let Self::Name(k) = part {
                names.push(*k);
            }
        });
        names.sort_unstable();
        names.dedup();
        names
    }
}
