//! Work of the engine that Ctrl-C ends, while the threads of Python go on.

use crate::errors::StudyError;
use microslip::ensemble::stop::Stop;
use microslip::study::Progress;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

/// How often signals are looked at and progress is told.
const TICK: Duration = Duration::from_millis(50);

/// How work is carried out and what watches it.
pub(crate) struct Work<'a, 'py> {
    pool: Option<&'a ThreadPool>,
    told: Option<Bound<'py, PyAny>>,
    stop: Stop,
    progress: Meter,
}

/// How far the work has come, from any thread.
#[derive(Default)]
pub(crate) struct Meter(Mutex<Option<Progress>>);

impl Meter {
    pub(crate) fn note(&self, progress: Progress) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(progress);
    }

    fn take(&self) -> Option<Progress> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// A pool of so many threads, if a number is given.
pub(crate) fn pool(threads: Option<usize>) -> PyResult<Option<ThreadPool>> {
    let Some(threads) = threads else {
        return Ok(None);
    };
    if !(1..=1024).contains(&threads) {
        let message = format!("threads = {threads}: must be from 1 to 1024");
        return Err(StudyError::new_err(message));
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.map(Some)
        .map_err(|error| StudyError::new_err(format!("threads: {error}")))
}

impl<'a, 'py> Work<'a, 'py> {
    /// Work on the threads of `pool`, else on those of the process; `told` is called with parts done and parts in all.
    pub(crate) fn new(pool: Option<&'a ThreadPool>, told: Option<Bound<'py, PyAny>>) -> Self {
        Self {
            pool,
            told,
            stop: Stop::default(),
            progress: Meter::default(),
        }
    }

    /// Does `work` on another thread without the lock of the interpreter. A signal whose handler raises, or progress that cannot be
    /// told, asks it to stop, and is raised when it has.
    pub(crate) fn done<T: Send>(
        &self,
        py: Python<'_>,
        work: impl FnOnce(&Stop, &Meter) -> T + Send,
    ) -> PyResult<T> {
        let (send, receive) = channel();
        let receive = Mutex::new(receive);
        let (pool, stop, progress) = (self.pool, &self.stop, &self.progress);
        std::thread::scope(|scope| {
            let worker = scope.spawn(move || {
                let result = match pool {
                    Some(pool) => pool.install(|| work(stop, progress)),
                    None => work(stop, progress),
                };
                // the receiver waits until the end
                let _ = send.send(result);
            });
            let mut raised = None;
            let result = loop {
                let next = py.detach(|| {
                    let receive = receive.lock().unwrap_or_else(PoisonError::into_inner);
                    receive.recv_timeout(TICK)
                });
                match next {
                    Ok(result) => break Some(result),
                    Err(RecvTimeoutError::Disconnected) => break None,
                    Err(RecvTimeoutError::Timeout) => {}
                }
                if let Err(error) = py.check_signals().and_then(|()| self.tell()) {
                    self.stop.ask();
                    raised.get_or_insert(error);
                }
            };
            if let Err(panic) = worker.join() {
                std::panic::resume_unwind(panic);
            }
            match (raised, result) {
                (None, Some(result)) => {
                    self.tell()?;
                    Ok(result)
                }
                (Some(error), _) => Err(error),
                (None, None) => Err(StudyError::new_err("the work ended without a result")),
            }
        })
    }

    fn tell(&self) -> PyResult<()> {
        let (Some(told), Some(Progress { done, total, .. })) = (&self.told, self.progress.take())
        else {
            return Ok(());
        };
        told.call1((done, total)).map(|_| ())
    }
}
