//! Long calls: the interpreter lock is released, signals are looked for, progress is shown.
//!
//! The work runs on the framework's threads. The calling thread waits for it and lets Python look for signals in between, so
//! that Ctrl-C raises `KeyboardInterrupt` soon. The work ends at the next point at which it looks at [`Stop`]: after a window,
//! an epoch, a candidate. Engines have no way out of the middle of a request; there the work unwinds without a message.

use pyo3::prelude::*;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, sync_channel};
use std::time::Duration;

/// Time between two looks for signals.
const POLL: Duration = Duration::from_millis(50);

/// The payload with which stopped work unwinds.
struct Stopped;

/// Why work is to stop, if it is.
#[derive(Default)]
pub(crate) struct Stop {
    asked: AtomicBool,
    error: Mutex<Option<PyErr>>,
}

impl Stop {
    /// Asks the work to stop and to raise this. The first reason counts.
    pub(crate) fn ask(&self, error: PyErr) {
        let mut first = self.error.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        first.get_or_insert(error);
        self.asked.store(true, Ordering::Relaxed);
    }

    /// The flag, for work that looks at it by itself.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.asked
    }

    /// Unwinds if the work is to stop.
    pub(crate) fn check(&self) {
        if self.asked.load(Ordering::Relaxed) {
            resume_unwind(Box::new(Stopped));
        }
    }

    /// Calls a Python function with arguments; an exception stops the work.
    pub(crate) fn call<A>(&self, function: Option<&Py<PyAny>>, arguments: A)
    where
        A: for<'py> pyo3::call::PyCallArgs<'py>,
    {
        if let Some(function) = function
            && let Err(error) = Python::attach(|py| function.call1(py, arguments).map(drop))
        {
            self.ask(error);
        }
    }

    /// Ends the work without an exception, where it looks at the [`flag`](Self::flag).
    pub(crate) fn end(&self) {
        self.asked.store(true, Ordering::Relaxed);
    }

    /// Takes the exception for which the work is to stop.
    pub(crate) fn reason(&self) -> Option<PyErr> {
        self.error.lock().unwrap_or_else(std::sync::PoisonError::into_inner).take()
    }

    /// The result of the work, or the reason for which it stopped.
    fn outcome<T>(&self, result: std::thread::Result<T>) -> PyResult<T> {
        match (self.reason(), result) {
            (Some(error), _) => Err(error),
            (None, Ok(value)) => Ok(value),
            (None, Err(panic)) => resume_unwind(panic),
        }
    }
}

/// Does work on the framework's threads without the interpreter lock. Ctrl-C stops it.
pub(crate) fn watched<T: Send>(
    py: Python<'_>,
    work: impl FnOnce(&Stop) -> T + Send,
) -> PyResult<T> {
    // A call from a callback on one of these threads must not wait for them.
    if rayon::current_thread_index().is_some() {
        return brief(py, work);
    }
    let stop = Stop::default();
    py.detach(|| {
        let (sender, receiver) = sync_channel(1);
        let result = rayon::in_place_scope(|scope| {
            scope.spawn(|_| {
                // The receiver waits for it.
                let _ = sender.send(catch_unwind(AssertUnwindSafe(|| work(&stop))));
            });
            loop {
                match receiver.recv_timeout(POLL) {
                    Ok(result) => return result,
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(error) = Python::attach(|py| py.check_signals()) {
                            stop.ask(error);
                        }
                    }
                    Err(RecvTimeoutError::Disconnected) => unreachable!("the work sends once"),
                }
            }
        });
        stop.outcome(result)
    })
}

/// Does work that takes no time worth stopping on the calling thread, without the interpreter lock.
pub(crate) fn brief<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> T + Send) -> PyResult<T> {
    let stop = Stop::default();
    py.detach(|| stop.outcome(catch_unwind(AssertUnwindSafe(|| work(&stop)))))
}
