//! The page of an identification in a real browser.

use crate::synthetic_contact::{identified, spoil, stick};
use crate::{PAPER, assert_sound, browser, measure, on_paper};
use microslip::identify::page::html;

/// Widths of a telephone, a small and a large window, in pixels.
const WIDTHS: [u32; 3] = [390, 1024, 1920];

/// Seen to fail with ticks of 30 px: labels are cut.
#[test]
fn loops_are_drawn_and_nothing_overflows() {
    let Some(browser) = browser() else { return };
    let page = html(&identified(9)).unwrap();
    let figures = page.matches("<figure>").count();
    // six tests with six figures each, two parameters, and both together
    assert_eq!(figures, 39, "figures of the page");
    for width in WIDTHS {
        let found = measure(&browser, &page, width);
        assert_sound(&found, width, figures, &format!("{width} px"));
    }
    let found = measure(&browser, &on_paper(&page), PAPER);
    assert_sound(&found, PAPER, figures, "print");
}

/// Long names, a test that never slips and one that is not used, one test alone. Seen to fail with paragraphs of 3000 px.
#[test]
fn awkward_tests_are_drawn_too() {
    let Some(browser) = browser() else { return };
    let mut found = identified(4);
    found.tests[0].name = "a-file-with-a-very-long-name-of-a-test-rig_2026-11-23_0001".to_owned();
    found.tests[0].conditions.specimen = found.tests[0].name.clone().into();
    stick(&mut found.tests[1]);
    spoil(&mut found.tests[2], "the displacement does not turn");
    for found in [found, identified(1), identified(0)] {
        let page = html(&found).unwrap();
        let figures = page.matches("<figure>").count();
        for width in WIDTHS {
            let measured = measure(&browser, &page, width);
            let what = format!("{} tests at {width} px", found.tests.len());
            assert_sound(&measured, width, figures, &what);
        }
    }
}
