//! The page of a calibration in a real browser.

use crate::function_case::case;
use crate::{PAPER, assert_sound, browser, measure, on_paper};
use microslip::calibrate::page::html;
use microslip::calibrate::{CalibrationSettings, calibrate};
use microslip::study::Study;

/// Widths of a telephone, a small and a large window, in pixels.
const WIDTHS: [u32; 3] = [390, 1024, 1920];

/// Also with a measurement that the prior cannot give, and its warnings. Seen to fail with 200 draws, whose warnings are not expected.
#[test]
fn posteriors_are_drawn_and_nothing_overflows() {
    let Some(browser) = browser() else { return };
    for beyond in [false, true] {
        let folder = case();
        let response = folder.path().join("response.csv");
        if beyond {
            let text = std::fs::read_to_string(&response).unwrap();
            std::fs::write(
                &response,
                text.replace(",69", ",169").replace(",70", ",170"),
            )
            .unwrap();
        }
        let study = Study::read(&folder.path().join("study.toml")).unwrap();
        let settings = CalibrationSettings::default();
        let found = calibrate(study, &response, &settings, |_| {}).unwrap();
        assert_eq!(
            !found.summary.warnings.is_empty(),
            beyond,
            "{:?}",
            found.summary.warnings
        );
        let page = html(&found).unwrap();
        let figures = page.matches("<figure>").count();
        assert!(figures > 4, "{figures} figures");
        for width in WIDTHS {
            let measured = measure(&browser, &page, width);
            let what = format!("{width} px, beyond the prior: {beyond}");
            assert_sound(&measured, width, figures, &what);
        }
        let measured = measure(&browser, &on_paper(&page), PAPER);
        assert_sound(&measured, PAPER, figures, "print");
    }
}
