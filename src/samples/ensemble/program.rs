//! The program that solves samples: version, commit and instruction set.
//!
//! The same program gives the same bits on one kind of processor. Dense solves of the linear algebra library choose their kernels
//! by the instruction set, and so change the last bits of a result from one kind to another. Built without the feature
//! `widest-vectors` they take no wider one than AVX2, and so all processors that have it give the same bits.

use serde::{Deserialize, Serialize};

/// What the bits of a result depend on, beside the study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Program {
    /// Version of this program.
    pub version: String,
    /// Commit that it was built from, as stated at its build; absent if nobody stated one.
    pub commit: Option<String>,
    /// Instruction set of the dense solves: `avx512`, `avx2`, `neon` or `baseline`; `pinned-avx2` and so on of a program that was built
    /// to take no wider one than AVX2.
    pub instruction_set: String,
}

impl Program {
    /// The program that runs, on the processor that it runs on.
    #[must_use]
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("MICROSLIP_COMMIT").map(str::to_owned),
            instruction_set: instruction_set(),
        }
    }

    /// Such as `0.1.0 (1a2b3c) on avx512`.
    #[must_use]
    pub fn in_words(&self) -> String {
        let commit = self.commit.as_ref();
        let commit = commit.map_or_else(String::new, |commit| format!(" ({commit})"));
        format!("{}{commit} on {}", self.version, self.instruction_set)
    }
}

/// The process that runs it, such as `node7, process 4711`.
#[must_use]
pub fn this_process() -> String {
    let host = gethostname::gethostname();
    format!("{}, process {}", host.to_string_lossy(), std::process::id())
}

/// The instruction set that the linear algebra uses here.
fn instruction_set() -> String {
    let pinned = match cfg!(feature = "widest-vectors") {
        true => "",
        false => "pinned-",
    };
    format!("{pinned}{}", kernels())
}

/// The instruction set of the kernels that the linear algebra chooses.
#[cfg(target_arch = "x86_64")]
fn kernels() -> &'static str {
    let widest = cfg!(feature = "widest-vectors");
    if widest && std::arch::is_x86_feature_detected!("avx512f") {
        return "avx512";
    }
    match std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
    {
        true => "avx2",
        false => "baseline",
    }
}

/// The instruction set of the kernels that the linear algebra chooses.
#[cfg(not(target_arch = "x86_64"))]
fn kernels() -> &'static str {
    match cfg!(target_arch = "aarch64") {
        true => "neon",
        false => "baseline",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pulp::Arch;

    /// What a result says of its instruction set is what the vector library takes, in both builds. Seen to fail with the AVX-512
    /// of the processor named in a build that does not take it.
    #[test]
    fn the_instruction_set_is_the_one_in_use() {
        let said = Program::this().instruction_set;
        let pinned = !cfg!(feature = "widest-vectors");
        assert_eq!(said.starts_with("pinned-"), pinned, "{said}");
        let taken = format!("{:?}", Arch::new());
        assert_eq!(said.contains("avx512"), taken.starts_with("V4"), "{taken}");
        assert_eq!(said.contains("avx2"), taken.starts_with("V3"), "{taken}");
    }
}
