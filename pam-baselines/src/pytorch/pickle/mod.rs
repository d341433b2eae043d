//! A reader of pickles that runs nothing.
//!
//! Pickle is a program for a stack machine (Python's `pickletools` documents its instructions). Where
//! Python would call a function, this reader keeps the function's name with its arguments; what they mean
//! is for whoever asked. It knows the instructions of protocol 2, in which PyTorch writes checkpoints, and
//! those that protocols 3 and 4 add for plain data.

mod machine;

/// A node of the object graph.
#[derive(Debug, Clone, PartialEq)]
pub enum Node {
    /// `None`.
    None,
    /// `True` or `False`.
    Bool(bool),
    /// An integer.
    Int(i64),
    /// A float.
    Float(f64),
    /// A text.
    Text(String),
    /// Bytes.
    Bytes(Vec<u8>),
    /// A tuple.
    Tuple(Vec<usize>),
    /// A list.
    List(Vec<usize>),
    /// A dictionary, in the order of its entries.
    Dict(Vec<(usize, usize)>),
    /// A function or class by module and name.
    Global(String, String),
    /// A function with its arguments, not called; with `Some` the state that was given to the result.
    Call(usize, usize, Option<usize>),
    /// An object that is kept outside the pickle.
    Persistent(usize),
}

/// The object graph of a pickle.
#[derive(Debug, Clone, PartialEq)]
pub struct Pickle {
    nodes: Vec<Node>,
    root: usize,
}

impl Pickle {
    /// Reads a pickle.
    ///
    /// # Errors
    /// What is wrong, with the offset.
    pub fn read(bytes: &[u8]) -> Result<Self, String> {
        let (nodes, root) = machine::run(bytes)?;
        Ok(Self { nodes, root })
    }

    /// The object itself.
    #[must_use]
    pub fn root(&self) -> usize {
        self.root
    }

    /// A node.
    #[must_use]
    pub fn node(&self, id: usize) -> &Node {
        &self.nodes[id]
    }

    /// The value of a text key of a dictionary (also of an `OrderedDict`).
    #[must_use]
    pub fn get(&self, dict: usize, key: &str) -> Option<usize> {
        self.entries(dict).find(|(k, _)| *k == key).map(|(_, v)| v)
    }

    /// Entries of a dictionary with text keys.
    pub fn entries(&self, dict: usize) -> impl Iterator<Item = (&str, usize)> {
        let pairs: &[(usize, usize)] = match &self.nodes[dict] {
            Node::Dict(pairs) => pairs,
            _ => &[],
        };
        pairs.iter().filter_map(|(k, v)| match &self.nodes[*k] {
            Node::Text(text) => Some((text.as_str(), *v)),
            _ => None,
        })
    }

    /// Items of a tuple or list.
    #[must_use]
    pub fn items(&self, id: usize) -> &[usize] {
        match &self.nodes[id] {
            Node::Tuple(items) | Node::List(items) => items,
            _ => &[],
        }
    }

    /// An integer.
    #[must_use]
    pub fn int(&self, id: usize) -> Option<i64> {
        match self.nodes[id] {
            Node::Int(v) => Some(v),
            _ => None,
        }
    }

    /// A text.
    #[must_use]
    pub fn text(&self, id: usize) -> Option<&str> {
        match &self.nodes[id] {
            Node::Text(text) => Some(text),
            _ => None,
        }
    }

    /// The name of the function of a call, and its arguments.
    #[must_use]
    pub fn call(&self, id: usize) -> Option<(&str, &[usize])> {
        let Node::Call(function, arguments, _) = &self.nodes[id] else { return None };
        match &self.nodes[*function] {
            Node::Global(_, name) => Some((name, self.items(*arguments))),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `pickle.dumps({"a": [1, 2.5, None, True], "b": (300, "x")}, protocol=2)` of Python.
    #[test]
    fn plain_data_of_python_are_read() {
        let bytes = b"\x80\x02}q\x00(X\x01\x00\x00\x00aq\x01]q\x02(K\x01G@\x04\x00\x00\x00\x00\x00\x00N\x88\
                      eX\x01\x00\x00\x00bq\x03M,\x01X\x01\x00\x00\x00xq\x04\x86q\x05u.";
        let p = Pickle::read(bytes).unwrap();
        let a = p.get(p.root(), "a").unwrap();
        let items: Vec<&Node> = p.items(a).iter().map(|i| p.node(*i)).collect();
        let expected = [Node::Int(1), Node::Float(2.5), Node::None, Node::Bool(true)];
        assert_eq!(items, expected.iter().collect::<Vec<_>>());
        let b = p.get(p.root(), "b").unwrap();
        assert_eq!(p.int(p.items(b)[0]), Some(300));
        assert_eq!(p.text(p.items(b)[1]), Some("x"));
    }

    #[test]
    fn damage_is_told_and_never_panics() {
        let bytes = b"\x80\x02}q\x00(X\x01\x00\x00\x00aK\x01u.";
        assert!(Pickle::read(bytes).is_ok());
        for n in 0..bytes.len() {
            assert!(Pickle::read(&bytes[..n]).unwrap_err().contains("byte"), "{n}");
            let mut other = bytes.to_vec();
            for value in [0, b'u', b't', b'R', b'h', 0xff] {
                other[n] = value;
                let _ = Pickle::read(&other);
            }
        }
    }
}
