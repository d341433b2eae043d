//! The project template `templates/own-pam`, as the tests run it: the same files, built with the tests.

// A program of its own, in which `pub` is what its author finds natural.
#[allow(unreachable_pub)]
#[path = "../templates/own-pam/src/main.rs"]
mod template;

fn main() -> std::process::ExitCode {
    template::main()
}
