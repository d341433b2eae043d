//! Turns the code cells of every notebook into one function, so that they are compiled and run without the
//! notebook kernel, all cells of a notebook in one scope.

use std::fmt::Write;
use std::path::Path;

fn main() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
    println!("cargo:rerun-if-changed=build.rs");
    let mut paths: Vec<_> = std::fs::read_dir(folder)
        .expect("the folder of notebooks exists")
        .map(|entry| entry.expect("a readable folder").path())
        .filter(|path| path.extension().is_some_and(|e| e == "ipynb"))
        .collect();
    paths.sort();
    assert!(!paths.is_empty(), "there are notebooks");
    let (mut modules, mut list) = (String::new(), String::new());
    for path in paths {
        println!("cargo:rerun-if-changed={}", path.display());
        let name = path.file_stem().expect("a name").to_string_lossy().into_owned();
        let text = std::fs::read_to_string(&path).expect("a readable notebook");
        let notebook: serde_json::Value = serde_json::from_str(&text).expect("a notebook is JSON");
        let _ = writeln!(modules, "mod {name} {{\n    pub(super) fn run() -> super::Ran {{");
        let cells = notebook["cells"].as_array().expect("a notebook has cells");
        for (k, cell) in cells.iter().enumerate().filter(|(_, c)| c["cell_type"] == "code") {
            let _ = writeln!(modules, "        super::begin({k});");
            for line in source(&cell["source"]).lines().filter(|l| !l.starts_with(":dep")) {
                let _ = writeln!(modules, "{line}");
            }
        }
        let _ = writeln!(modules, "        Ok(())\n    }}\n}}\n");
        let _ = writeln!(list, "    (\"{name}\", {name}::run),");
    }
    let out = format!("{modules}const NOTEBOOKS: &[(&str, fn() -> Ran)] = &[\n{list}];\n");
    let target = std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR");
    std::fs::write(Path::new(&target).join("notebooks.rs"), out).expect("OUT_DIR is writable");
}

/// A cell's source: one text, or a list of lines.
fn source(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Array(lines) => lines.iter().filter_map(|l| l.as_str()).collect(),
        other => other.as_str().unwrap_or_default().to_owned(),
    }
}
