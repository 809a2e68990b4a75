//! Rules that every page keeps.

/// The page shows no number that is none, and needs nothing from elsewhere.
pub(crate) fn assert_whole(page: &str) {
    for forbidden in [
        "NaN",
        ">inf",
        "-inf",
        "−inf",
        "None",
        "none<",
        "null",
        ">undefined",
    ] {
        assert!(!page.contains(forbidden), "the page shows {forbidden}");
    }
    for external in [
        "http:", "https:", "src=", "url(", "@import", "<link", "<script",
    ] {
        assert!(!page.contains(external), "the page refers to {external}");
    }
}
