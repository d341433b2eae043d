//! The complete `pam` with a custom effect, activation and loss: `cargo run --release -- --help`.

mod detent;
mod log_cosh;
mod snake;

pub fn main() -> std::process::ExitCode {
    let parts = pam_cli::Registry::default();
    pam_cli::run(parts.effect(&detent::Detent).activation(&snake::SNAKE).loss(&log_cosh::LOG_COSH))
}
