//! The mean loop of each drawn test with what was fitted to it, force ratio and residual.

use super::parameter::show_all;
use super::view::{View, short_name};
use crate::identify::found::result::{LoopFigure, TestResult};
use crate::page::axis::Axis;
use crate::page::block::{Block, Figure, Key, Mark, Section};
use crate::page::display::percent;
use crate::page::figure::{Panel, Size};
use crate::page::thinning::thinned;

/// Absent where no test has a loop.
pub(super) fn section(view: &View) -> Option<Section> {
    if view.drawn.is_empty() {
        return None;
    }
    let keys = [
        Key::new(
            Mark::Line,
            "line l0",
            "mean of the steady loops, in the colour of the test",
        ),
        Key::level(
            0,
            "samples that a stiffness or the friction coefficient is from",
        ),
        Key::new(
            Mark::Line,
            "line free",
            "elastic-Coulomb contact with the parameters of the test",
        ),
        Key::new(
            Mark::Line,
            "line stuck",
            "stick branches: lines through these samples, after both reversals",
        ),
        Key::new(
            Mark::Line,
            "rule quantile",
            "plateaus: the friction coefficient on both sides",
        ),
        Key::new(
            Mark::Band,
            "range",
            format!("its {} interval", percent(view.confidence())),
        ),
    ];
    let mut blocks = vec![Block::Legend(keys.into())];
    for (level, test) in view.drawn() {
        if let Some(columns) = &test.figure {
            blocks.push(Block::Heading(test.name.clone()));
            blocks.push(Block::triples(figures(view, level, test, columns)));
        }
    }
    let words = "Displacement about the middle of its swing; the offset of T that the plateaus show is taken out. Dashed: what \
                 the model of the study makes of the measured displacement and load. What it leaves, the residual, is noise \
                 where it looks like noise; a shape that repeats is physics that the model has not.";
    blocks.push(Block::Hint(
        format!("{words} {}", view.not_drawn())
            .trim_end()
            .to_owned(),
    ));
    Some(Section {
        id: "loops",
        title: "Loops and what was fitted".to_owned(),
        blocks,
    })
}

fn figures(view: &View, level: usize, test: &TestResult, columns: &LoopFigure) -> Vec<Figure> {
    let drawn = Drawn {
        view,
        level,
        name: short_name(&test.name),
        test,
        columns,
        x: columns
            .displacement_m
            .iter()
            .map(|x| x * view.unit.per_metre)
            .collect(),
    };
    vec![drawn.forces(), drawn.ratio(), drawn.residual()]
}

/// One test under its panels.
struct Drawn<'a> {
    view: &'a View<'a>,
    level: usize,
    name: String,
    test: &'a TestResult,
    columns: &'a LoopFigure,
    /// Displacement in the unit of the page.
    x: Vec<f64>,
}

impl Drawn<'_> {
    fn panel(&self, title: &str, label: &str, values: impl Iterator<Item = f64>) -> Panel {
        let x = Axis::around(
            format!("Displacement ({})", self.view.unit.symbol),
            self.x.iter().copied(),
        );
        let y = Axis::around(label, values);
        Panel::new(Size::Small, format!("{}: {title}", self.name), x, y)
    }

    /// The whole cycle, closed.
    fn cycle(&self, values: &[f64]) -> Vec<(f64, f64)> {
        let points: Vec<(f64, f64)> = self.x.iter().copied().zip(values.iter().copied()).collect();
        let first = points.first().copied();
        thinned(points).into_iter().chain(first).collect()
    }

    /// Samples of windows; those that lie over the end of the cycle go on at its start.
    fn samples(&self, values: &[f64], windows: [Option<[usize; 2]>; 2]) -> Vec<(f64, f64)> {
        let n = self.x.len().min(values.len());
        let inside = |[first, last]: [usize; 2]| {
            let length = if first <= last {
                last - first
            } else {
                last + n - first
            };
            (first..=first + length).map(move |k| k % n.max(1))
        };
        let chosen = windows.into_iter().flatten().flat_map(inside);
        let points = chosen.filter_map(|k| Some((*self.x.get(k)?, *values.get(k)?)));
        thinned(points.collect())
    }

    fn figure(&self, panel: &Panel, file: &str, caption: String) -> Figure {
        self.view
            .figure(panel, format!("{file}-{}", self.level), caption)
    }

    fn forces(&self) -> Figure {
        let force = &self.columns.tangential_force_n;
        let fitted = self.columns.fitted_force_n.as_deref();
        let values = force.iter().chain(fitted.into_iter().flatten()).copied();
        let mut panel = self.panel("loop", "Tangential force T (N)", values);
        panel.line(&format!("l{}", self.level), self.cycle(force).into_iter());
        panel.dots(
            self.level,
            self.samples(force, self.columns.stick_windows).into_iter(),
        );
        if let Some(fitted) = fitted {
            panel.line("free", self.cycle(fitted).into_iter());
        }
        for ends in self.columns.stick_lines.iter().flatten() {
            let ends = ends.map(|[x, force]| (x * self.view.unit.per_metre, force));
            panel.line("stuck", ends.into_iter());
        }
        let stiffness = self
            .test
            .estimate
            .as_ref()
            .map(|e| e.tangential.stiffness_n_per_um);
        let caption = stiffness.map(|k| {
            let [value, lower, upper] = show_all(k);
            format!("Stiffness {value} ({lower} to {upper}) N/µm. ")
        });
        self.figure(&panel, "loop", caption.unwrap_or_default())
    }

    fn ratio(&self) -> Figure {
        let ratio = &self.columns.force_ratio;
        let friction = self.test.estimate.as_ref().and_then(|e| e.friction);
        let coefficient = friction.map(|f| f.coefficient);
        let ends = coefficient.map(|mu| [mu.lower, mu.upper, -mu.lower, -mu.upper]);
        let values = ratio.iter().copied().chain(ends.into_iter().flatten());
        let mut panel = self.panel("T/N", "T/N", values);
        let caption = match coefficient {
            Some(mu) => {
                let [low, high] = Axis::around("", self.x.iter().copied()).range();
                for [least, greatest] in [[mu.lower, mu.upper], [-mu.upper, -mu.lower]] {
                    panel.band("range", &[low, high].map(|x| (x, least, greatest)));
                }
                for side in [mu.value, -mu.value] {
                    panel.level_rule("quantile", side);
                }
                let [value, lower, upper] = show_all(mu);
                format!("Plateau at ±{value} ({lower} to {upper}). ")
            }
            None => "No plateau: the contact does not slip as a whole. ".to_owned(),
        };
        panel.line(&format!("l{}", self.level), self.cycle(ratio).into_iter());
        panel.dots(
            self.level,
            self.samples(ratio, self.columns.plateaus).into_iter(),
        );
        self.figure(&panel, "ratio", caption)
    }

    fn residual(&self) -> Figure {
        let residual = self.columns.residual_n.as_deref();
        let values = residual.into_iter().flatten().copied();
        let mut panel = self.panel("residual", "Measured − fitted T (N)", values);
        panel.level_rule("zero", 0.0);
        match residual {
            Some(residual) => panel.line(
                &format!("l{}", self.level),
                self.cycle(residual).into_iter(),
            ),
            None => panel.note("nothing fitted"),
        }
        let misfit = self.test.estimate.as_ref().map(|e| e.misfit);
        let caption = misfit.filter(|_| residual.is_some()).map(|misfit| {
            let large = if misfit.large { ", which is large" } else { "" };
            format!(
                "Misfit {} of the swing of T{large}. ",
                percent(misfit.relative_rms)
            )
        });
        self.figure(&panel, "residual", caption.unwrap_or_default())
    }
}
