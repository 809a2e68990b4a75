//! What every command says of its process: threads, and messages.

use super::log::Messages;
use super::threads::Threads;
use clap::Args;

#[derive(Args)]
pub(super) struct Process {
    #[command(flatten)]
    pub threads: Threads,
    #[command(flatten)]
    pub messages: Messages,
}
