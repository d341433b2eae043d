//! The `pam-bench` command writes the files that it promises and refuses unknown names.

use serde_json::Value;
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
