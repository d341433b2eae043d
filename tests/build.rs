//! Turns the code cells of the notebooks into documentation tests, so that they are compiled and run
//! without the notebook kernel.

use std::fmt::Write;
use std::path::Path;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../notebooks");
    println!("cargo:rerun-if-changed={}", folder.display());
    let mut names: Vec<_> = std::fs::read_dir(&folder)
        .expect("the folder of notebooks exists")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|e| e == "ipynb"))
        .collect();
    names.sort();
    assert!(!names.is_empty(), "there are notebooks");
    let mut out = String::new();
    for path in names {
        println!("cargo:rerun-if-changed={}", path.display());
        let text = std::fs::read_to_string(&path).expect("a readable notebook");
        let notebook: serde_json::Value = serde_json::from_str(&text).expect("a notebook is JSON");
        let _ = writeln!(out, "\n# {}\n\n```rust", path.display());
        for cell in notebook["cells"].as_array().expect("a notebook has cells") {
            if cell["cell_type"] == "code" {
                for line in source(&cell["source"]).lines().filter(|l| !l.starts_with(":dep")) {
                    let _ = writeln!(out, "{line}");
                }
            }
        }
        // A cell may use `?`.
        out.push_str("# Ok::<(), Box<dyn std::error::Error>>(())\n```\n");
    }
    let target = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    std::fs::write(Path::new(&target).join("notebooks.md"), out).expect("OUT_DIR is writable");
}

/// A cell's source: one text, or a list of lines.
fn source(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Array(lines) => lines.iter().filter_map(|l| l.as_str()).collect(),
        other => other.as_str().unwrap_or_default().to_owned(),
    }
}
