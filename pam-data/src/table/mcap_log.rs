//! Messages of MCAP logs as a table (feature `mcap`): JSON, and ROS 2 messages in CDR.
//!
//! A column is named `/topic.field.sub`; arrays have indices, `/joint_states.position[0]`. Rows are the messages of one
//! topic, the clock; the other topics hold their last value between messages. `log_time` is the time at which the rows
//! were logged, s from the first message of the file; `/topic.header.stamp` is the sender's own, s since 1970.

use super::arrays::ArrayTable;
use super::ros_message::MessageSchema;
use crate::error::DataError;
use crate::rig_file::FileLayout;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The messages of one topic.
#[derive(Default)]
struct Topic {
    /// ns since the epoch of the logger.
    times: Vec<u64>,
    columns: BTreeMap<String, Vec<f64>>,
}

impl Topic {
    /// Adds a message; fields that it lacks are NaN.
    fn push(&mut self, time: u64, numbers: Vec<(String, f64)>) {
        let before = self.times.len();
        self.times.push(time);
        for (name, value) in numbers {
            let column = self.columns.entry(name).or_default();
            column.resize(before, f64::NAN);
            column.push(value);
        }
        let rows = self.times.len();
        self.columns.values_mut().for_each(|c| c.resize(rows, f64::NAN));
    }
}

pub(super) fn read(
    path: &Path,
    bytes: Vec<u8>,
    layout: &FileLayout,
) -> Result<ArrayTable, DataError> {
    let fail = |e: String| DataError::file(path, e);
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut schemas: BTreeMap<u16, MessageSchema> = BTreeMap::new();
    let mut passed_over: BTreeMap<String, String> = BTreeMap::new();
    let messages =
        mcap::MessageStream::new(&bytes).map_err(|e| fail(format!("not a sound MCAP log: {e}")))?;
    for message in messages {
        let message = message.map_err(|e| fail(format!("a damaged MCAP log: {e}")))?;
        let channel = &message.channel;
        let numbers = match (channel.message_encoding.as_str(), &channel.schema) {
            ("json", _) => serde_json::from_slice::<Value>(&message.data)
                .map(|value| {
                    let mut out = Vec::new();
                    flatten("", &value, &mut out);
                    out
                })
                .map_err(|e| e.to_string()),
            ("cdr", Some(schema)) if schema.encoding == "ros2msg" => schemas
                .entry(channel.id)
                .or_insert_with(|| {
                    MessageSchema::parse(&schema.name, &String::from_utf8_lossy(&schema.data))
                })
                .numbers(&message.data),
            (encoding, schema) => {
                let schema = schema.as_ref().map_or("none", |s| s.encoding.as_str());
                passed_over
                    .insert(channel.topic.clone(), format!("encoding {encoding}, schema {schema}"));
                continue;
            }
        };
        let numbers = numbers.map_err(|e| fail(format!("topic {}: {e}", channel.topic)))?;
        topics.entry(channel.topic.clone()).or_default().push(message.log_time, numbers);
    }
    topics.values_mut().for_each(in_order);
    topics.retain(|_, topic| !topic.columns.is_empty());
    let names = || topics.keys().cloned().collect::<Vec<_>>().join(", ");
    let clock = match &layout.clock {
        Some(name) if topics.contains_key(name) => name.clone(),
        Some(name) => {
            return Err(fail(format!(
                "file.clock is `{name}`; the topics with numbers are [{}]",
                names()
            )));
        }
        // The fastest topic loses no sample.
        None => match topics.iter().max_by_key(|(_, t)| t.times.len()) {
            Some((name, _)) => name.clone(),
            None => {
                return Err(fail(format!(
                    "no topic with JSON or ROS 2 messages that hold numbers; passed over: {passed_over:?}"
                )));
            }
        },
    };
    let times = topics[&clock].times.clone();
    let start = topics.values().map(|t| t.times[0]).min().unwrap_or(0);
    let mut arrays =
        vec![("log_time".to_owned(), times.iter().map(|t| (t - start) as f64 * 1e-9).collect())];
    let mut held = Vec::new();
    for (name, topic) in &topics {
        if *name != clock {
            held.push(name.clone());
        }
        for (field, values) in &topic.columns {
            let column = if field.is_empty() { name.clone() } else { format!("{name}.{field}") };
            arrays.push((column, hold(&times, &topic.times, values)));
        }
    }
    let mut table = ArrayTable::new(path, arrays).starting_at_the_first_complete_row();
    if !held.is_empty() {
        table.note(format!(
            "rows are the messages of {clock}; {} held at their last value between messages (set file.clock for another \
             topic)",
            held.join(", ")
        ));
    }
    Ok(table)
}

/// Messages by their time: writers may log out of order.
fn in_order(topic: &mut Topic) {
    let mut order: Vec<usize> = (0..topic.times.len()).collect();
    order.sort_by_key(|&i| topic.times[i]);
    topic.times = order.iter().map(|&i| topic.times[i]).collect();
    for column in topic.columns.values_mut() {
        *column = order.iter().map(|&i| column[i]).collect();
    }
}

/// The last value at or before each time; NaN before the first.
fn hold(times: &[u64], of: &[u64], values: &[f64]) -> Vec<f64> {
    let mut next = 0;
    times
        .iter()
        .map(|t| {
            while next < of.len() && of[next] <= *t {
                next += 1;
            }
            if next == 0 { f64::NAN } else { values[next - 1] }
        })
        .collect()
}

fn flatten(path: &str, value: &Value, out: &mut Vec<(String, f64)>) {
    let join =
        |name: &str| if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") };
    match value {
        Value::Number(n) => out.extend(n.as_f64().map(|n| (path.to_owned(), n))),
        Value::Bool(b) => out.push((path.to_owned(), f64::from(u8::from(*b)))),
        Value::Array(values) => {
            values.iter().enumerate().for_each(|(k, v)| flatten(&format!("{path}[{k}]"), v, out));
        }
        Value::Object(fields) => fields.iter().for_each(|(name, v)| flatten(&join(name), v, out)),
        Value::Null | Value::String(_) => {}
    }
}
