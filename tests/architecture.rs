//! Imports follow the module table of ARCHITECTURE.md, and no source file or function outgrows its limit.
#![allow(
    clippy::unwrap_used,
    reason = "a test that cannot read the sources fails"
)]

#[path = "common/packages.rs"]
mod packages;

use packages::below_package;
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Most lines of a source file.
const LONGEST_FILE: usize = 500;
/// Most lines of a function, from `fn` to the brace that closes it.
const LONGEST_FUNCTION: usize = 60;
/// Files that declare the modules; they import none.
const ROOTS: [&str; 2] = ["lib", "main"];

/// Rows of the table of ARCHITECTURE.md whose first column is called `first`; cell 1 of a row is its first.
fn rows(first: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string("ARCHITECTURE.md").unwrap();
    let table = text.split(&format!("\n| {first} |")).nth(1).unwrap();
    let rows = table
        .lines()
        .skip(2)
        .take_while(|line| line.starts_with('|'));
    rows.map(|row| row.split('|').map(|cell| cell.trim().to_owned()).collect())
        .collect()
}

fn words(cell: &str) -> BTreeSet<String> {
    let words = cell.split(',').map(|word| word.trim().to_owned());
    words.filter(|word| !word.is_empty()).collect()
}

/// Module → modules that it may import, from the table under `## Modules`.
fn module_table() -> BTreeMap<String, BTreeSet<String>> {
    let rows = rows("module | purpose").into_iter();
    rows.map(|cells| (cells[1].clone(), words(&cells[3])))
        .collect()
}

fn source_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files.extend(source_files(&path));
        } else if path.extension().is_some_and(|e| e == "rs" || e == "wgsl") {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// The module of a file: the first folder or file name below the package.
fn module_of(file: &Path) -> String {
    let first = below_package(file).iter().next().unwrap();
    first.to_str().unwrap().trim_end_matches(".rs").to_owned()
}

fn without_comments(text: &str) -> String {
    let lines = text.lines();
    let code = lines.map(|line| line.split("//").next().unwrap_or_default());
    code.collect::<Vec<_>>().join("\n")
}

/// Modules that a text names after `crate::` or `microslip::`, groups in braces included; comments do not count.
fn imported_modules(text: &str) -> BTreeSet<String> {
    let code = without_comments(text);
    let mut modules = BTreeSet::new();
    for root in ["crate::", "microslip::"] {
        for (at, _) in code.match_indices(root) {
            let rest = &code[at + root.len()..];
            match rest.strip_prefix('{') {
                Some(group) => {
                    modules.extend(group_members(group).iter().filter_map(|m| first_word(m)));
                }
                None => modules.extend(first_word(rest)),
            }
        }
    }
    // `crate::Error` is the module `error`, re-exported.
    if modules.remove("Error") {
        modules.insert("error".to_owned());
    }
    modules
}

/// Members of `a::b, c::{d, e}, f}`, up to the brace that closes the group.
fn group_members(group: &str) -> Vec<String> {
    let (mut depth, mut member, mut members) = (0, String::new(), Vec::new());
    for c in group.chars() {
        match c {
            '}' if depth == 0 => break,
            ',' if depth == 0 => members.push(std::mem::take(&mut member)),
            _ => {
                depth += i32::from(c == '{') - i32::from(c == '}');
                member.push(c);
            }
        }
    }
    members.push(member);
    members.iter().map(|m| m.trim().to_owned()).collect()
}

fn first_word(text: &str) -> Option<String> {
    let word: String = text
        .chars()
        .take_while(|c| c.is_alphanumeric() || *c == '_')
        .collect();
    (!word.is_empty()).then_some(word)
}

/// Seen to fail with `use crate::hb::Status;` in `src/solver/contact/mod.rs`, with the row of `report` taken out, and with permissions that
/// no file uses.
#[test]
fn imports_follow_the_module_table() {
    let table = module_table();
    let mut broken = Vec::new();
    let mut seen: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in source_files(Path::new("src")) {
        let module = module_of(&file);
        if ROOTS.contains(&module.as_str()) {
            continue;
        }
        let Some(allowed) = table.get(&module) else {
            broken.push(format!(
                "{}: module {module} is not in the table",
                file.display()
            ));
            continue;
        };
        let imports = imported_modules(&std::fs::read_to_string(&file).unwrap());
        for import in imports.difference(allowed).filter(|i| **i != module) {
            broken.push(format!(
                "{}: {module} may not import {import}",
                file.display()
            ));
        }
        seen.entry(module).or_default().extend(imports);
    }
    for (module, allowed) in &table {
        let Some(imports) = seen.get(module) else {
            broken.push(format!("ARCHITECTURE.md: module {module} does not exist"));
            continue;
        };
        for unused in allowed.difference(imports) {
            broken.push(format!(
                "ARCHITECTURE.md: {module} does not import {unused}"
            ));
        }
    }
    assert!(broken.is_empty(), "\n{}", broken.join("\n"));
}

/// Seen to fail with `model` left out of the row of the solver.
#[test]
fn packages_hold_the_modules_that_their_rows_name() {
    let rows = rows("package");
    assert!(rows.len() > 2, "the table has {} rows", rows.len());
    for cells in rows {
        let folder = cells[2].trim_matches('`');
        if folder == "src" {
            continue;
        }
        let modules = source_files(Path::new(folder))
            .iter()
            .map(|f| module_of(f))
            .collect::<BTreeSet<_>>();
        let modules: BTreeSet<_> = modules
            .into_iter()
            .filter(|module| module != "lib")
            .collect();
        let named = words(cells[3].split(':').next().unwrap());
        assert_eq!(modules, named, "{}", cells[1]);
    }
}

/// Modules depend on each other in one direction only.
#[test]
fn the_module_table_has_no_cycle() {
    let mut table = module_table();
    while !table.is_empty() {
        let floor: Vec<_> = table
            .iter()
            .filter(|(_, imports)| imports.iter().all(|module| !table.contains_key(module)))
            .map(|(module, _)| module.clone())
            .collect();
        assert!(!floor.is_empty(), "a cycle among {:?}", table.keys());
        for module in floor {
            table.remove(&module);
        }
    }
}

/// `hb::peak::track` for `src/solver/hb/peak/track.rs`; none for a file that declares a folder or a package.
fn path_of(file: &Path) -> Option<String> {
    let path = below_package(file).with_extension("");
    let names: Vec<_> = path.iter().map(|name| name.to_str().unwrap()).collect();
    let declares = names == ["lib"] || names.last() == Some(&"mod");
    (!declares).then(|| names.join("::"))
}

/// The path that a text begins with, groups in braces expanded.
fn paths(text: &str) -> Vec<String> {
    let part_of_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let end = text.find(|c| !part_of_path(c)).unwrap_or(text.len());
    let (head, rest) = text.split_at(end);
    match rest.strip_prefix('{') {
        None => vec![head.to_owned()],
        Some(group) => (group_members(group).iter())
            .flat_map(|member| paths(member))
            .map(|path| format!("{head}{path}"))
            .collect(),
    }
}

/// Absolute paths that the code of `module` names by `crate` or `super`; its tests do not count.
fn named_paths(module: &str, text: &str) -> Vec<String> {
    let code = without_comments(text.split("#[cfg(test)]").next().unwrap());
    let after = |root: &'static str| {
        let starts = code.match_indices(root).map(|(at, _)| at);
        let whole = starts.filter(|&at| root == "crate::" || !code[..at].ends_with("super::"));
        let whole: Vec<_> = whole.collect();
        (whole.into_iter()).flat_map(|at| paths(&code[at + root.len()..]))
    };
    let relative = after("super::").map(|path| {
        let (mut above, mut rest) = (parent(module), path.as_str());
        while let Some(further) = rest.strip_prefix("super::") {
            (above, rest) = (parent(above), further);
        }
        format!("{above}::{rest}")
    });
    after("crate::").chain(relative).collect()
}

fn parent(module: &str) -> &str {
    module.rsplit_once("::").map_or("", |(parent, _)| parent)
}

/// Where two modules part: `hb::peak` and `hb::newton` for `hb::peak::track` and `hb::newton::solve`. A file and what is in
/// the folder of its name part nowhere.
fn siblings(a: &str, b: &str) -> (String, String) {
    let names = |path: &str| path.split("::").map(str::to_owned).collect::<Vec<_>>();
    let (of_a, of_b) = (names(a), names(b));
    match of_a.iter().zip(&of_b).position(|(a, b)| a != b) {
        Some(last) => (of_a[..=last].join("::"), of_b[..=last].join("::")),
        None => (a.to_owned(), b.to_owned()),
    }
}

/// What a file that declares a folder re-exports, by the path under which others name it: where it stands.
fn re_exports(file: &Path) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(file).unwrap();
    let code = without_comments(text.split("#[cfg(test)]").next().unwrap());
    let names = below_package(file);
    let names: Vec<_> = names.iter().map(|name| name.to_str().unwrap()).collect();
    let module = names[..names.len() - 1].join("::");
    let uses = code.split("use ").skip(1);
    let of_module = uses.flat_map(paths).filter_map(|path| {
        let name = path.rsplit("::").next()?.to_owned();
        let place = match path.strip_prefix("crate::") {
            Some(absolute) => absolute.to_owned(),
            None => format!("{module}::{path}"),
        };
        Some((format!("{module}::{name}"), place))
    });
    of_module.collect()
}

/// Where the item of a path stands, re-exports followed.
fn place_of(path: &str, re_exports: &BTreeMap<String, String>) -> String {
    let mut place = path.to_owned();
    // one folder re-exports from the next below it
    while let Some(further) = re_exports.get(&place).filter(|further| **further != place) {
        place.clone_from(further);
    }
    place
}

/// The files and folders of a folder stand in an order in which each imports only those before it. A file that declares a
/// folder does not count: what it re-exports is imported from where it stands.
///
/// Seen to fail with the struct `Ensemble` in `src/samples/ensemble/runner.rs`, which imports others that name it by its folder, with `use crate::hb::{peak::{maxima::Maxima, track::track_mode}, Status};` in `src/solver/hb/newton/rest.rs`, with
/// `use super::track::track_mode;` in `src/solver/hb/peak/maxima.rs`, and, where only folders make the circle, with
/// `use crate::report::page::view::View;` in `src/report/numbers/summary.rs`.
#[test]
fn files_do_not_import_each_other_in_circles() {
    let (mut texts, mut moved) = (BTreeMap::new(), BTreeMap::new());
    for file in source_files(Path::new("src")) {
        match path_of(&file) {
            Some(module) => drop(texts.insert(module, std::fs::read_to_string(&file).unwrap())),
            None => moved.extend(re_exports(&file)),
        }
    }
    let known = |path: &str| {
        let longer = std::iter::successors(Some(path), |path| Some(parent(path)));
        let mut longer = longer.take_while(|path| !path.is_empty());
        longer
            .find(|path| texts.contains_key(*path))
            .map(str::to_owned)
    };
    let imports = |(module, text): (&String, &String)| {
        let named = named_paths(module, text);
        let places = named.iter().map(|path| place_of(path, &moved));
        let others = places.filter_map(|place| known(&place));
        let others: BTreeSet<String> = others.filter(|other| other != module).collect();
        (module.clone(), others)
    };
    let imports: BTreeMap<String, BTreeSet<String>> = texts.iter().map(imports).collect();
    assert!(imports.values().map(BTreeSet::len).sum::<usize>() > 300);
    let mut open: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (module, others) in &imports {
        for (from, to) in others.iter().map(|other| siblings(module, other)) {
            open.entry(from).or_default().insert(to);
        }
    }
    loop {
        let free = |imports: &BTreeSet<String>| imports.iter().all(|i| !open.contains_key(i));
        let floor: Vec<_> = (open.iter().filter(|(_, imports)| free(imports)))
            .map(|(module, _)| module.clone())
            .collect();
        if floor.is_empty() {
            break;
        }
        for module in floor {
            open.remove(&module);
        }
    }
    assert!(open.is_empty(), "circles among {open:#?}");
}

/// Seen to fail with a shader of 861 lines and with a benchmark of 692.
#[test]
fn no_source_file_is_too_long() {
    let mut long = Vec::new();
    for folder in ["src", "tests", "benches", "shaders"] {
        for file in source_files(Path::new(folder)) {
            let lines = std::fs::read_to_string(&file).unwrap().lines().count();
            if lines > LONGEST_FILE {
                long.push(format!("{}: {lines} lines", file.display()));
            }
        }
    }
    assert!(long.is_empty(), "\n{}", long.join("\n"));
}

/// Name and length of each function of a formatted text: it ends at the first brace that stands as far to the right as `fn`'s
/// line. A declaration without a body has no length.
fn function_lengths(text: &str) -> Vec<(String, usize)> {
    let indent = |line: &str| line.len() - line.trim_start().len();
    let lines: Vec<&str> = text.lines().collect();
    let starts = (0..lines.len()).filter_map(|at| Some((at, function_name(lines[at])?)));
    let measured = starts.filter(|(at, _)| !lines[*at].ends_with([';', '}']));
    let length = |(at, name): (usize, String)| {
        let depth = indent(lines[at]);
        let mut rest = (lines[at + 1..].iter()).filter(|line| !line.is_empty());
        let end =
            rest.find(|line| indent(line) == depth && (line.trim() == "}" || line.ends_with(';')))?;
        let body = end.trim() == "}";
        // both are parts of the same text
        let last = lines.iter().position(|line| std::ptr::eq(line, end))?;
        body.then(|| (name, last - at + 1))
    };
    measured.filter_map(length).collect()
}

/// Name of the function that a line declares.
fn function_name(line: &str) -> Option<String> {
    let (before, after) = line.split_once("fn ")?;
    let word = |word: &str| {
        let word = word.trim_end_matches(['(', ')']);
        word.starts_with("pub")
            || ["const", "async", "unsafe", "in"].contains(&word)
            || word.starts_with("crate")
    };
    let declares = before.split_whitespace().all(word);
    declares.then(|| first_word(after)).flatten()
}

/// Seen to fail with a benchmark's function of 79 lines and with a shader's of 83.
#[test]
fn no_function_is_too_long() {
    let mut long = Vec::new();
    for folder in ["src", "tests", "benches", "shaders"] {
        for file in source_files(Path::new(folder)) {
            let lengths = function_lengths(&std::fs::read_to_string(&file).unwrap());
            for (name, lines) in lengths.into_iter().filter(|(_, n)| *n > LONGEST_FUNCTION) {
                long.push(format!("{}: {name} has {lines} lines", file.display()));
            }
        }
    }
    assert!(long.is_empty(), "\n{}", long.join("\n"));
}

#[test]
fn lengths_are_those_from_the_name_to_the_closing_brace() {
    let text = "pub(in crate::aft) const fn a(\n    x: T,\n) -> T {\n    x\n}\ntrait B {\n    fn c(\n        &self,\n    );\n    fn d() {\n\n        e();\n    }\n}\n// a fn f that is none {\nfn g() {}\n";
    let found = function_lengths(text);
    assert_eq!(found, [("a".to_owned(), 5), ("d".to_owned(), 4)]);
}

#[test]
fn imports_are_found_wherever_they_stand() {
    let text = "use crate::hb::{Status};\nuse crate::{aft, contact::{a, b}, Error};\nlet x = crate::fe::y(); // crate::no\n";
    let found = imported_modules(text);
    let expected = ["aft", "contact", "error", "fe", "hb"].map(str::to_owned);
    assert_eq!(found, BTreeSet::from(expected));
}

/// Functions of the C library: their last bits depend on the instruction set.
const INEXACT: [&str; 19] = [
    "sin", "cos", "tan", "sin_cos", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "exp",
    "exp_m1", "ln", "ln_1p", "log10", "powf", "hypot", "cbrt",
];
/// Modules whose numbers decide a sample.
const DECIDING: [&str; 11] = [
    "harmonics",
    "linalg",
    "contact",
    "fe",
    "model",
    "aft",
    "hb",
    "sampling",
    "special",
    "units",
    "setting",
];

/// What decides a sample takes such functions from the crate `libm`. Tests and shaders do not count.
///
/// Seen to fail with `f64::sin_cos` in `HarmonicSet::basis`.
#[test]
fn samples_do_not_depend_on_the_c_library() {
    let mut found = Vec::new();
    for file in source_files(Path::new("src")) {
        if !DECIDING.contains(&module_of(&file).as_str()) {
            continue;
        }
        let text = std::fs::read_to_string(&file).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        for (line, text) in (1..).zip(code.lines()) {
            let text = text.split("//").next().unwrap();
            let call = |name: &&&str| text.contains(&format!(".{name}("));
            if let Some(name) = INEXACT.iter().find(call) {
                found.push(format!("{}:{line}: {name}", file.display()));
            }
        }
    }
    assert!(found.is_empty(), "{found:#?}");
}
