//! Values in both formats, against the crates `toml` and `serde_json`.

use pam_data::document::{from_json, from_toml, from_value, to_json, to_toml};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Shape {
    Flat,
    Tilted(f64),
    Bent { radius_mm: f64, sides: (u8, u8) },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
enum Step {
    Hold { time_s: f64 },
    Ramp { from: f64, to: f64 },
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct All {
    name: String,
    count: u64,
    large: u64,
    level: Option<f64>,
    absent: Option<f64>,
    flags: Vec<bool>,
    shapes: Vec<Shape>,
    step: Vec<Step>,
    by_name: BTreeMap<String, f64>,
    free: toml::Table,
}

fn all() -> All {
    All {
        name: "a \"quoted\" name\nwith two lines".into(),
        count: 3,
        large: i64::MAX as u64,
        level: Some(0.1 + 0.2),
        absent: None,
        flags: vec![true, false],
        shapes: vec![
            Shape::Flat,
            Shape::Tilted(-1e-300),
            Shape::Bent { radius_mm: 5.0, sides: (1, 2) },
        ],
        step: vec![Step::Hold { time_s: 2.0 }, Step::Ramp { from: -1.0, to: 1.5e17 }],
        by_name: BTreeMap::from([("b".into(), 1.0), ("a".into(), -0.0)]),
        free: "x = 1\ny = [1.5, 2]\n[z]\nw = 'text'".parse().unwrap(),
    }
}

/// The crates `toml` and `serde_json` are the reference.
#[test]
fn both_formats_agree_with_their_reference_libraries() {
    let value = all();
    let (toml_text, json_text) = (to_toml(&value).unwrap(), to_json(&value).unwrap());
    assert_eq!(toml::from_str::<All>(&toml_text).unwrap(), value);
    assert_eq!(serde_json::from_str::<All>(&json_text).unwrap(), value);
    assert_eq!(from_toml::<All>(&toml::to_string(&value).unwrap()).unwrap(), value);
    assert_eq!(from_json::<All>(&serde_json::to_string(&value).unwrap()).unwrap(), value);
    assert_eq!(from_value::<All>(serde_json::to_value(&value).unwrap()).unwrap(), value);
    assert_eq!(toml_text, toml::to_string(&value).unwrap());
    assert_eq!(json_text, serde_json::to_string(&value).unwrap());
}

#[test]
fn numbers_keep_every_bit() {
    let numbers: Vec<f64> = (0..2000)
        .map(|k| f64::from_bits(0x3ff0_0000_0000_0000_u64.wrapping_add(k * 0x0012_3456_789a_bcdf)))
        .filter(|v| v.is_finite())
        .collect();
    let back: Vec<f64> = from_json(&to_json(&numbers).unwrap()).unwrap();
    assert!(numbers.iter().zip(&back).all(|(a, b)| a.to_bits() == b.to_bits()));
    let table = BTreeMap::from([("v", numbers.clone())]);
    let back: BTreeMap<String, Vec<f64>> = from_toml(&to_toml(&table).unwrap()).unwrap();
    assert!(numbers.iter().zip(&back["v"]).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn toml_number_formats() {
    let read = |text: &str| from_toml::<BTreeMap<String, f64>>(text).map(|m| m["v"]);
    assert_eq!(read("v = 1_000").unwrap(), 1000.0);
    assert_eq!(read("v = 0x1F").unwrap(), 31.0);
    assert_eq!(read("v = -0b101").is_err(), "v = -0b101".parse::<toml::Table>().is_err());
    assert_eq!(read("v = +2.5e-3").unwrap(), 0.0025);
    assert_eq!(read("v = 1_0.2_5").unwrap(), 10.25);
    assert_eq!(read("v = -inf").unwrap(), f64::NEG_INFINITY);
    assert!(read("v = nan").unwrap().is_nan());
    assert!(read("v = 99999999999999999999").is_err());
    let whole: BTreeMap<String, i64> = from_toml("v = -9223372036854775808").unwrap();
    assert_eq!(whole["v"], i64::MIN);
}

#[test]
fn errors_have_line_and_field() {
    let place = |text: &str| {
        let error = from_toml::<All>(text).unwrap_err();
        let line = error.span().map(|_| error.line(text));
        (error.to_string(), line)
    };
    let text = to_toml(&all()).unwrap();
    let line_of = |part: &str| 1 + text[..text.find(part).unwrap()].matches('\n').count() as u64;

    let (message, _) = place(&text.replace("count = 3", "count = 'three'"));
    assert_eq!(message, "`count`: invalid type: string \"three\", expected u64");
    let wrong = text.replace("time_s = 2.0", "time_s = true");
    let error = from_toml::<All>(&wrong).unwrap_err();
    assert!(error.to_string().starts_with("`step.0"), "{error}");
    // serde buffers an internally tagged table, so the error points at the table and not at the field.
    assert!((line_of("[[step]]")..=line_of("time_s")).contains(&error.line(&wrong)), "{error:?}");
    let (message, line) = place(&text.replace("count = 3", "cuont = 3"));
    assert_eq!(line, Some(line_of("count = 3")));
    assert!(message.contains("unknown field `cuont`, expected one of `name`"), "{message}");
    let (message, line) = place(&text.replace("count = 3\n", ""));
    assert_eq!((message.as_str(), line), ("missing field `count`", None));
    let (message, line) = place("name = 'a'\nname = 'b'");
    assert!(message.contains("duplicate key"), "{message}");
    assert_eq!(line, Some(2));
    let error = from_json::<All>("{\"name\": 1}").unwrap_err();
    assert_eq!(error.to_string(), "`name`: invalid type: integer `1`, expected a string");
    assert!(from_json::<All>("{\"name\"").unwrap_err().to_string().contains("line 1"));
}

#[test]
fn spanned_values_match_the_toml_crate() {
    #[derive(Deserialize)]
    struct Placed {
        a: toml::Spanned<f64>,
        b: Vec<toml::Spanned<toml::Table>>,
        c: BTreeMap<toml::Spanned<String>, i32>,
    }
    let text = "a = 1.5\n[[b]]\nx = 1\n[[b]]\nx = 2\n[c]\nkey = 7\n";
    let placed: Placed = from_toml(text).unwrap();
    let same: Placed = toml::from_str(text).unwrap();
    assert_eq!(placed.a.span(), same.a.span());
    assert_eq!(*placed.a.get_ref(), 1.5);
    assert_eq!(placed.b[1].span(), same.b[1].span());
    assert_eq!(placed.b[1].get_ref(), same.b[1].get_ref());
    let of = |p: &Placed| p.c.iter().map(|(k, v)| (k.span(), k.get_ref().clone(), *v)).next();
    assert_eq!(of(&placed), of(&same));
}
