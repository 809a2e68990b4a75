//! One panel of a figure as inline SVG. Colours, weights and fonts are in `look/figure.css`, found by class.

use super::axis::Axis;
use super::level_mark::shape;
use minijinja::HtmlEscape;
use std::collections::VecDeque;
use std::fmt::Write;

/// Size of a panel in its own units; the page scales it to its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Size {
    /// Three in a row.
    Small,
    /// Two in a row.
    Large,
    /// Two in a row, with a line for each of so many names.
    Rows(usize),
}

/// Space for the ticks of the vertical axis at least, and beside the widest of them.
const LEFT: [f64; 2] = [54.0, 26.0];
/// Space for half a tick label at the end of the axis.
const RIGHT: f64 = 24.0;
const TOP: f64 = 24.0;
const BOTTOM: f64 = 42.0;
/// Widest character of a tick label in panel units.
const CHARACTER: f64 = 6.6;
/// Usual character of a tick label.
const TICK_WIDTH: f64 = 6.3;
/// Height of a tick label with its surroundings.
const TICK_HEIGHT: f64 = 26.0;

/// Marks of its level along a line.
const MARKS_PER_LINE: usize = 6;
/// Height of a line of words.
const LINE: f64 = 12.0;
/// Rows of names at the upper edge.
const ROWS: usize = 4;
/// Width of the place around a mark where the pointer shows its values.
const REACH: f64 = 14.0;

/// A panel under construction: marks are drawn in the order of the calls.
#[derive(Debug, Clone)]
pub struct Panel {
    width: f64,
    height: f64,
    left: f64,
    title: String,
    x: Axis,
    y: Axis,
    marks: String,
    readouts: String,
    note: Option<String>,
    /// Places of the upright lines.
    upright: Vec<f64>,
}

impl Panel {
    /// An empty panel.
    pub fn new(size: Size, title: impl Into<String>, x: Axis, y: Axis) -> Self {
        let (width, height) = match size {
            Size::Small => (310.0, 214.0),
            Size::Large => (430.0, 305.0),
            Size::Rows(n) => (430.0, TOP + BOTTOM + 26.0 * n.max(2) as f64),
        };
        let ticks = y.ticks(|_| TICK_HEIGHT / (height - TOP - BOTTOM));
        let widest = ticks.iter().map(|t| t.1.chars().count()).max().unwrap_or(0);
        Self {
            width,
            height,
            left: LEFT[0].max(LEFT[1] + TICK_WIDTH * widest as f64),
            title: title.into(),
            x,
            y,
            marks: String::new(),
            readouts: String::new(),
            note: None,
            upright: Vec::new(),
        }
    }

    fn inner(&self) -> (f64, f64) {
        (self.width - self.left - RIGHT, self.height - TOP - BOTTOM)
    }

    /// Position inside the plot area; `None` for what has no place on the axes.
    fn place(&self, x: f64, y: f64) -> Option<(f64, f64)> {
        let (width, height) = self.inner();
        // Far outside is cut off anyway; the clamp keeps the numbers short.
        let x = self.x.position(x)?.clamp(-9.0, 9.0) * width;
        let y = (1.0 - self.y.position(y)?.clamp(-9.0, 9.0)) * height;
        Some((x, y))
    }

    fn path(&mut self, class: &str, data: &str) {
        if !data.is_empty() {
            let _ = write!(self.marks, "<path class=\"{class}\" d=\"{data}\"/>");
        }
    }

    fn polyline(&self, points: impl Iterator<Item = (f64, f64)>) -> String {
        let mut data = String::new();
        let mut command = 'M';
        for (x, y) in points {
            match self.place(x, y) {
                Some((x, y)) => {
                    let _ = write!(data, "{command}{x:.1} {y:.1}");
                    command = 'L';
                }
                None => command = 'M',
            }
        }
        data
    }

    /// A line through the points, interrupted where a point has no place.
    pub fn line(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        let data = self.polyline(points);
        self.path(&format!("line {class}"), &data);
    }

    /// A filled band (x, lower, upper).
    pub fn band(&mut self, class: &str, points: &[(f64, f64, f64)]) {
        let upper = points.iter().map(|p| (p.0, p.2));
        let lower = points.iter().rev().map(|p| (p.0, p.1));
        let data = self.polyline(upper.chain(lower));
        self.path(&format!("band {class}"), &data);
    }

    /// Dots of an excitation level, in its colour and shape; one path for all of them keeps the file small.
    pub fn dots(&mut self, level: usize, points: impl Iterator<Item = (f64, f64)>) {
        self.shapes(&format!("dots l{level}"), shape(level), points);
    }

    /// One mark of an excitation level, large enough to stand on a line.
    pub fn mark(&mut self, level: usize, point: (f64, f64)) {
        if let Some((x, y)) = self.place(point.0, point.1) {
            let shape = shape(level);
            let _ = write!(
                self.marks,
                "<path class=\"mark l{level}\" transform=\"translate({x:.1} {y:.1}) scale(1.7)\" d=\"M0 0{shape}\"/>"
            );
        }
    }

    /// Dots of samples that a figure shows behind others.
    pub fn pale_dots(&mut self, points: impl Iterator<Item = (f64, f64)>) {
        self.shapes("dots solved", shape(0), points);
    }

    fn shapes(&mut self, class: &str, shape: &str, points: impl Iterator<Item = (f64, f64)>) {
        let mut data = String::new();
        for (x, y) in points.filter_map(|(x, y)| self.place(x, y)) {
            let _ = write!(data, "M{x:.1} {y:.1}{shape}");
        }
        self.path(class, &data);
    }

    /// Some marks of an excitation level along a line through the points.
    pub fn marks_along(&mut self, level: usize, points: &[(f64, f64)]) {
        let stride = points.len().div_ceil(MARKS_PER_LINE).max(1);
        // Marks of different levels stand at different places, so that lines that coincide show both.
        let first = (stride * (level % MARKS_PER_LINE)) / MARKS_PER_LINE;
        for &point in points.iter().skip(first).step_by(stride) {
            self.mark(level, point);
        }
    }

    /// Crosses.
    pub fn crosses(&mut self, class: &str, points: impl Iterator<Item = (f64, f64)>) {
        let mut data = String::new();
        for (x, y) in points.filter_map(|(x, y)| self.place(x, y)) {
            let _ = write!(data, "M{:.1} {:.1}l6 6m-6 0l6-6", x - 3.0, y - 3.0);
        }
        self.path(&format!("cross {class}"), &data);
    }

    /// A ring around a nominal value.
    pub fn ring(&mut self, class: &str, point: (f64, f64)) {
        if let Some((x, y)) = self.place(point.0, point.1) {
            let _ = write!(
                self.marks,
                "<circle class=\"ring {class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4.5\"/>"
            );
        }
    }

    /// A staircase that starts at `base`, runs level to each corner and steps there.
    pub fn steps(&mut self, class: &str, corners: &[(f64, f64)], base: f64) {
        let mut height = base;
        let stairs = corners.iter().flat_map(|&(x, y)| {
            let foot = (x, height);
            height = y;
            [foot, (x, y)]
        });
        let data = self.polyline(stairs.collect::<Vec<_>>().into_iter());
        self.path(&format!("line {class}"), &data);
    }

    /// Bars (left, right, height) on the zero line.
    pub fn bars(&mut self, class: &str, bars: impl Iterator<Item = (f64, f64, f64)>) {
        let mut data = String::new();
        for (left, right, height) in bars {
            let corners = (self.place(left, 0.0), self.place(right, height));
            if let (Some((x0, y0)), Some((x1, y1))) = corners {
                // A bin of width 0 (all values equal) is still a bar.
                let x1 = x1.max(x0 + 3.0);
                let _ = write!(data, "M{x0:.1} {y0:.1}V{y1:.1}H{x1:.1}V{y0:.1}Z");
            }
        }
        self.path(&format!("bar {class}"), &data);
    }

    /// A vertical line over the whole height.
    pub fn rule(&mut self, class: &str, x: f64) {
        let (width, height) = self.inner();
        if let Some(x) = self.x.position(x) {
            let x = x.clamp(-9.0, 9.0) * width;
            self.upright.push(x);
            self.path(&format!("rule {class}"), &format!("M{x:.1} 0V{height:.1}"));
        }
    }

    /// A level line over the whole width.
    pub fn level_rule(&mut self, class: &str, y: f64) {
        let (width, height) = self.inner();
        if let Some(y) = self.y.position(y) {
            let data = format!("M0 {:.1}H{width:.1}", (1.0 - y.clamp(-9.0, 9.0)) * height);
            self.path(&format!("rule {class}"), &data);
        }
    }

    /// A vertical line from `low` to `high` at `x` with a bar at each end.
    pub fn whisker(&mut self, class: &str, x: f64, [low, high]: [f64; 2]) {
        if let (Some((x, y0)), Some((_, y1))) = (self.place(x, low), self.place(x, high)) {
            let bar = |y: f64| format!("M{:.1} {y:.1}h8", x - 4.0);
            let data = format!("M{x:.1} {y0:.1}V{y1:.1}{}{}", bar(y0), bar(y1));
            self.path(&format!("whisker {class}"), &data);
        }
    }

    /// A level line from `low` to `high` at `y` with a bar at each end.
    pub fn level_whisker(&mut self, class: &str, y: f64, [low, high]: [f64; 2]) {
        if let (Some((x0, y)), Some((x1, _))) = (self.place(low, y), self.place(high, y)) {
            let bar = |x: f64| format!("M{x:.1} {:.1}v8", y - 4.0);
            let data = format!("M{x0:.1} {y:.1}H{x1:.1}{}{}", bar(x0), bar(x1));
            self.path(&format!("whisker {class}"), &data);
        }
    }

    /// A bar from `low` to `high` around the line `y`, `thickness` of the distance between lines.
    pub fn level_bar(&mut self, class: &str, y: f64, [low, high]: [f64; 2], thickness: f64) {
        let corners = (
            self.place(low, y - 0.5 * thickness),
            self.place(high, y + 0.5 * thickness),
        );
        if let (Some((x0, y0)), Some((x1, y1))) = corners {
            let data = format!("M{x0:.1} {y0:.1}V{y1:.1}H{x1:.1}V{y0:.1}Z");
            self.path(&format!("bar {class}"), &data);
        }
    }

    /// Words beside points, moved up or down where they would hide each other, each with a thin line to its point.
    pub fn labels(&mut self, labels: &[((f64, f64), String)]) {
        let (_, height) = self.inner();
        let mut placed: Vec<(f64, f64, &str)> = labels
            .iter()
            .filter_map(|((x, y), text)| {
                let (x, y) = self.place(*x, *y)?;
                Some((x, y, text.as_str()))
            })
            .collect();
        placed.sort_by(|a, b| a.1.total_cmp(&b.1));
        let mut lines = stacked(placed.iter().map(|p| p.1), height);
        for (x, y, text) in placed {
            let line = lines.pop_front().unwrap_or(y);
            let side = self.side_of_label(x, text);
            let class = match side > 0.0 {
                true => "words",
                false => "words end",
            };
            let [from, to] = [5.0, 15.0].map(|distance| x + side * distance);
            self.path("pointer", &format!("M{from:.1} {y:.1}L{to:.1} {line:.1}"));
            write_text(&mut self.marks, class, to + 2.0 * side, line + 3.5, text);
        }
    }

    /// Names at the upper edge, each on the right of its place on the x axis, in the highest row that has space for it.
    pub fn names_above(&mut self, names: &[(f64, String)]) {
        let (width, _) = self.inner();
        let place = |(x, name): &(f64, String)| Some((self.x.position(*x)? * width, name.clone()));
        let mut placed: Vec<(f64, String)> = names.iter().filter_map(place).collect();
        placed.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut ends = [f64::NEG_INFINITY; ROWS];
        for (x, name) in placed {
            let end = x + 6.0 + CHARACTER * name.chars().count() as f64;
            let least = |a: usize, b: usize| if ends[b] < ends[a] { b } else { a };
            let row =
                (ends.iter().position(|end| *end <= x)).unwrap_or_else(|| (0..ROWS).fold(0, least));
            let (class, from) = match end > width {
                true => ("words end", x - 4.0),
                false => ("words", x + 4.0),
            };
            ends[row] = end;
            let y = 10.0 + LINE * row as f64;
            write_text(&mut self.marks, class, from, y, &name);
        }
    }

    /// 1 where the name of a place stands on its right, -1 on its left: to the right where there is space, but on the other side where
    /// an upright line would run through it.
    fn side_of_label(&self, x: f64, text: &str) -> f64 {
        let (width, _) = self.inner();
        let length = CHARACTER * text.chars().count() as f64;
        let free = |side: f64| {
            let ends = [17.0, 17.0 + length].map(|distance| x + side * distance);
            let [from, to] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
            let struck = self.upright.iter().any(|line| (from..=to).contains(line));
            from >= 0.0 && to <= width && !struck
        };
        let usual = if x < 0.7 * width { 1.0 } else { -1.0 };
        match !free(usual) && free(-usual) {
            true => -usual,
            false => usual,
        }
    }

    /// Words that show while the pointer is between two values of the axis, over the whole height.
    pub fn readout_between(&mut self, ends: [f64; 2], lines: &[String]) {
        let ends = ends.map(|x| self.x.position(x));
        let [Some(from), Some(to)] = ends else { return };
        let (width, height) = self.inner();
        let [from, to] = [from.max(0.0), to.min(1.0)].map(|position| position * width);
        if from < to {
            self.readout([from, to], [0.0, height], lines);
        }
    }

    /// Words that show while the pointer is on a mark.
    pub fn readout_mark(&mut self, point: (f64, f64), lines: &[String]) {
        if let Some((x, y)) = self.place(point.0, point.1) {
            let reach = 0.5 * REACH;
            self.readout([x - reach, x + reach], [y - reach, y + reach], lines);
        }
    }

    /// Words that show while the pointer is on the upright line from `low` to `high` at `x`.
    pub fn readout_upright(&mut self, x: f64, [low, high]: [f64; 2], lines: &[String]) {
        if let (Some((x, top)), Some((_, bottom))) = (self.place(x, high), self.place(x, low)) {
            let reach = 0.5 * REACH;
            self.readout([x - reach, x + reach], [top - reach, bottom + reach], lines);
        }
    }

    /// Words that show while the pointer is on the level line from `low` to `high` at `y`.
    pub fn readout_level(&mut self, y: f64, [low, high]: [f64; 2], lines: &[String]) {
        if let (Some((left, y)), Some((right, _))) = (self.place(low, y), self.place(high, y)) {
            let reach = 0.5 * REACH;
            self.readout([left - reach, right + reach], [y - reach, y + reach], lines);
        }
    }

    /// The pointer's place is an empty rectangle; the style sheet shows its words while the pointer is there.
    fn readout(&mut self, [x0, x1]: [f64; 2], [y0, y1]: [f64; 2], lines: &[String]) {
        let (width, _) = self.inner();
        let (anchor, at) = match 0.5 * (x0 + x1) < 0.5 * width {
            true => ("end", width - 4.0),
            false => ("start", 4.0),
        };
        let _ = write!(
            self.readouts,
            "<g class=\"readout {anchor}\"><path d=\"M{x0:.1} {y0:.1}H{x1:.1}V{y1:.1}H{x0:.1}Z\"/>"
        );
        for (i, line) in lines.iter().enumerate() {
            let y = LINE * (i + 1) as f64;
            write_text(&mut self.readouts, "words", at, y, line);
        }
        self.readouts.push_str("</g>");
    }

    /// A sentence in the middle of the panel, for when there is nothing to draw.
    pub fn note(&mut self, text: &str) {
        self.note = Some(text.to_owned());
    }

    /// The panel as SVG inside a page, with values that show under the pointer.
    pub fn svg(&self) -> String {
        self.picture("", "", &self.readouts)
    }

    /// The panel as a file of its own, in the given style sheet.
    pub fn standalone(&self, style: &str) -> String {
        let attributes = format!(
            " xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\"",
            2.0 * self.width,
            2.0 * self.height
        );
        let ground = "<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>";
        self.picture(&attributes, &format!("<style>{style}</style>{ground}"), "")
    }

    /// Title and axis labels are escaped here.
    fn picture(&self, attributes: &str, start: &str, readouts: &str) -> String {
        let (width, height) = self.inner();
        let left = self.left;
        let mut svg = format!(
            "<svg{attributes} class=\"panel\" viewBox=\"0 0 {:.0} {:.0}\" role=\"img\" aria-label=\"{}: {} over {}\">",
            self.width,
            self.height,
            HtmlEscape(&self.title),
            HtmlEscape(&self.y.label),
            HtmlEscape(&self.x.label)
        );
        svg.push_str(start);
        self.write_axes(&mut svg);
        // The inner picture cuts off what leaves the plot area.
        let _ = write!(
            svg,
            "<svg x=\"{left}\" y=\"{TOP}\" width=\"{width:.0}\" height=\"{height:.0}\">{}{readouts}</svg>",
            self.marks
        );
        let _ = write!(
            svg,
            "<path class=\"frame\" d=\"M{left} {TOP}v{height:.1}h{width:.1}\"/>"
        );
        if let Some(note) = &self.note {
            let (x, y) = (left + width / 2.0, TOP + height / 2.0);
            write_text(&mut svg, "note", x, y, note);
        }
        svg.push_str("</svg>");
        svg
    }

    fn write_axes(&self, svg: &mut String) {
        let (width, height) = self.inner();
        let left = self.left;
        write_text(svg, "title", left.min(LEFT[0]), 15.0, &self.title);
        for (value, label) in self.x.ticks(|c| (c as f64 * CHARACTER + 14.0) / width) {
            if let Some(position) = self.x.position(value) {
                let x = left + position * width;
                let _ = write!(
                    svg,
                    "<path class=\"grid\" d=\"M{x:.1} {TOP}v{height:.1}\"/>"
                );
                write_text(svg, "tick x", x, TOP + height + 15.0, &label);
            }
        }
        for (value, label) in self.y.ticks(|_| TICK_HEIGHT / height) {
            if let Some(position) = self.y.position(value) {
                let y = TOP + (1.0 - position) * height;
                let _ = write!(
                    svg,
                    "<path class=\"grid\" d=\"M{left} {y:.1}h{width:.1}\"/>"
                );
                write_text(svg, "tick y", left - 6.0, y + 3.8, &label);
            }
        }
        let centre = left + width / 2.0;
        write_text(svg, "label", centre, self.height - 8.0, &self.x.label);
        let middle = TOP + height / 2.0;
        let _ = write!(
            svg,
            "<text class=\"label\" transform=\"translate(13 {middle:.1}) rotate(-90)\">{}</text>",
            HtmlEscape(&self.y.label)
        );
    }
}

/// Heights (downwards, ascending) moved apart so that a line of words fits at each, within the picture's height.
fn stacked(heights: impl Iterator<Item = f64>, height: f64) -> VecDeque<f64> {
    let mut lines: VecDeque<f64> = VecDeque::new();
    for wanted in heights {
        let least = lines.back().map_or(LINE, |last| last + LINE);
        lines.push_back(wanted.max(least));
    }
    let mut most = height - 0.5 * LINE;
    for line in lines.iter_mut().rev() {
        *line = line.min(most);
        most = *line - LINE;
    }
    lines
}

fn write_text(svg: &mut String, class: &str, x: f64, y: f64, text: &str) {
    let _ = write!(
        svg,
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>",
        HtmlEscape(text)
    );
}
