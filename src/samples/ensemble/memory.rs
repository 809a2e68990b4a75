//! How many samples are solved at once in the memory that there is.
//!
//! A process that asks for more memory than there is is ended by the system. So the run asks before it starts as many samples as
//! it has threads, and starts fewer where they do not fit.

use std::path::Path;

/// Share of the available memory that solves may take; the rest is for tables, the atlas and other programs.
const SHARE: f64 = 0.8;

/// Bytes that this process may still take; none where the system does not say it.
///
/// The least of what the machine has, what the control groups of the process leave (as of a job of Slurm or of a container), and what
/// its limit of addresses leaves (`ulimit -v`). Linux only.
#[must_use]
pub fn available_bytes() -> Option<f64> {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let machine = kilobytes(&read("/proc/meminfo"), "MemAvailable:");
    let taken = kilobytes(&read("/proc/self/status"), "VmSize:");
    let addresses = address_limit(&read("/proc/self/limits"));
    let addresses = addresses.zip(taken).map(|(limit, taken)| limit - taken);
    let groups = groups(&read("/proc/self/cgroup"));
    let groups = groups.iter().filter_map(|group| left_by(Path::new(group)));
    let all = machine.into_iter().chain(addresses).chain(groups);
    all.reduce(f64::min).map(|bytes| bytes.max(0.0))
}

/// Number of samples, at least 1, that fit into `available` bytes at once, if each takes so many: usually, and at most.
///
/// # Errors
/// A sentence, if not even one sample fits as it usually is.
pub fn samples_at_once([usual, most]: [f64; 2], available: f64) -> Result<usize, String> {
    if usual > available {
        return Err(format!(
            "a sample takes about {:.0} MB of memory, and {:.0} MB are available: fewer harmonics or contact pairs, or more memory",
            usual / 1e6,
            available / 1e6
        ));
    }
    Ok(((SHARE * available / most) as usize).max(1))
}

/// The number behind `name` in lines such as `VmSize:  1234 kB`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<f64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(1024.0 * number)
}

/// The soft limit in the table of limits of a process; none where it is unlimited.
fn address_limit(text: &str) -> Option<f64> {
    let mut lines = text.lines();
    let line = lines.find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// Folders of the control groups that the lines of `/proc/self/cgroup` name: of each group and those around it.
fn groups(text: &str) -> Vec<String> {
    let mut folders = Vec::new();
    for line in text.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else {
            continue;
        };
        let root = match controllers {
            "" => "/sys/fs/cgroup",
            "memory" => "/sys/fs/cgroup/memory",
            _ => continue,
        };
        let around = Path::new(path).ancestors();
        folders.extend(around.map(|group| format!("{root}{}", group.display())));
    }
    folders
}

/// What a control group leaves: its limit less what is taken, without files that the system can drop from the memory.
fn left_by(group: &Path) -> Option<f64> {
    let number = |name: &str| -> Option<f64> {
        let text = std::fs::read_to_string(group.join(name)).ok()?;
        text.trim().parse().ok()
    };
    let limit = number("memory.max").or_else(|| number("memory.limit_in_bytes"))?;
    let taken = number("memory.current").or_else(|| number("memory.usage_in_bytes"))?;
    let stat = std::fs::read_to_string(group.join("memory.stat")).unwrap_or_default();
    let files = |line: &str| line.strip_prefix("inactive_file ")?.trim().parse().ok();
    let files: f64 = stat.lines().find_map(files).unwrap_or(0.0);
    Some(limit - (taken - files))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seen to fail with the usual memory in place of the largest, and without the least of one sample.
    #[test]
    fn as_many_samples_as_fit_are_solved_at_once() {
        let at_once = |available| samples_at_once([6e7, 4e8], available);
        assert_eq!(at_once(5e9), Ok(10));
        assert_eq!(at_once(1e8), Ok(1), "one may take less than at most");
        let refused = at_once(5e7).unwrap_err();
        assert!(
            refused.starts_with("a sample takes about 60 MB"),
            "{refused}"
        );
    }

    /// Seen to fail with kilobytes taken as bytes, and with an unlimited limit taken as none left.
    #[test]
    fn limits_are_read_as_linux_writes_them() {
        let status = "Name:\tmicroslip\nVmSize:\t   12288 kB\nVmRSS:\t 9000 kB\n";
        assert_eq!(kilobytes(status, "VmSize:"), Some(12288.0 * 1024.0));
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max address space         2097152000           unlimited            bytes     \n";
        assert_eq!(address_limit(limits), Some(2_097_152_000.0));
        let unlimited =
            "Max address space         unlimited            unlimited            bytes     \n";
        assert_eq!(address_limit(unlimited), None);
        let job = "12:memory:/slurm/job_7\n3:cpu:/other\n0::/slice/job_7\n";
        let expected = [
            "/sys/fs/cgroup/memory/slurm/job_7",
            "/sys/fs/cgroup/memory/slurm",
            "/sys/fs/cgroup/memory/",
            "/sys/fs/cgroup/slice/job_7",
            "/sys/fs/cgroup/slice",
            "/sys/fs/cgroup/",
        ];
        assert_eq!(groups(job), expected);
    }

    /// A group of 100 MB of which 70 MB are taken, 20 MB of these by files. Seen to fail with files counted as taken.
    #[test]
    fn control_groups_leave_what_is_not_taken() {
        let group = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(group.path().join(name), text).unwrap();
        assert_eq!(left_by(group.path()), None, "no limit");
        write("memory.max", "100000000\n");
        write("memory.current", "70000000\n");
        write("memory.stat", "anon 50000000\ninactive_file 20000000\n");
        assert_eq!(left_by(group.path()), Some(5e7));
        write("memory.max", "max\n");
        assert_eq!(left_by(group.path()), None, "an open limit");
    }
}
