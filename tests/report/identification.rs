//! The page of an identification: complete, honest about what is not known, self-contained.

use crate::page_rules::assert_whole;
use crate::synthetic_contact::{identified, spoil, stick};
use microslip::identify::{Identified, page::html};

/// The page, which keeps the rules of all pages.
fn page(found: &Identified) -> String {
    let page = html(found).unwrap();
    assert_whole(&page);
    page
}

/// Seen to fail with `/` where the page writes `&#x2f;`.
#[test]
fn the_first_sentence_is_the_answer() {
    let page = page(&identified(6));
    let answer = "A further contact of this kind has a friction coefficient of 0.600 (median; 0.482 to 0.748 with 95 % probability) and \
                  a tangential stiffness of 35.0 N&#x2f;µm (20.2 to 60.7), from 6 tests. Its normal stiffness is not bounded";
    assert!(
        page.contains(answer),
        "{}",
        &page[page.find("<h2>").unwrap()..][..900]
    );
}

/// What failed is counted and named, and what nothing bounds is said. Seen to fail with the lower bound left out of the answer.
#[test]
fn what_is_not_known_is_said() {
    let mut found = identified(3);
    found.tests.iter_mut().for_each(stick);
    spoil(&mut found.tests[1], "3 whole cycles, and 5 are needed");
    let pooled = found.pooled.as_mut().unwrap();
    pooled.parameters.remove(0);
    pooled.friction_at_least = Some(0.43);
    let page = page(&found);
    assert!(
        page.contains("friction coefficient is 0.430 at least"),
        "no lower bound"
    );
    assert!(page.contains("<dd>2 of 3</dd>"), "tests are not counted");
    assert!(
        page.contains("does not slip as a whole"),
        "no word in the table"
    );
    assert!(
        page.contains("no cycle has a value</text>"),
        "an empty panel is not marked"
    );
}

/// A loop has the lines through its stick branches, after both reversals, as far as it has them; the legend has one, too.
#[test]
fn fitted_branches_are_drawn() {
    let mut found = identified(1);
    let branches = |found: &Identified| page(found).split("class=\"line stuck\" d=\"").count() - 1;
    let both = branches(&found);
    let figure = found.tests[0].figure.as_mut().unwrap();
    figure.stick_lines[1] = None;
    assert_eq!((both, branches(&found)), (3, 2));
}
