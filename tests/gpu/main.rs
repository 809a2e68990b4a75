//! The GPU backend against the processor: layout, algorithm and precision of the contact passes; lanes; failures.
//!
//! `MICROSLIP_ADAPTER` names the adapter, by default any, software too. Without one the tests that need it say that they
//! are skipped; with `MICROSLIP_REQUIRE_GPU=1` they fail instead.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test that cannot set up its device or study fails"
)]

mod accuracy;
mod failure;
mod lanes;
mod layout;
mod node;
mod states;

use microslip::gpu::{Device, Precision, adapters};

/// A device for a test, or `None` after saying that the test is skipped.
fn device(test: &str, precision: Precision) -> Option<Device> {
    let wanted = std::env::var("MICROSLIP_ADAPTER").unwrap_or_else(|_| "0".to_owned());
    let opened = match adapters().is_empty() {
        true => Err("no adapter".to_owned()),
        false => Device::open(Some(&wanted), 0, precision).map_err(|error| error.to_string()),
    };
    match opened {
        Ok(device) => {
            eprintln!(
                "{test}: on {} ({})",
                device.adapter.name, device.adapter.kind
            );
            Some(device)
        }
        Err(reason) => {
            let required = std::env::var("MICROSLIP_REQUIRE_GPU").is_ok_and(|v| v == "1");
            assert!(!required, "{test} needs a GPU: {reason}");
            eprintln!("{test}: SKIPPED, {reason}");
            None
        }
    }
}
