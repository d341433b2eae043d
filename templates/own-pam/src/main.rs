//! The whole of `pam` with an effect, an activation and a loss of one's own: `cargo run --release -- --help`.

mod detent;
mod log_cosh;
mod snake;

pub fn main() -> std::process::ExitCode {
    let parts = pam_cli::Registry::default();
    pam_cli::run(parts.effect(&detent::Detent).activation(&snake::SNAKE).loss(&log_cosh::LOG_COSH))
}
