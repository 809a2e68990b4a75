//! What the panels of forced responses share: their window, their amplitude axis and the linear limits.

use crate::page::axis::Axis;
use crate::page::figure::Panel;
use crate::report::numbers::outer_points::outer_groups;
use crate::report::numbers::peaks::usable_peak;
use crate::report::page::view::{Shown, View};
use crate::report::run::input::ReportInput;
use crate::statistics::{Sorted, hull, quantile};

/// Label of the abscissa.
pub(super) const FREQUENCY: &str = "Excitation frequency (Hz)";

/// Frequencies that hold nearly all resonances of every population, the free and the stuck one included, with space for the
/// flanks.
pub(super) fn window(view: &View) -> (f64, f64) {
    let ReportInput {
        record, outcomes, ..
    } = *view.input;
    let most = |(_, members): (_, Vec<usize>)| {
        let levels = members.iter().flat_map(|&sample| &outcomes[sample].levels);
        let sorted = Sorted::finite(levels.filter_map(|l| Some(usable_peak(l)?.frequency_hz)));
        [quantile(&sorted, 0.02), quantile(&sorted, 0.98)]
    };
    let most = outer_groups(outcomes).into_iter().flat_map(most).flatten();
    let nominal = (0..view.n_levels()).filter_map(|i| view.nominal(Shown::Frequency, i));
    let linear = [&record.free, &record.stuck].into_iter();
    let linear = linear.filter_map(|limit| limit.frequency_hz);
    let [low, high] = hull(most.chain(linear).chain(nominal)).unwrap_or([0.0, 1.0]);
    let space = (0.15 * (high - low)).max(4e-4 * high);
    (low - space, high + space)
}

pub(super) fn amplitude_axis(view: &View, top: f64) -> Axis {
    Axis::linear(view.label(Shown::AmplitudePerLevel), 0.0, 1.06 * top)
}

/// The linear limits, the frequencies of each divided by `unit` of its resonance (Hz); left out where there is none.
pub(super) fn add_linear_curves(
    view: &View,
    panel: &mut Panel,
    unit: impl Fn(Option<f64>) -> Option<f64>,
) {
    let record = view.input.record;
    for (class, linear) in [("free", &record.free), ("stuck", &record.stuck)] {
        let Some(unit) = unit(linear.frequency_hz) else {
            continue;
        };
        let points = view.curve(&linear.curve, 1.0).into_iter();
        panel.line(class, points.map(|(f, a)| (f / unit, a)));
    }
}

pub(super) fn largest_linear_amplitude(view: &View) -> f64 {
    let record = view.input.record;
    let limits = [&record.free, &record.stuck].map(|linear| view.largest(&linear.curve, 1.0));
    limits.into_iter().flatten().fold(0.0, f64::max)
}

/// Solutions of the nominal curve of level `i` whose stability was assessed, as [`View::curve`] has them, with whether they are unstable.
pub(super) fn assessed(view: &View, i: usize) -> Vec<((f64, f64), bool)> {
    let nominal = view.input.record.nominal.iter();
    let points = nominal.flat_map(|nominal| {
        let level = &nominal.levels[i];
        let places = view.curve(level.around.curve(), level.level);
        places.into_iter().zip(level.around.curve())
    });
    let judged = points.filter_map(|(place, point)| Some((place, point.unstable?)));
    judged.collect()
}

/// Those that are unstable.
pub(super) fn unstable(view: &View, i: usize) -> impl Iterator<Item = (f64, f64)> + use<> {
    let assessed = assessed(view, i).into_iter();
    assessed.filter_map(|(place, unstable)| unstable.then_some(place))
}
