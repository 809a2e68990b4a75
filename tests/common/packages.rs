//! Packages below `src`.

use std::path::Path;

/// `hb/peak/track.rs` for `src/solver/hb/peak/track.rs`: the path below the package.
pub(crate) fn below_package(file: &Path) -> &Path {
    let path = file.strip_prefix("src").unwrap();
    let first = path.iter().next().unwrap();
    match Path::new("src").join(first).join("Cargo.toml").exists() {
        true => path.strip_prefix(first).unwrap(),
        false => path,
    }
}
