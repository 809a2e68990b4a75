//! Pages in a real browser: every figure is drawn, nothing leaves the window, no label is cut.
//!
//! Needs Chromium: `CHROMIUM`, or a usual name in `PATH`. Without one the tests say so and pass, unless
//! `MICROSLIP_REQUIRE_BROWSER=1`.
#![expect(
    clippy::unwrap_used,
    reason = "a test that cannot run its browser fails"
)]

#[path = "../report/synthetic.rs"]
#[expect(dead_code, reason = "shared with the tests of the report")]
mod synthetic;

mod calibration;
mod disk;
#[path = "../common/function_case.rs"]
mod function_case;
mod identification;
#[path = "../report/synthetic_contact.rs"]
mod synthetic_contact;

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;
use synthetic::SyntheticStudy;

const NAMES: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "google-chrome-stable",
];
/// Width of the text on A4 with the margins of the page, in pixels.
const PAPER: u32 = 680;

/// The browser, or `None` with a message where its absence is allowed.
fn browser() -> Option<PathBuf> {
    let named = std::env::var_os("CHROMIUM").map(PathBuf::from);
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let usual = NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    let found = named.into_iter().chain(usual).find(|path| path.is_file());
    if found.is_none() {
        let required = std::env::var("MICROSLIP_REQUIRE_BROWSER").is_ok_and(|v| v == "1");
        assert!(!required, "no Chromium, although a browser is required");
        eprintln!("SKIPPED: no Chromium found; set CHROMIUM to its path");
    }
    found
}

fn chromium(browser: &Path, profile: &Path, arguments: &[String]) -> Vec<u8> {
    let output = Command::new(browser)
        .args([
            "--headless",
            "--no-sandbox",
            "--disable-gpu",
            "--hide-scrollbars",
        ])
        .args(["--no-first-run", "--disable-extensions", "--timeout=30000"])
        .arg(format!("--user-data-dir={}", profile.display()))
        .args(arguments)
        .output()
        .unwrap();
    assert!(
        output.status.success(),
        "{}",
        String::from_utf8_lossy(&output.stderr)
    );
    output.stdout
}

/// The page of a study.
fn page(study: &mut SyntheticStudy) -> String {
    let folder = tempfile::tempdir().unwrap();
    study.store(folder.path());
    microslip::report::render(folder.path()).unwrap();
    std::fs::read_to_string(folder.path().join("report.html")).unwrap()
}

/// What `measure.js` finds in the page in a window of the given width.
fn measure(browser: &Path, page: &str, width: u32) -> Value {
    let folder = tempfile::tempdir().unwrap();
    let script = include_str!("measure.js");
    let measured = page.replace("</body>", &format!("<script>{script}</script></body>"));
    std::fs::write(folder.path().join("page.html"), measured).unwrap();
    // A window may have a least width, a frame has none.
    let frame = format!(
        "<body><script>onmessage = (e) => {{ document.body.textContent = `MEASURED${{e.data}}DERUSAEM` }}</script>\
         <iframe src=\"page.html\" style=\"width: {width}px; height: 1000px; border: 0\"></iframe></body>"
    );
    let file = folder.path().join("frame.html");
    std::fs::write(&file, frame).unwrap();
    let arguments = [
        "--window-size=1400,1100".to_owned(),
        "--virtual-time-budget=20000".to_owned(),
        "--dump-dom".to_owned(),
        format!("file://{}", file.display()),
    ];
    let dom = chromium(browser, &folder.path().join("profile"), &arguments);
    let dom = String::from_utf8(dom).unwrap();
    let start = dom.rfind("MEASURED").unwrap() + "MEASURED".len();
    let end = start + dom[start..].find("DERUSAEM").unwrap();
    serde_json::from_str(&dom[start..end]).unwrap()
}

/// Nothing is empty, cut, overlapping, struck through or outside of the window, and letters are as large in one figure as in another.
fn assert_sound(found: &Value, width: u32, figures: usize, what: &str) {
    assert_eq!(
        found["width"], width,
        "{what}: the window has another width"
    );
    assert_eq!(found["figures"], figures, "{what}: figures");
    for fault in ["empty", "outside", "cut", "overlapping", "struck"] {
        let list = found[fault].as_array().unwrap();
        let shown: Vec<_> = list.iter().take(10).collect();
        assert!(list.is_empty(), "{what}: {fault}: {shown:?}");
    }
    let letters = found["letters"].as_array().unwrap().iter();
    let heights: Vec<f64> = letters.map(|height| height.as_f64().unwrap()).collect();
    let smallest = heights.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = heights.iter().copied().fold(0.0, f64::max);
    assert!(
        largest <= 1.25 * smallest,
        "{what}: letters of figures from {smallest:.1} to {largest:.1} px"
    );
}

/// The page as it is on paper: print rules for all media, in a window as wide as the text.
fn on_paper(page: &str) -> String {
    assert!(page.contains("@media print"), "no rules for print");
    page.replace("@media print", "@media all")
}

/// Seen to fail with `.row` as wide as 1300 px, without the right margin of a panel (ticks cut), with the marks left out of
/// the panels, with the last column of the error budget on one line, with figures that fill whatever column they are in (letters
/// from 8.6 to 11.9 px), and with the name of an engine order on a speed that is held.
#[test]
fn every_figure_is_drawn_and_nothing_overflows() {
    let Some(browser) = browser() else { return };
    let page = page(&mut SyntheticStudy::new(100));
    let figures = page.matches("<figure>").count();
    assert!(figures > 40, "{figures} figures");
    for width in [360, 768, 1024, 1280, 1920] {
        let found = measure(&browser, &page, width);
        assert_sound(&found, width, figures, &format!("{width} px"));
        // The last column of the error budget is a sentence: it wraps where the window is wide enough for the table.
        let scrolling = found["scrolling"].as_array().unwrap();
        let budget = scrolling
            .iter()
            .any(|name| name == "Largest error of any level");
        assert!(
            !budget || width < 700,
            "{width} px: the error budget is cut"
        );
    }
    let found = measure(&browser, &on_paper(&page), PAPER);
    assert_sound(&found, PAPER, figures, "print");
}

/// Long names of levels and inputs, few samples, failed levels.
#[test]
fn awkward_studies_are_drawn_too() {
    let Some(browser) = browser() else { return };
    let mut study = SyntheticStudy::new(24);
    study.record.inputs[0].name = "tangential_stiffness_scale".to_owned();
    study.record.level_unit = "units of the harmonic force".to_owned();
    study.fail_level(2);
    let page = page(&mut study);
    let figures = page.matches("<figure>").count();
    for width in [360, 700, 1280] {
        let found = measure(&browser, &page, width);
        assert_sound(&found, width, figures, &format!("{width} px"));
    }
}

/// Figures of two levels have the letters of eight, too. Seen to fail with figures that fill whatever column they are in.
#[test]
fn two_levels_are_drawn_like_eight() {
    let Some(browser) = browser() else { return };
    let mut study = SyntheticStudy::new(60);
    study.record.levels.truncate(2);
    let criteria = &mut study.record.requirements.criteria;
    criteria.retain(|criterion| criterion.level.is_none());
    for outcome in study.outcomes.iter_mut().chain(&mut study.record.nominal) {
        outcome.levels = outcome.levels.iter().take(2).cloned().collect();
    }
    let page = page(&mut study);
    let figures = page.matches("<figure>").count();
    for width in [360, 700, 1280] {
        let found = measure(&browser, &page, width);
        assert_sound(&found, width, figures, &format!("{width} px"));
    }
}

/// The browser prints it, and a download is the figure itself. Seen to fail with the style sheet left out of the SVG.
#[test]
fn it_prints_and_figures_stand_alone() {
    let Some(browser) = browser() else { return };
    let page = page(&mut SyntheticStudy::new(40));
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("report.html");
    std::fs::write(&file, &page).unwrap();
    let pdf = folder.path().join("report.pdf");
    let arguments = [
        "--no-pdf-header-footer".to_owned(),
        format!("--print-to-pdf={}", pdf.display()),
        format!("file://{}", file.display()),
    ];
    chromium(&browser, &folder.path().join("print"), &arguments);
    assert!(std::fs::read(&pdf).unwrap().starts_with(b"%PDF"));
    let start = page.find("data:image/svg+xml,").unwrap();
    let link = &page[start..start + page[start..].find('"').unwrap()];
    let script = format!(
        "<body><img src=\"{link}\"><script>onload = () => {{ const i = document.images[0]; \
         const styled = decodeURIComponent(i.src).includes('.panel text') ? ' styled' : ''; \
         document.title = i.naturalWidth + 'x' + i.naturalHeight + styled }}</script></body>"
    );
    let file = folder.path().join("figure.html");
    std::fs::write(&file, script).unwrap();
    let arguments = [
        "--dump-dom".to_owned(),
        format!("file://{}", file.display()),
    ];
    let dom = chromium(&browser, &folder.path().join("figure"), &arguments);
    let dom = String::from_utf8(dom).unwrap();
    let title = dom.split("<title>").nth(1).unwrap();
    let title = title.split("</title>").next().unwrap();
    assert_eq!(title, "860x548 styled");
}
