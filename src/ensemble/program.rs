//! The program that solves samples: version, commit and instruction set.
//!
//! The same program gives the same bits on one kind of processor. Dense solves of the linear algebra library choose their kernels
//! by the instruction set, and so change the last bits of a result from one kind to another.

use serde::{Deserialize, Serialize};

/// What the bits of a result depend on, beside the study.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Program {
    /// Version of this program.
    pub version: String,
    /// Commit that it was built from, as stated at its build; absent if nobody stated one.
    pub commit: Option<String>,
    /// Instruction set of the processor: `avx512`, `avx2`, `neon` or `baseline`.
    pub instruction_set: String,
}

impl Program {
    /// The program that runs, on the processor that it runs on.
    #[must_use]
    pub fn this() -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            commit: option_env!("MICROSLIP_COMMIT").map(str::to_owned),
            instruction_set: instruction_set().to_owned(),
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

/// The widest instruction set that the linear algebra uses here.
fn instruction_set() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if std::arch::is_x86_feature_detected!("avx512f") {
            return "avx512";
        }
        if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma")
        {
            return "avx2";
        }
        "baseline"
    }
    #[cfg(target_arch = "aarch64")]
    {
        "neon"
    }
    #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
    {
        "baseline"
    }
}
