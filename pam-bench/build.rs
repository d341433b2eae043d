//! Puts the git commit into the program, so that results can name it.

use std::process::Command;

fn main() {
    let commit = git(&["describe", "--always", "--abbrev=12"]).map_or_else(
        || "unknown".to_owned(),
        |commit| {
            // Not `describe --dirty`, which writes the index that is watched below.
            let changed = git(&["status", "--porcelain", "--untracked-files=no"]);
            let dirty = changed.is_some_and(|files| !files.is_empty());
            if dirty { format!("{commit}-dirty") } else { commit }
        },
    );
    println!("cargo:rustc-env=PAM_GIT_HASH={commit}");
    println!("cargo:rerun-if-changed=../.git/HEAD");
    println!("cargo:rerun-if-changed=../.git/index");
    println!("cargo:rerun-if-changed=src");
}

/// The output of a git command that leaves the repository as it is; `None` if it fails.
fn git(arguments: &[&str]) -> Option<String> {
    let output =
        Command::new("git").args(arguments).env("GIT_OPTIONAL_LOCKS", "0").output().ok()?;
    output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
