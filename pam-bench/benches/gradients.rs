//! The comparison of gradient methods; the same as `pam bench gradients`.
//!
//! `cargo bench -p pam-bench --bench gradients -- [--quick] [--out DIR]`

use pam_bench::gradients::{output, parts};
use pam_bench::memory::CountingAllocator;
use std::path::Path;

#[global_allocator]
static MEMORY: CountingAllocator = CountingAllocator;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let study =
        if arguments.iter().any(|a| a == "--quick") { parts::quick() } else { parts::full() };
    let result = study.run(|p| {
        if p.done % 50 == 0 || p.done == p.total {
            eprintln!("{}/{}, about {:.0} s left", p.done, p.total, p.left.as_secs_f64());
        }
    });
    println!("{}", output::to_markdown(&result));
    if let Some(at) = arguments.iter().position(|a| a == "--out") {
        let folder = arguments.get(at + 1).ok_or("--out needs a folder")?;
        output::write(Path::new(folder), &result, "pam-bench")?;
    }
    Ok(())
}
