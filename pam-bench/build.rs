//! Puts the git commit into the program, so that results can name it.

use std::process::Command;

fn main() {
    let commit = Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12"])
        .env("GIT_OPTIONAL_LOCKS", "0")
        .output();
    let commit = commit.ok().filter(|o| o.status.success()).map(|o| o.stdout).unwrap_or_default();
    let commit = String::from_utf8_lossy(&commit);
    let commit = if commit.is_empty() { "unknown" } else { commit.trim() };
    println!("cargo:rustc-env=PAM_GIT_HASH={commit}");
    println!("cargo:rerun-if-changed=../.git/HEAD");
    println!("cargo:rerun-if-changed=../.git/index");
    println!("cargo:rerun-if-changed=src");
}
