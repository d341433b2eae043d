//! Text to tree, by recursive descent.

use super::error::nearest;
use super::tokens::{Token, tokens};
use super::{Binary, CONSTANTS, Expression, ExpressionError, Function};

/// The names that an expression may use.
pub struct Scope<'a> {
    /// All names; their places are the indices in [`Expression::Name`].
    pub names: &'a [String],
    /// Why a name may not be used here; `None` if it may.
    pub refuses: &'a dyn Fn(usize) -> Option<String>,
    /// Whether the base model's force may be asked for with `network(x, v)`.
    pub network: bool,
}

impl<'a> Scope<'a> {
    /// A scope in which all names may be used.
    #[must_use]
    pub fn of(names: &'a [String]) -> Self {
        Self { names, refuses: &|_| None, network: false }
    }
}

/// Deepest nesting of parentheses, functions and signs.
const DEEPEST: usize = 100;
/// Most words, numbers and signs. A sum of many terms is a deep tree, too.
const MOST_TOKENS: usize = 2000;

impl Expression {
    /// Reads a text.
    ///
    /// # Errors
    /// [`ExpressionError`] with line and column, and the nearest known word for an unknown one.
    pub fn parse(text: &str, scope: &Scope<'_>) -> Result<Self, ExpressionError> {
        let tokens = tokens(text)?;
        if let Some((_, at)) = tokens.get(MOST_TOKENS) {
            let message =
                format!("more than {MOST_TOKENS} words, numbers and signs; define parts of it");
            return Err(ExpressionError::at(text, *at, message));
        }
        let mut parser = Parser { text, tokens, next: 0, depth: 0, scope };
        let expression = parser.comparison()?;
        match parser.peek() {
            Token::End => Ok(expression),
            other => Err(parser.fail(format!("{} is not expected here", shown(other)))),
        }
    }
}

struct Parser<'t, 's> {
    text: &'t str,
    tokens: Vec<(Token<'t>, usize)>,
    next: usize,
    depth: usize,
    scope: &'s Scope<'s>,
}

fn shown(token: Token<'_>) -> String {
    match token {
        Token::Word(word) => format!("`{word}`"),
        Token::Number(number) => format!("`{number}`"),
        Token::Sign(sign) => format!("`{sign}`"),
        Token::End => "the end".into(),
    }
}

impl<'t> Parser<'t, '_> {
    fn peek(&self) -> Token<'t> {
        self.tokens[self.next].0
    }

    fn fail(&self, message: String) -> ExpressionError {
        ExpressionError::at(self.text, self.tokens[self.next].1, message)
    }

    /// Takes the next token if it is one of these signs.
    fn take<T: Copy>(&mut self, signs: &[(&str, T)]) -> Option<T> {
        let Token::Sign(sign) = self.peek() else { return None };
        let (_, found) = signs.iter().find(|(s, _)| *s == sign)?;
        self.next += 1;
        Some(*found)
    }

    fn expect(&mut self, sign: &str) -> Result<(), ExpressionError> {
        self.take(&[(sign, ())]).ok_or_else(|| {
            self.fail(format!("`{sign}` is expected here, not {}", shown(self.peek())))
        })
    }

    /// Operators of one precedence, from the left; `operand` reads what binds tighter.
    fn chain(
        &mut self,
        operators: &[(&str, Binary)],
        operand: fn(&mut Self) -> Result<Expression, ExpressionError>,
    ) -> Result<Expression, ExpressionError> {
        let mut left = operand(self)?;
        while let Some(operator) = self.take(operators) {
            left = Expression::Binary(operator, Box::new([left, operand(self)?]));
        }
        Ok(left)
    }

    fn comparison(&mut self) -> Result<Expression, ExpressionError> {
        const COMPARISONS: [(&str, Binary); 6] = [
            ("<", Binary::Less),
            ("<=", Binary::LessEqual),
            (">", Binary::Greater),
            (">=", Binary::GreaterEqual),
            ("==", Binary::Equal),
            ("!=", Binary::NotEqual),
        ];
        let left = self.sum()?;
        let Some(operator) = self.take(&COMPARISONS) else { return Ok(left) };
        let both = [left, self.sum()?];
        if matches!(self.peek(), Token::Sign(sign) if COMPARISONS.iter().any(|(s, _)| *s == sign)) {
            return Err(self.fail("comparisons are not chained; multiply two of them".into()));
        }
        Ok(Expression::Binary(operator, Box::new(both)))
    }

    fn sum(&mut self) -> Result<Expression, ExpressionError> {
        self.chain(&[("+", Binary::Add), ("-", Binary::Subtract)], Self::product)
    }

    fn product(&mut self) -> Result<Expression, ExpressionError> {
        self.chain(&[("*", Binary::Multiply), ("/", Binary::Divide)], Self::signed)
    }

    fn signed(&mut self) -> Result<Expression, ExpressionError> {
        self.nested(|parser| {
            if parser.take(&[("+", ())]).is_some() {
                return parser.signed();
            }
            if parser.take(&[("-", ())]).is_some() {
                return Ok(Expression::Negative(Box::new(parser.signed()?)));
            }
            let base = parser.atom()?;
            match parser.take(&[("^", ())]) {
                Some(()) => {
                    Ok(Expression::Binary(Binary::Power, Box::new([base, parser.signed()?])))
                }
                None => Ok(base),
            }
        })
    }

    /// Counts the depth, which bounds the use of the stack.
    fn nested(
        &mut self,
        read: impl FnOnce(&mut Self) -> Result<Expression, ExpressionError>,
    ) -> Result<Expression, ExpressionError> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(self.fail(format!("nested deeper than {DEEPEST} times")));
        }
        let expression = read(self);
        self.depth -= 1;
        expression
    }

    fn atom(&mut self) -> Result<Expression, ExpressionError> {
        match self.peek() {
            Token::Number(number) => {
                self.next += 1;
                Ok(Expression::Number(number))
            }
            Token::Sign("(") => {
                self.next += 1;
                let inside = self.comparison()?;
                self.expect(")")?;
                Ok(inside)
            }
            Token::Word(word) => {
                let called = matches!(self.tokens[self.next + 1].0, Token::Sign("("));
                if called { self.call(word) } else { self.name(word) }
            }
            other => Err(self
                .fail(format!("a number, a name or `(` is expected here, not {}", shown(other)))),
        }
    }

    fn name(&mut self, word: &str) -> Result<Expression, ExpressionError> {
        let names = self.scope.names;
        if let Some(k) = names.iter().position(|n| n == word) {
            if let Some(why) = (self.scope.refuses)(k) {
                return Err(self.fail(why));
            }
            self.next += 1;
            return Ok(Expression::Name(k));
        }
        if let Some((_, value)) = CONSTANTS.iter().find(|(n, _)| *n == word) {
            self.next += 1;
            return Ok(Expression::Number(*value));
        }
        if Function::ALL.iter().any(|(n, ..)| *n == word) {
            return Err(
                self.fail(format!("`{word}` is a function; give its arguments: `{word}(…)`"))
            );
        }
        let usable = names.iter().enumerate().filter(|(k, _)| (self.scope.refuses)(*k).is_none());
        let known: Vec<&str> =
            usable.map(|(_, n)| n.as_str()).chain(CONSTANTS.iter().map(|(n, _)| *n)).collect();
        Err(self.fail(unknown("name", word, &known)))
    }

    fn call(&mut self, word: &str) -> Result<Expression, ExpressionError> {
        let known = Function::ALL.iter().filter(|f| self.scope.network || f.1 != Function::Network);
        let Some(&(_, function, fewest, most)) = known.clone().find(|f| f.0 == word) else {
            if self.scope.names.iter().any(|n| n == word) {
                return Err(self
                    .fail(format!("`{word}` is no function; to multiply, write `{word} * (…)`")));
            }
            let known: Vec<&str> = known.map(|f| f.0).collect();
            return Err(self.fail(unknown("function", word, &known)));
        };
        let at = self.next;
        self.next += 1;
        self.expect("(")?;
        let mut arguments = Vec::new();
        if self.take(&[(")", ())]).is_none() {
            loop {
                arguments.push(self.comparison()?);
                if self.take(&[(",", ())]).is_none() {
                    break;
                }
            }
            self.expect(")")?;
        }
        if !(fewest..=most).contains(&arguments.len()) {
            let wanted =
                if fewest == most { fewest.to_string() } else { format!("at least {fewest}") };
            self.next = at;
            let s = if wanted == "1" { "" } else { "s" };
            let given = arguments.len();
            return Err(self.fail(format!("`{word}` takes {wanted} argument{s}, not {given}")));
        }
        Ok(Expression::Call(function, arguments))
    }
}

/// The message for an unknown word.
fn unknown(kind: &str, word: &str, known: &[&str]) -> String {
    let all = known.join(", ");
    match nearest(word, known.iter().copied()) {
        Some(near) => {
            format!("there is no {kind} `{word}`; did you mean `{near}`? There are {all}")
        }
        None => format!("there is no {kind} `{word}`; there are {all}"),
    }
}
