//! Puts the git commit into the program, so that run folders can name it.

use std::path::Path;
use std::process::Command;

fn main() {
    let commit = git(&["describe", "--always", "--abbrev=12"]).map_or_else(
        || "unknown".to_owned(),
        |commit| {
            // Not `describe --dirty`, which writes the index that is watched below: every build would be followed by another.
            let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
            let dirty = changed.is_some_and(|files| !files.is_empty());
            if dirty { format!("{commit}-dirty") } else { commit }
        },
    );
    println!("cargo:rustc-env=PAM_GIT_HASH={commit}");
    // Whether the tree is dirty changes with every crate's sources, not only with commits.
    let root = Path::new("..");
    let crates =
        std::fs::read_dir(root).into_iter().flatten().flatten().map(|e| e.path().join("src"));
    let watched = [root.join(".git/HEAD"), root.join(".git/index")].into_iter().chain(crates);
    for path in watched.filter(|p| p.exists()) {
        println!("cargo:rerun-if-changed={}", path.display());
    }
}

/// The output of a git command that leaves the repository as it is; `None` if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).env("GIT_OPTIONAL_LOCKS", "0").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
