//! Which share of a run a process solves, as it is said or as the job scheduler says.

use clap::Args;
use microslip::Error;
use microslip::study::SampleShare;

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
    Share(SampleShare),
    /// Several solve together; this one has the rank.
    Together(u64),
}

impl Shares {
    pub(super) fn work(&self) -> Result<Work, Error> {
        Ok(match (&self.shard, self.only_atlas, self.join) {
            (Some(shard), ..) => Work::Share(shard.share()?),
            (None, true, _) => Work::Share(SampleShare::Atlas),
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
    fn share(self) -> Result<SampleShare, Error> {
        let (number, of) = match self {
            Self::Given(number, of) => (number, of),
            Self::Array => in_array().ok_or_else(|| Error::Option {
                option: "--shard",
                rule: "must be I/N where SLURM_ARRAY_TASK_ID, SLURM_ARRAY_TASK_MIN and SLURM_ARRAY_TASK_COUNT are not set",
            })?,
        };
        Ok(SampleShare::Shard { number, of })
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

/// Variables of Slurm, Open MPI and MPICH.
const RANK: [&str; 3] = ["SLURM_PROCID", "OMPI_COMM_WORLD_RANK", "PMI_RANK"];
/// Variables of Slurm, Open MPI, Intel MPI with MPICH, and PALS.
const LOCAL_RANK: [&str; 4] = [
    "SLURM_LOCALID",
    "OMPI_COMM_WORLD_LOCAL_RANK",
    "MPI_LOCALRANKID",
    "PALS_LOCAL_RANKID",
];

/// Number of this process among those started together, from 0; 0 where nobody says it.
fn rank() -> u64 {
    first_of(&RANK, number)
}

/// Number of this process among those started together on its node, from 0; 0 where nobody says it.
pub(super) fn local_rank() -> u64 {
    first_of(&LOCAL_RANK, number)
}

/// The first number among variables; 0 without one.
fn first_of(names: &[&str], number: impl Fn(&str) -> Option<u64>) -> u64 {
    names.iter().find_map(|name| number(name)).unwrap_or(0)
}

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each process of a node knows its number there, which is not that among all nodes; so each takes a GPU of its own
    /// (`gpu::choice`). Seen to fail with the variables of the rank in place of those of the local rank.
    #[test]
    fn processes_of_a_node_are_counted_on_their_node() {
        let under = |set: &'static [(&str, u64)]| {
            move |name: &str| set.iter().find(|(of, _)| *of == name).map(|(_, n)| *n)
        };
        let slurm = under(&[("SLURM_PROCID", 5), ("SLURM_LOCALID", 1)]);
        assert_eq!(
            [first_of(&RANK, slurm), first_of(&LOCAL_RANK, slurm)],
            [5, 1]
        );
        let open_mpi = under(&[
            ("OMPI_COMM_WORLD_RANK", 6),
            ("OMPI_COMM_WORLD_LOCAL_RANK", 2),
        ]);
        let both = [&RANK[..], &LOCAL_RANK];
        assert_eq!(both.map(|names| first_of(names, open_mpi)), [6, 2]);
        assert_eq!(both.map(|names| first_of(names, |_| None)), [0, 0]);
    }
}
