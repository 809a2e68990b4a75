//! The threads of the process.

use clap::Args;
use microslip::Error;

/// Threads at most: more than any machine has, and few enough to start.
const MOST_THREADS: i64 = 1024;

#[derive(Args)]
pub(super) struct Threads {
    /// Threads, 1 to 1024; all cores if absent. The results do not depend on it.
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..=MOST_THREADS))]
    threads: Option<u16>,
}

impl Threads {
    /// Starts as many threads as were asked for, or one for each core.
    pub(super) fn start(&self) -> Result<(), Error> {
        // without a number of ours, Rayon would start as many as its variable of the environment says, however many these are
        let cores = || std::thread::available_parallelism().map_or(1, usize::from);
        rayon::ThreadPoolBuilder::new()
            .num_threads(self.threads.map_or_else(cores, usize::from))
            .build_global()
            .map_err(|error| Error::Threads(error.to_string()))
    }
}
