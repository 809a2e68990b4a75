//! The GPU backend: node-states per second against the processor, share of the adapter's roofline, batch sizes; times of the passes of
//! an iteration of lanes; and peaks of samples of the default study with and without lanes in one run.
//!
//!     cargo bench --bench gpu                          # the first GPU that is hardware
//!     cargo bench --bench gpu -- --adapter llvmpipe    # another adapter, software too
//!     cargo bench --bench gpu -- lanes --samples 1000  # of the sections kernels, passes, lanes; samples of the lanes (64)
//!     cargo bench --bench gpu -- passes box --lanes 8192   # one law; lanes of the passes (4096, on software 64)
//!
//! Roofline: operations and bytes of the passes, counted from the shapes of the shaders (a lower bound: root searches and
//! what the caches miss are left out), over the rates of two small kernels measured in the same run, fused
//! multiply-adds on registers and a copy. Times on the device are its own timestamps where it has them.
#![allow(clippy::expect_used, reason = "a benchmark that cannot be set up ends")]

mod kernels;
mod lanes;
mod passes;
mod roofline;
#[path = "../states/mod.rs"]
mod states;

use microslip::contact::FrictionLaw;
use microslip::gpu::{Device, Precision};
use roofline::Peak;

const LAWS: [FrictionLaw; 2] = [FrictionLaw::Box, FrictionLaw::Circle];
const SECTIONS: [&str; 3] = ["kernels", "passes", "lanes"];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let at = arguments.iter().position(|a| a == name)?;
        arguments.get(at + 1).cloned()
    };
    let number = |name: &str| value(name).and_then(|n| n.parse().ok());
    let adapter = value("--adapter");
    let device = match Device::open(adapter.as_deref(), 0, Precision::F32) {
        Ok(device) => device,
        Err(error) => {
            println!("nothing to measure: {error}");
            return;
        }
    };
    let facts = &device.adapter;
    println!(
        "{} ({}, {}, {})",
        facts.name, facts.kind, facts.interface, facts.driver
    );
    let named = |name: &str| arguments.iter().any(|a| a == name);
    let asked = |section: &str| named(section) || !SECTIONS.into_iter().any(named);
    let name = |law: &FrictionLaw| format!("{law:?}").to_lowercase();
    let all = !LAWS.iter().any(|law| named(&name(law)));
    let laws = || LAWS.into_iter().filter(|law| all || named(&name(law)));
    if asked("kernels") {
        let peak = Peak::of(&device);
        laws().for_each(|law| kernels::kernels(&device, &peak, law));
    }
    if asked("passes") {
        let lanes = if facts.is_hardware() { 4096 } else { 64 };
        let lanes = number("--lanes").unwrap_or(lanes);
        let peak = Peak::of(&device);
        laws().for_each(|law| passes::passes(&device, &peak, law, lanes));
    }
    if asked("lanes") {
        let samples = number("--samples").unwrap_or(64);
        laws().for_each(|law| lanes::lanes(law, facts, samples as u64));
    }
}
