//! Time that a function takes.

use std::time::Instant;

/// Seconds of processor time of `f`, all threads, and its value.
pub(crate) fn processor_time<T>(f: impl FnOnce() -> T) -> (f64, T) {
    let (clock, before) = (Instant::now(), processor_seconds());
    let value = f();
    let spent = match (before, processor_seconds()) {
        (Some(before), Some(after)) => after - before,
        _ => clock.elapsed().as_secs_f64(),
    };
    (spent, value)
}

/// Of this process so far, where the system tells (Linux; ticks of 10 ms).
fn processor_seconds() -> Option<f64> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    let fields: Vec<&str> = stat.rsplit(')').next()?.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    Some(ticks / 100.0)
}

pub(crate) fn milliseconds(n: u32, mut f: impl FnMut()) -> f64 {
    let one = |f: &mut dyn FnMut()| {
        let clock = Instant::now();
        (0..n).for_each(|_| f());
        clock.elapsed().as_secs_f64() * 1e3 / f64::from(n)
    };
    (0..5).map(|_| one(&mut f)).fold(f64::INFINITY, f64::min)
}
