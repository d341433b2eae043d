//! A sweep at work.

use crate::error::AblateError;
use crate::experiment::{Experiment, Outcome, Problem, Workplace};
use crate::folder::{CellRecord, Claim, Claimed, Planned, Status, SweepFolder, claim};
use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

/// Which share of the cells a process works on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Which one, from one.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// All cells.
    pub const WHOLE: Self = Self { index: 1, count: 1 };

    /// A shard from text: `3/8`.
    ///
    /// # Errors
    /// The problem.
    pub fn parse(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(i, n)| {
            Some((i.trim().parse::<usize>().ok()?, n.trim().parse::<usize>().ok()?))
        });
        match numbers {
            Some((index, count)) if (1..=count).contains(&index) => Ok(Self { index, count }),
            _ => Err(format!("`{text}` is no shard; write i/n with 1 ≤ i ≤ n, as in 3/8")),
        }
    }

    /// True if a cell is its own.
    #[must_use]
    pub fn has(self, index: usize) -> bool {
        index % self.count == self.index - 1
    }
}

/// How a sweep is run.
#[derive(Debug, Clone, PartialEq)]
pub struct RunOptions {
    /// The share of the cells that is run.
    pub shard: Shard,
    /// True if cells of other shards that nobody works on are run after the own ones.
    pub steal: bool,
    /// Cells at a time.
    pub jobs: usize,
    /// Threads of all cells together.
    pub threads: usize,
    /// Program, version and commit.
    pub made_by: String,
}

impl Default for RunOptions {
    /// All cells, as many at a time as there are threads, each with one.
    fn default() -> Self {
        let threads = rayon::current_num_threads();
        Self {
            shard: Shard::WHOLE,
            steal: false,
            jobs: threads,
            threads,
            made_by: concat!("pam-ablate ", env!("CARGO_PKG_VERSION")).to_owned(),
        }
    }
}

/// Progress events.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// This many cells are to be done by this process, and this many of its share are over already.
    Planned(usize, usize),
    /// Work on a cell begins; how often it was begun before.
    Began(&'a Planned, usize),
    /// The share of a cell that is done, 0 to 1.
    Progress(&'a Planned, f64),
    /// A cell is over.
    Over(&'a Planned, &'a CellRecord),
    /// A cell was asked to stop and has saved its state.
    Stopped(&'a Planned),
    /// Another process works on a cell, or has ended it meanwhile.
    Elsewhere(&'a Planned),
}

/// Counts of the cells of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct RunCounts {
    /// Cells that ended with numbers.
    pub done: usize,
    /// Cells that failed.
    pub failed: usize,
    /// Cells that were stopped, or not begun because the sweep was.
    pub stopped: usize,
    /// Cells that another process works on or has ended meanwhile.
    pub elsewhere: usize,
}

/// Runs the cells of a sweep that nobody has run. `stop` makes running cells save their state and return;
/// whatever ends the process, those cells go on from there next time.
///
/// # Errors
/// [`AblateError`] if the folder cannot be written to. A cell that fails is no error.
pub fn run_cells(
    planned: &[Planned],
    experiment: &dyn Experiment,
    folder: &SweepFolder,
    options: &RunOptions,
    stop: &AtomicBool,
    observe: &(dyn Fn(Event<'_>) + Sync),
) -> Result<RunCounts, AblateError> {
    claim::check_locks(folder.path())?;
    let own = |p: &&Planned| options.shard.has(p.cell.index);
    let mut queue = Vec::new();
    let mut over = 0;
    for (mine, list) in [
        (true, planned.iter().filter(own).collect::<Vec<_>>()),
        (false, planned.iter().filter(|p| options.steal && !own(p)).collect()),
    ] {
        let mut open: Vec<(usize, &Planned)> = Vec::new();
        for p in list {
            // A process that was killed between the two leaves a cell that ends at once.
            if folder.read_record(&p.id)?.is_some() && claim::is_over(folder.cell(&p.id)) {
                over += usize::from(mine);
            } else {
                open.push((claim::attempts(folder.cell(&p.id)), p));
            }
        }
        // A cell that brings the process down comes after all that do not.
        open.sort_by_key(|(attempts, p)| (*attempts, p.cell.index));
        queue.extend(open.into_iter().map(|(_, p)| p));
    }
    observe(Event::Planned(queue.len(), over));
    let jobs = options.jobs.clamp(1, queue.len().max(1));
    let threads = (options.threads / jobs).max(1);
    let queue = Mutex::new(VecDeque::from(queue));
    let counts = Mutex::new(RunCounts::default());
    let error = Mutex::new(None);
    let worker = || {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        loop {
            let Some(p) = queue.lock().ok().and_then(|mut q| q.pop_front()) else { return };
            let ended = if stop.load(Ordering::Relaxed) {
                Ok(Ended::Stopped)
            } else {
                match &pool {
                    Ok(pool) => one(p, experiment, folder, options, (stop, observe, pool)),
                    Err(e) => Err(AblateError::setting("threads", e.to_string())),
                }
            };
            let Ok(mut counts) = counts.lock() else { return };
            match ended {
                Ok(Ended::Over(Status::Done)) => counts.done += 1,
                Ok(Ended::Over(Status::Failed)) => counts.failed += 1,
                Ok(Ended::Stopped) => counts.stopped += 1,
                Ok(Ended::Elsewhere) => counts.elsewhere += 1,
                Err(e) => {
                    // Where one cell cannot write, none can.
                    stop.store(true, Ordering::Relaxed);
                    if let Ok(mut first) = error.lock() {
                        first.get_or_insert(e);
                    }
                    return;
                }
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs {
            scope.spawn(worker);
        }
    });
    match error.into_inner() {
        Ok(Some(e)) => Err(e),
        _ => Ok(counts.into_inner().unwrap_or_default()),
    }
}

enum Ended {
    Over(Status),
    Stopped,
    Elsewhere,
}

type Surroundings<'a> = (&'a AtomicBool, &'a (dyn Fn(Event<'_>) + Sync), &'a rayon::ThreadPool);

fn one(
    p: &Planned,
    experiment: &dyn Experiment,
    folder: &SweepFolder,
    options: &RunOptions,
    (stop, observe, pool): Surroundings<'_>,
) -> Result<Ended, AblateError> {
    let at = folder.cell(&p.id);
    let mut claim = match Claim::take(&at)? {
        Claimed::Mine(claim) => claim,
        Claimed::Elsewhere | Claimed::Over => {
            observe(Event::Elsewhere(p));
            return Ok(Ended::Elsewhere);
        }
    };
    if let Some(record) = folder.read_record(&p.id)? {
        // Killed between the result and the note of it.
        claim.over()?;
        observe(Event::Over(p, &record));
        return Ok(Ended::Over(record.status));
    }
    observe(Event::Began(p, claim.attempts()));
    claim.begin()?;
    let work = at.join("work");
    std::fs::create_dir_all(&work).map_err(|e| AblateError::io(&work, e))?;
    let progress = |share: f64| observe(Event::Progress(p, share));
    let place = Workplace { folder: &work, stop, progress: &progress };
    let result =
        catch_unwind(AssertUnwindSafe(|| pool.install(|| experiment.run(&p.cell, &place))))
            .unwrap_or_else(|panic| Err(Problem::new(format!("panic: {}", message_of(&*panic)))));
    let result = match result {
        Ok(Outcome::Stopped) => {
            claim.stopped()?;
            observe(Event::Stopped(p));
            return Ok(Ended::Stopped);
        }
        Ok(Outcome::Finished(found)) => Ok(found),
        Err(problem) => Err(problem),
    };
    let record = CellRecord::of(p, result, &options.made_by);
    folder.write_record(&record)?;
    claim.over()?;
    observe(Event::Over(p, &record));
    Ok(Ended::Over(record.status))
}

fn message_of(panic: &(dyn Any + Send)) -> String {
    panic
        .downcast_ref::<&str>()
        .map(|s| (*s).to_owned())
        .or_else(|| panic.downcast_ref::<String>().cloned())
        .unwrap_or_else(|| "without a message".to_owned())
}

/// Makes cells that failed free again. Returns how many.
///
/// # Errors
/// [`AblateError`] if a file cannot be read or written.
pub fn free_failed(planned: &[Planned], folder: &SweepFolder) -> Result<usize, AblateError> {
    let mut freed = 0;
    for p in planned {
        let record = folder.read_record(&p.id)?;
        if record.is_some_and(|r| r.status == Status::Failed) && Claim::free(folder.cell(&p.id))? {
            freed += 1;
        }
    }
    Ok(freed)
}
