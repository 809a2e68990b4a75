//! Smallest value of a function of one unknown, by golden section.

/// Golden section.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Where a function with one minimum between `low` and `high` is smallest; each step makes the interval 0.618 times as long.
pub(super) fn smallest(
    [mut low, mut high]: [f64; 2],
    steps: usize,
    of: impl Fn(f64) -> f64,
) -> f64 {
    let mut inner = [high - GOLDEN * (high - low), low + GOLDEN * (high - low)];
    let mut value = inner.map(&of);
    for _ in 0..steps {
        if value[0] < value[1] {
            high = inner[1];
            inner = [high - GOLDEN * (high - low), inner[0]];
            value = [of(inner[0]), value[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + GOLDEN * (high - low)];
            value = [value[1], of(inner[1])];
        }
    }
    0.5 * (low + high)
}
