//! The `pam-bench` command writes the files that it promises and refuses unknown names.

use pam_bench::results::{Results, page, unmarked};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output};

fn run(out: &Path, more: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_pam-bench"))
        .args(["gradients", "--quick", "--repeat", "1", "--out"])
        .arg(out)
        .args(more)
        .output()
        .expect("the program starts")
}

#[test]
fn gradient_methods_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("bench");
    let only = ["--problems", "van-der-pol", "--methods", "adjoint,backsolve", "--json"];
    let output = run(&out, &only);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let rows = json["rows"].as_array().unwrap();
    assert!(rows.iter().all(|row| row["problem"] == "van-der-pol"));
    assert!(rows.iter().any(|row| row["method"] == "backsolve"));
    let exact = rows.iter().filter(|row| row["method"] == "adjoint");
    assert!(exact.clone().all(|row| row["replay_error"].as_f64().unwrap() < 1e-10));
    assert!(exact.clone().all(|row| row["peak_bytes"].as_u64().unwrap() > 0));
    let mut names: Vec<String> = std::fs::read_dir(&out)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    assert_eq!(names, ["gradients.csv", "gradients.json", "report.html", "run.json", "table.md"]);
    let text = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    assert_eq!(serde_json::from_str::<Value>(&text("gradients.json")).unwrap(), json);
    assert!(text("report.html").contains("<svg"));

    for (option, known) in [("--problems", "van-der-pol"), ("--methods", "interpolating")] {
        let output = run(&out, &[option, "nonsense"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains("nonsense") && errors.contains(known), "{errors}");
    }
}

/// README, book and changelog show what `results/` holds.
#[test]
fn pages_show_the_measured_results() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let results = Results::read(root.join("results")).unwrap();
    let mut markers = 0;
    for path in page::pages(&root).unwrap() {
        let text = std::fs::read_to_string(&path).unwrap();
        let filled =
            page::fill(&text, &results).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        assert!(
            text == filled,
            "{} differs from results/: run `cargo run -p pam-bench --bin results -- --write`",
            path.display()
        );
        markers += text.matches("<!--/-->").count();
    }
    assert!(markers > 50, "{markers} numbers and tables come from results/");
}

/// Code, links, headings, markers and generated parts are no prose; words with digits are no numbers.
#[test]
fn numbers_in_prose_without_a_marker_are_found() {
    let page = "# 1.5 in a heading\nIt takes <!--= a.b .1 -->2.5<!--/--> s, or 3 s, 0.1 mm and `4.5 mm`\n\
        ([2.5](x-1.5.md)); 1e-6, −2.5 %, 29 recordings, v1.5, RK4, 10⁻⁴.\n```text\n7.5 ms\n```\n\
        <!-- settings -->\n| 1.5 |\n<!-- end of settings -->\nand 12 µs";
    let found = unmarked(page);
    let texts: Vec<&str> = found.iter().map(|(_, text)| text.as_str()).collect();
    assert_eq!(texts, ["3 s", "0.1 mm", "2.5", "1e-6", "−2.5 %", "12 µs"]);
    assert_eq!(found[5].0, 10);
}

/// A number in the prose of a page is a marker, so it comes from `results/`, or is listed in .ci/numbers.toml: settings,
/// definitions, published values and physical constants are not measured. `UPDATE_NUMBERS=1` writes the list again, for a
/// look at its difference.
#[test]
fn numbers_of_pages_come_from_results_or_are_listed_as_given() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let list = root.join(".ci/numbers.toml");
    let mut given: BTreeMap<String, Vec<String>> =
        toml::from_str(&std::fs::read_to_string(&list).unwrap()).unwrap();
    let mut all: BTreeMap<String, Vec<String>> = BTreeMap::new();
    let mut unknown = Vec::new();
    for path in page::pages(&root).unwrap() {
        let name = path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
        let listed = given.remove(&name).unwrap_or_default();
        for (line, number) in unmarked(&std::fs::read_to_string(&path).unwrap()) {
            if !listed.contains(&number) {
                unknown.push(format!("{name}:{line}: {number}"));
            }
            let numbers = all.entry(name.clone()).or_default();
            if !numbers.contains(&number) {
                numbers.push(number);
            }
        }
        for number in &listed {
            if !all.get(&name).is_some_and(|numbers| numbers.contains(number)) {
                unknown.push(format!("{name}: {number} is listed and no longer there"));
            }
        }
    }
    if std::env::var_os("UPDATE_NUMBERS").is_some() {
        let mut text = String::from(
            "# Numbers in the prose of pages that are given, not measured: settings, definitions, published values, constants.\n\
             # Measured ones come from results/ by markers. UPDATE_NUMBERS=1 cargo test -p pam-bench --test command writes this.\n",
        );
        for (page, numbers) in &all {
            let quoted: Vec<String> = numbers.iter().map(|n| format!("{n:?}")).collect();
            text += &format!("\"{page}\" = [\n    {},\n]\n", quoted.join(", "));
        }
        std::fs::write(&list, text).unwrap();
        return;
    }
    assert!(
        unknown.is_empty(),
        "give these a marker (results/README.md), or list them in .ci/numbers.toml if they are not measured:\n{}",
        unknown.join("\n")
    );
}

/// Numbers, formats, ratios and tables of a study; code stays as it is; what is unknown or not closed is an error.
#[test]
fn markers_of_pages_are_filled() {
    let folder = tempfile::tempdir().unwrap();
    let study = r#"{"title": "a", "commands": ["true"], "commit": "c", "date": "2026-01-01", "machine": "m", "cores": 1,
        "values": {"a": {"value": 0.0123, "low": -1.5, "unit": "s"},
                   "b": {"cell": {"table": "t", "row": ["x"], "column": "n"}}},
        "tables": {"t": {"columns": ["k", "n"], "decimals": [null, 2], "rows": [["x", 4], ["y", null]]}}}"#;
    std::fs::write(folder.path().join("s.json"), study).unwrap();
    let results = Results::read(folder.path()).unwrap();
    let filled = |text: &str| page::fill(text, &results);
    for (marker, shown) in [
        ("s.a", "0.0123"),
        ("s.a .3", "0.012"),
        ("s.a .1%", "1.2"),
        ("s.a .1e", "1.2e-2"),
        ("s.a .2g", "0.012"),
        ("s.a.low", "−1.5"),
        ("s.b", "4"),
        ("s.b / s.a .0", "325"),
        ("s.a / s.b .1%-", "99.7"),
    ] {
        let text = format!("It is <!--= {marker} -->old<!--/--> s.");
        assert_eq!(filled(&text).unwrap(), format!("It is <!--= {marker} -->{shown}<!--/--> s."));
    }
    let table = "<!--# s.t -->\n\n| k | n |\n|---|---|\n| x | 4.00 |\n| y | – |\n\n<!--/-->\n";
    assert_eq!(filled("<!--# s.t --><!--/-->\n").unwrap(), table);
    assert_eq!(filled(table).unwrap(), table, "filling twice changes nothing");
    let code = "```text\n<!--= s.none -->\n```\n";
    assert_eq!(filled(code).unwrap(), code);
    for wrong in [
        "<!--= s.none --><!--/-->",
        "<!--= t.a --><!--/-->",
        "<!--# s.u --><!--/-->",
        "<!--= s.a -->",
        "<!--= s.a .x --><!--/-->",
    ] {
        assert!(filled(wrong).is_err(), "{wrong}");
    }
    let broken = study.replace("\"row\": [\"x\"]", "\"row\": [\"z\"]");
    std::fs::write(folder.path().join("s.json"), broken).unwrap();
    assert!(Results::read(folder.path()).is_err(), "a value refers to a cell that exists");
}

/// `results NAME` runs the commands of a study and reads what they write.
#[test]
fn a_study_is_measured_again() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir_all(folder.path().join("docs")).unwrap();
    std::fs::create_dir_all(folder.path().join("results")).unwrap();
    let page = "<!--= s.time_ms --><!--/--> ms\n";
    for name in ["README.md", "CHANGELOG.md", "CONTRIBUTING.md"] {
        std::fs::write(folder.path().join(name), page).unwrap();
    }
    let study = r##"{"title": "a", "commands": ["echo '{\"times\": [0.5, 0.25]}' > out.json", "printf '# c\nk,n\nx,7\n' > out.csv"],
        "commit": "c", "date": "2026-01-01", "machine": "m", "cores": 1,
        "values": {"time_ms": {"value": 1, "unit": "ms", "from": {"file": "out.json", "pointer": "/times/1", "scale": 1000}},
                   "seven": {"value": 1, "from": {"file": "out.csv", "row": {"k": "x"}, "column": "n"}},
                   "text": {"value": 1, "from": {"file": "out.csv", "after": "x,"}}},
        "tables": {"t": {"columns": ["k", "n"], "rows": [["x", 4]], "from_csv": "out.csv"},
                   "u": {"columns": ["k", "n"], "rows": [["half", 4]], "from": [[null, {"file": "out.json", "pointer": "/times/0"}]]}}}"##;
    std::fs::write(folder.path().join("results/s.json"), study).unwrap();
    let status = Command::new(env!("CARGO_BIN_EXE_results"))
        .args(["s", "--write", "--root"])
        .arg(folder.path())
        .status()
        .unwrap();
    assert!(status.success());
    let results = Results::read(folder.path().join("results")).unwrap();
    assert_eq!(results.number("s.time_ms").unwrap(), 250.0);
    assert_eq!(results.number("s.seven").unwrap(), 7.0);
    assert_eq!(results.number("s.text").unwrap(), 7.0);
    assert_eq!(results.table("s.u").unwrap().rows, [[Value::from("half"), Value::from(0.5)]]);
    assert_eq!(results.table("s.t").unwrap().rows, [[Value::from("x"), Value::from(7)]]);
    assert_eq!(
        std::fs::read_to_string(folder.path().join("README.md")).unwrap(),
        "<!--= s.time_ms -->250<!--/--> ms\n"
    );
}
