//! The stack machine that a pickle is a program for.

use super::Node;
use std::collections::HashMap;

/// Where the machine is.
struct Machine<'a> {
    bytes: &'a [u8],
    at: usize,
    nodes: Vec<Node>,
    stack: Vec<usize>,
    marks: Vec<usize>,
    memo: HashMap<u64, usize>,
}

/// Runs a pickle: all nodes, and which one is the object itself.
///
/// # Errors
/// What is wrong, with the offset.
pub(super) fn run(bytes: &[u8]) -> Result<(Vec<Node>, usize), String> {
    let mut machine = Machine {
        bytes,
        at: 0,
        nodes: Vec::new(),
        stack: Vec::new(),
        marks: Vec::new(),
        memo: HashMap::new(),
    };
    loop {
        let at = machine.at;
        match machine.step() {
            Ok(None) => {}
            Ok(Some(root)) => return Ok((machine.nodes, root)),
            Err(why) => return Err(format!("byte {at} of the pickle: {why}")),
        }
    }
}

impl Machine<'_> {
    fn step(&mut self) -> Result<Option<usize>, String> {
        match self.byte()? {
            0x80 => {
                let protocol = self.byte()?;
                if protocol > 4 {
                    return Err(format!("protocol {protocol} is newer than those that are read"));
                }
            }
            0x95 => {
                self.take(8)?;
            }
            b'.' => return self.pop().map(Some),
            b'(' => self.marks.push(self.stack.len()),
            b'N' => self.push(Node::None),
            0x88 => self.push(Node::Bool(true)),
            0x89 => self.push(Node::Bool(false)),
            b'K' => {
                let v = self.byte()?;
                self.push(Node::Int(v.into()));
            }
            b'M' => {
                let v = self.number::<2>()?;
                self.push(Node::Int(v as i64));
            }
            b'J' => {
                let v = self.number::<4>()? as u32;
                self.push(Node::Int(i64::from(v as i32)));
            }
            0x8a => {
                let n = usize::from(self.byte()?);
                let bytes = self.take(n)?;
                if n > 8 {
                    return Err("an integer of more than 64 bits".into());
                }
                let negative = bytes.last().is_some_and(|b| b & 0x80 != 0);
                let mut all = [if negative { 0xff } else { 0 }; 8];
                all[..n].copy_from_slice(bytes);
                self.push(Node::Int(i64::from_le_bytes(all)));
            }
            b'G' => {
                let bytes = self.take(8)?.try_into().map_err(|_| "a float is cut short")?;
                self.push(Node::Float(f64::from_be_bytes(bytes)));
            }
            b'X' => {
                let n = self.number::<4>()?;
                self.text(n)?;
            }
            0x8c => {
                let n = self.number::<1>()?;
                self.text(n)?;
            }
            b'B' => {
                let n = self.number::<4>()?;
                self.raw(n)?;
            }
            b'C' => {
                let n = self.number::<1>()?;
                self.raw(n)?;
            }
            b'c' => {
                let module = self.line()?;
                let name = self.line()?;
                self.push(Node::Global(module, name));
            }
            0x93 => {
                let (name, module) = (self.pop()?, self.pop()?);
                let (Node::Text(module), Node::Text(name)) =
                    (&self.nodes[module], &self.nodes[name])
                else {
                    return Err("a global without a name".into());
                };
                let global = Node::Global(module.clone(), name.clone());
                self.push(global);
            }
            b')' => self.push(Node::Tuple(Vec::new())),
            b']' => self.push(Node::List(Vec::new())),
            b'}' => self.push(Node::Dict(Vec::new())),
            b't' => {
                let items = self.since_mark()?;
                self.push(Node::Tuple(items));
            }
            tuple @ 0x85..=0x87 => {
                let n = usize::from(tuple - 0x84);
                let from = self.stack.len().checked_sub(n).ok_or("the stack is empty")?;
                let items = self.stack.split_off(from);
                self.push(Node::Tuple(items));
            }
            b'a' => {
                let item = self.pop()?;
                self.extend(vec![item])?;
            }
            b'e' => {
                let items = self.since_mark()?;
                self.extend(items)?;
            }
            b's' => {
                let (value, key) = (self.pop()?, self.pop()?);
                self.insert(&[key, value])?;
            }
            b'u' => {
                let items = self.since_mark()?;
                self.insert(&items)?;
            }
            b'R' | 0x81 => {
                let (arguments, function) = (self.pop()?, self.pop()?);
                // A dictionary is the one call that has contents later on.
                let dict =
                    matches!(&self.nodes[function], Node::Global(_, name) if name == "OrderedDict");
                self.push(if dict {
                    Node::Dict(Vec::new())
                } else {
                    Node::Call(function, arguments, None)
                });
            }
            b'b' => {
                let state = self.pop()?;
                let object = *self.stack.last().ok_or("the stack is empty")?;
                if let Node::Call(_, _, own) = &mut self.nodes[object] {
                    *own = Some(state);
                }
            }
            b'Q' => {
                let id = self.pop()?;
                self.push(Node::Persistent(id));
            }
            b'q' => {
                let key = self.number::<1>()?;
                self.remember(key)?;
            }
            b'r' => {
                let key = self.number::<4>()?;
                self.remember(key)?;
            }
            0x94 => {
                let key = self.memo.len() as u64;
                self.remember(key)?;
            }
            b'h' => {
                let key = self.number::<1>()?;
                self.recall(key)?;
            }
            b'j' => {
                let key = self.number::<4>()?;
                self.recall(key)?;
            }
            other => return Err(format!("instruction 0x{other:02x} is not read")),
        }
        Ok(None)
    }

    fn byte(&mut self) -> Result<u8, String> {
        let byte = *self.bytes.get(self.at).ok_or("it ends early")?;
        self.at += 1;
        Ok(byte)
    }

    fn take(&mut self, n: usize) -> Result<&[u8], String> {
        let end = self.at.checked_add(n).ok_or("it ends early")?;
        let part = self.bytes.get(self.at..end).ok_or("it ends early")?;
        self.at = end;
        Ok(part)
    }

    fn number<const N: usize>(&mut self) -> Result<u64, String> {
        let mut all = [0; 8];
        all[..N].copy_from_slice(self.take(N)?);
        Ok(u64::from_le_bytes(all))
    }

    fn text(&mut self, n: u64) -> Result<(), String> {
        let n = usize::try_from(n).map_err(|e| e.to_string())?;
        let text = std::str::from_utf8(self.take(n)?).map_err(|e| e.to_string())?.to_owned();
        self.push(Node::Text(text));
        Ok(())
    }

    fn raw(&mut self, n: u64) -> Result<(), String> {
        let n = usize::try_from(n).map_err(|e| e.to_string())?;
        let bytes = self.take(n)?.to_vec();
        self.push(Node::Bytes(bytes));
        Ok(())
    }

    fn line(&mut self) -> Result<String, String> {
        let rest = &self.bytes[self.at.min(self.bytes.len())..];
        let n = rest.iter().position(|b| *b == b'\n').ok_or("a name does not end")?;
        let line = String::from_utf8_lossy(&rest[..n]).into_owned();
        self.at += n + 1;
        Ok(line)
    }

    fn push(&mut self, node: Node) {
        self.stack.push(self.nodes.len());
        self.nodes.push(node);
    }

    fn pop(&mut self) -> Result<usize, String> {
        self.stack.pop().ok_or_else(|| "the stack is empty".into())
    }

    fn since_mark(&mut self) -> Result<Vec<usize>, String> {
        let mark = self.marks.pop().filter(|m| *m <= self.stack.len());
        Ok(self.stack.split_off(mark.ok_or("there is no mark")?))
    }

    fn extend(&mut self, items: Vec<usize>) -> Result<(), String> {
        let list = *self.stack.last().ok_or("the stack is empty")?;
        match &mut self.nodes[list] {
            Node::List(own) => own.extend(items),
            _ => return Err("items for something that is no list".into()),
        }
        Ok(())
    }

    fn insert(&mut self, items: &[usize]) -> Result<(), String> {
        let dict = *self.stack.last().ok_or("the stack is empty")?;
        match &mut self.nodes[dict] {
            Node::Dict(own) => own.extend(items.chunks_exact(2).map(|p| (p[0], p[1]))),
            _ => return Err("entries for something that is no dictionary".into()),
        }
        Ok(())
    }

    fn remember(&mut self, key: u64) -> Result<(), String> {
        let top = *self.stack.last().ok_or("the stack is empty")?;
        self.memo.insert(key, top);
        Ok(())
    }

    fn recall(&mut self, key: u64) -> Result<(), String> {
        let id = *self.memo.get(&key).ok_or("something is recalled that was not kept")?;
        self.stack.push(id);
        Ok(())
    }
}
