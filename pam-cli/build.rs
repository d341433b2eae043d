//! Puts the git commit into the program, so that run folders can name it.

use std::path::Path;
use std::process::Command;

fn main() {
    let describe = Command::new("git")
        .args(["describe", "--always", "--dirty", "--abbrev=12"])
        // Else git may write its index, which is watched below: every build would be followed by another.
        .env("GIT_OPTIONAL_LOCKS", "0")
        .output()
        .ok()
        .filter(|o| o.status.success())
        .and_then(|o| String::from_utf8(o.stdout).ok())
        .map_or_else(|| "unknown".to_owned(), |s| s.trim().to_owned());
    println!("cargo:rustc-env=PAM_GIT_HASH={describe}");
    // Whether the tree is dirty changes with every crate's sources, not only with commits.
    let root = Path::new("..");
    let crates =
        std::fs::read_dir(root).into_iter().flatten().flatten().map(|e| e.path().join("src"));
    let watched = [root.join(".git/HEAD"), root.join(".git/index")].into_iter().chain(crates);
    for path in watched.filter(|p| p.exists()) {
        println!("cargo:rerun-if-changed={}", path.display());
    }
}
