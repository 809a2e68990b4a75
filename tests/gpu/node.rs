//! A node with two adapters: each process that is started there takes one of its own.

use crate::device;
use assert_cmd::Command;
use microslip::gpu::Precision;
use std::path::{Path, PathBuf};

/// Where loaders of Vulkan look for the drivers of the system.
const MANIFESTS: &str = "/usr/share/vulkan/icd.d";

/// The manifest of Mesa's software driver.
fn software_driver() -> Option<PathBuf> {
    let entries = std::fs::read_dir(MANIFESTS).ok()?;
    let mut paths = entries.filter_map(|entry| Some(entry.ok()?.path()));
    paths.find(|path| {
        let name = path.file_name().and_then(|name| name.to_str());
        name.is_some_and(|name| name.starts_with("lvp_icd"))
    })
}

/// Index of the adapter that a joined process with this local rank has used, on a node with these drivers.
fn adapter_of_rank(rank: &str, drivers: &str, folder: &Path) -> u64 {
    let results = folder.join(rank);
    let output = Command::cargo_bin("microslip")
        .unwrap()
        .args([
            "run",
            "studies/own-matrices/study.toml",
            "--join",
            "--quiet",
        ])
        .args(["--backend", "gpu", "--adapter", "llvmpipe"])
        .args(["--output".as_ref(), results.as_os_str()])
        .env("VK_DRIVER_FILES", drivers)
        .env("SLURM_PROCID", rank)
        .env("SLURM_LOCALID", rank)
        .output()
        .unwrap();
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{message}");
    let summary = std::fs::read_to_string(results.join("summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&summary).unwrap();
    let index = &summary["backend"]["gpu"]["adapter"]["index"];
    index.as_u64().unwrap_or_else(|| panic!("{summary:#}"))
}

/// The loader lists the software adapter once per manifest, so that a copy of the manifest makes a node of two. Seen to fail with the
/// local rank left out of the settings of a run.
#[test]
fn processes_of_a_node_take_an_adapter_each() {
    let name = "processes_of_a_node_take_an_adapter_each";
    let is_software = |device: &microslip::gpu::Device| device.adapter.kind == "software";
    let Some(device) = device(name, Precision::F32).filter(is_software) else {
        return;
    };
    drop(device);
    let first = software_driver().expect("the adapter is Mesa's, and so is a manifest");
    let folder = tempfile::tempdir().unwrap();
    let second = folder.path().join("second.json");
    std::fs::copy(&first, &second).unwrap();
    let drivers = std::env::join_paths([first, second]).unwrap();
    let drivers = drivers.to_str().unwrap();
    let taken = ["0", "1", "2"].map(|rank| adapter_of_rank(rank, drivers, folder.path()));
    assert_eq!(taken, [0, 1, 0]);
}
