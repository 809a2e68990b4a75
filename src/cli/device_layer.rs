//! Mesa's layer for the choice of a device, which is not needed here and speaks of errors.

use std::process::Command;

/// Variables with which a user has decided about the layer, or gives it the window system that it asks for.
const DECIDED: [&str; 3] = [
    "XDG_RUNTIME_DIR",
    "NODEVICE_SELECT",
    "MESA_VK_DEVICE_SELECT",
];

/// Begins the program anew without the layer, which otherwise prints `error: XDG_RUNTIME_DIR` where there is no window system,
/// though nothing is wrong. Devices are chosen by what they are, not by the layer's order of them.
///
/// The loader of Vulkan reads a variable of the environment, and a process can set one safely only for another: so the same
/// process becomes the same program again. Where that is not possible it goes on as it is.
#[cfg(unix)]
pub(super) fn leave_out() {
    use std::os::unix::process::CommandExt;
    if DECIDED.iter().any(|name| std::env::var_os(name).is_some()) {
        return;
    }
    let mut arguments = std::env::args_os();
    let (Some(name), Ok(program)) = (arguments.next(), std::env::current_exe()) else {
        return;
    };
    // returns with an error only
    let _ = Command::new(program)
        .arg0(name)
        .args(arguments)
        .env("NODEVICE_SELECT", "1")
        .exec();
}

/// Mesa's layer is one of Unix.
#[cfg(not(unix))]
pub(super) fn leave_out() {}
