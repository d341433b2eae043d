//! Mutated inputs for every reader and every settings file.
//!
//! [`Case`] number `n` is always the same input: a seed of the corpus in `tests/fixtures/fuzz`, mutated by what its format
//! is ([`mutate`]), at a path that may be no plain file ([`place`]), for one of the [`targets`]. A case is sound if the reader neither panics nor takes longer than
//! [`LONGEST`], and if every refusal names the file. Accepted inputs are then used: a model predicts, a recording is
//! checked.

pub mod mutate;
pub mod place;
pub mod targets;
mod text;

use place::Place;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::time::{Duration, Instant};
use targets::{TARGETS, Target};

/// Longest time of a case: CPU time of the process, or a tenth of the wall-clock time, which waiting and a busy machine
/// lengthen.
pub const LONGEST: Duration = Duration::from_secs(10);

/// Measures the time of a case.
#[derive(Debug, Clone, Copy)]
pub struct Stopwatch {
    wall: Instant,
    processor: Option<Duration>,
}

impl Stopwatch {
    /// Begins now.
    #[must_use]
    pub fn start() -> Self {
        Self { wall: Instant::now(), processor: processor_time() }
    }

    /// Time since the start, see [`LONGEST`].
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        let wall = self.wall.elapsed();
        match (processor_time(), self.processor) {
            (Some(now), Some(then)) => now.saturating_sub(then).max(wall / 10),
            _ => wall,
        }
    }
}

/// CPU time of this process so far, as Linux counts it in hundredths of a second.
fn processor_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name in parentheses may hold anything; user and system time are the 12th and 13th field behind it.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}

/// How a case ended.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// The input was read.
    Read,
    /// It was refused with a message that names the file.
    Refused,
    /// It was refused with a message that does not name the file.
    Nameless(String),
    /// It took longer than [`LONGEST`].
    Slow,
    /// It panicked.
    Panicked(String),
}

/// One mutated input.
#[derive(Debug)]
pub struct Case {
    /// What reads it.
    pub target: &'static Target,
    /// Its bytes.
    pub bytes: Vec<u8>,
    /// Where they are.
    pub place: Place,
}

impl Case {
    /// The case of a number.
    ///
    /// # Panics
    /// If the corpus cannot be read.
    #[must_use]
    pub fn of(number: u64) -> Self {
        let target = &TARGETS[(number % TARGETS.len() as u64) as usize];
        let seed = std::fs::read(target.seed()).expect("the corpus is there");
        let mut random = ChaCha8Rng::seed_from_u64(number);
        let bytes = mutate::mutated(target.kind, &seed, &mut random);
        Self { target, bytes, place: Place::random(&mut random) }
    }

    /// Writes the case into a folder and reads it.
    ///
    /// # Panics
    /// If it cannot be written.
    #[must_use]
    pub fn run(&self, folder: &Path) -> Ending {
        let path = folder.join(self.target.file);
        self.place.put(&path, &self.bytes).expect("the case can be written");
        let begun = Stopwatch::start();
        let outcome = catch_unwind(AssertUnwindSafe(|| (self.target.read)(&path)));
        if begun.elapsed() > LONGEST {
            return Ending::Slow;
        }
        match outcome {
            Ok(Ok(())) => Ending::Read,
            Ok(Err(message)) if message.contains(self.target.file) => Ending::Refused,
            Ok(Err(message)) => Ending::Nameless(message),
            Err(panic) => {
                let text = panic.downcast_ref::<String>().cloned();
                let text = text.or_else(|| panic.downcast_ref::<&str>().map(|s| (*s).to_owned()));
                Ending::Panicked(text.unwrap_or_default())
            }
        }
    }
}

/// Counts of some cases.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Counts {
    /// Cases by target: read, refused.
    pub by_target: BTreeMap<&'static str, [u64; 2]>,
    /// Cases that are not sound, with their numbers.
    pub unsound: Vec<(u64, &'static str, Ending)>,
    /// Longest time of a case.
    pub longest: Duration,
}

impl Counts {
    /// Adds a case.
    pub fn add(&mut self, number: u64, target: &'static Target, ending: Ending) {
        let [read, refused] = self.by_target.entry(target.name).or_default();
        match ending {
            Ending::Read => *read += 1,
            Ending::Refused => *refused += 1,
            _ => self.unsound.push((number, target.name, ending)),
        }
    }

    /// Number of cases.
    #[must_use]
    pub fn cases(&self) -> u64 {
        self.by_target.values().flatten().sum::<u64>() + self.unsound.len() as u64
    }
}

/// Runs the cases of these numbers in a folder; `begun` is told each number before it runs, and ends the run if it
/// returns false.
pub fn run(
    numbers: impl IntoIterator<Item = u64>,
    folder: &Path,
    mut begun: impl FnMut(u64) -> bool,
) -> Counts {
    let mut counts = Counts::default();
    for number in numbers {
        if !begun(number) {
            break;
        }
        let case = Case::of(number);
        let begun = Stopwatch::start();
        let ending = case.run(folder);
        counts.longest = counts.longest.max(begun.elapsed());
        counts.add(number, case.target, ending);
    }
    counts
}
