//! Which share of a run a process solves, as it is said or as the job scheduler says.

use clap::Args;
use microslip::Error;
use microslip::study::Share;

#[derive(Args)]
#[group(multiple = false)]
pub(super) struct Shares {
    /// Solve the samples from which all others start, and keep them; no results yet.
    #[arg(long)]
    only_atlas: bool,
    /// Solve share I of N (from 0), and keep it; no results yet. In a Slurm array the two are known.
    #[arg(long, value_name = "I/N", num_args = 0..=1, default_missing_value = "array", value_parser = shard)]
    shard: Option<Shard>,
    /// Solve together with all processes that join in the same folder; the last one writes the results.
    #[arg(long)]
    join: bool,
}

/// Who solves what.
pub(super) enum Work {
    /// One process solves all.
    Alone,
    /// This one solves a share.
    Share(Share),
    /// Several solve together; this one has the rank.
    Together(u64),
}

impl Shares {
    pub(super) fn work(&self) -> Result<Work, Error> {
        Ok(match (&self.shard, self.only_atlas, self.join) {
            (Some(shard), ..) => Work::Share(shard.share()?),
            (None, true, _) => Work::Share(Share::Atlas),
            (None, _, true) => Work::Together(rank()),
            (None, false, false) => Work::Alone,
        })
    }
}

/// A shard as it is asked for.
#[derive(Clone, Copy)]
enum Shard {
    /// The task of a Slurm array.
    Array,
    /// Number, and how many.
    Given(u64, u64),
}

impl Shard {
    fn share(self) -> Result<Share, Error> {
        let (number, of) = match self {
            Self::Given(number, of) => (number, of),
            Self::Array => in_array().ok_or_else(|| Error::Command {
                path: "--shard".into(),
                message: "must be I/N where SLURM_ARRAY_TASK_ID, SLURM_ARRAY_TASK_MIN and SLURM_ARRAY_TASK_COUNT are not set".to_owned(),
            })?,
        };
        Ok(Share::Shard { number, of })
    }
}

fn shard(text: &str) -> Result<Shard, String> {
    if text == "array" {
        return Ok(Shard::Array);
    }
    let rule =
        "must be I/N with 0 <= I < N, such as 0/8 and 7/8 for the first and the last of eight";
    let numbers = text
        .split_once('/')
        .and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
    match numbers {
        Some((number, of)) if number < of => Ok(Shard::Given(number, of)),
        _ => Err(rule.to_owned()),
    }
}

/// Number of this task in its Slurm array, from 0, and their count.
fn in_array() -> Option<(u64, u64)> {
    let [id, least, count] =
        ["ID", "MIN", "COUNT"].map(|name| number(&format!("SLURM_ARRAY_TASK_{name}")));
    let number = id?.checked_sub(least?)?;
    count
        .filter(|count| number < *count)
        .map(|count| (number, count))
}

/// Number of this process among those started together, from 0; 0 where nobody says it.
fn rank() -> u64 {
    let names = ["SLURM_PROCID", "OMPI_COMM_WORLD_RANK", "PMI_RANK"];
    names.into_iter().find_map(number).unwrap_or(0)
}

/// Number of this process among those started together on its node, from 0; 0 where nobody says it.
pub(super) fn local_rank() -> u64 {
    let names = [
        "SLURM_LOCALID",
        "OMPI_COMM_WORLD_LOCAL_RANK",
        "MPI_LOCALRANKID",
        "PALS_LOCAL_RANKID",
    ];
    names.into_iter().find_map(number).unwrap_or(0)
}

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}
