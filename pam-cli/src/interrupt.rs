//! Signals and the wall-clock limit.

use crate::error::CliError;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// True once a signal or the time limit asked to stop.
static STOP: AtomicBool = AtomicBool::new(false);
/// True while a command finishes what it does when it is asked to stop.
static LISTENING: AtomicBool = AtomicBool::new(false);
/// When the program stops at the latest.
static DEADLINE: OnceLock<Deadline> = OnceLock::new();

/// Signals within this time count as one: a scheduler sends the same signal by several ways at once.
const REPEATED: Duration = Duration::from_secs(1);
/// Time that a command has to save what it reached after the limit.
const GRACE: Duration = Duration::from_secs(10);
/// Longest limit, s: a thousand years.
const LONGEST_S: f64 = 3e10;

#[derive(Debug)]
struct Deadline {
    limit: Duration,
}

/// The flag that SIGINT, SIGTERM and the time limit set. Another signal later ends the program at once; checkpoints
/// stay. A command that calls this must look at the flag.
pub fn stop_flag() -> &'static AtomicBool {
    LISTENING.store(true, Ordering::Relaxed);
    let mut first: Option<Instant> = None;
    // Fails only where there is a handler already: the same one.
    let _ = ctrlc::set_handler(move || {
        STOP.store(true, Ordering::Relaxed);
        if first.get_or_insert_with(Instant::now).elapsed() > REPEATED {
            std::process::exit(i32::from(crate::INTERRUPTED));
        }
    });
    &STOP
}

/// A number of seconds as a duration.
///
/// # Errors
/// The condition on it: positive, or not negative if `zero` is allowed, and below a thousand years.
pub fn seconds(option: &str, value: f64, zero: bool) -> Result<Duration, CliError> {
    let low = if zero { value >= 0.0 } else { value > 0.0 };
    if low && value <= LONGEST_S {
        return Ok(Duration::from_secs_f64(value));
    }
    let sign = if zero { "must not be negative" } else { "must be positive" };
    Err(CliError::Usage(format!("{option} {value}: it {sign} and at most {LONGEST_S:e} s")))
}

/// Ends the program after a wall-clock time with an error. A command that can stop and resume is asked to first.
///
/// Every output file is written as a whole and then renamed, so that whatever is being computed can be ended at any
/// time, in any library.
pub(crate) fn limit(limit: Duration) {
    if DEADLINE.set(Deadline { limit }).is_err() {
        return;
    }
    std::thread::spawn(move || {
        std::thread::sleep(limit);
        if LISTENING.load(Ordering::Relaxed) {
            STOP.store(true, Ordering::Relaxed);
            std::thread::sleep(GRACE);
        }
        eprintln!("error: {}", message());
        std::process::exit(i32::from(crate::FAILED));
    });
}

fn message() -> String {
    let s = DEADLINE.get().map_or(0.0, |d| d.limit.as_secs_f64());
    format!("--timeout {s}: the time is over, and nothing more is written")
}
