//! The project template `templates/own-pam`, as the tests run it: the same files, built with the tests.

#[path = "../templates/own-pam/src/main.rs"]
mod template;

fn main() -> std::process::ExitCode {
    template::main()
}
