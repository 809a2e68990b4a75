#![allow(dead_code, clippy::unwrap_used, missing_docs)]
#[path = "../tests/report/synthetic.rs"]
mod synthetic;
fn main() {
    let mut a = std::env::args().skip(1);
    let folder = std::path::PathBuf::from(a.next().unwrap());
    std::fs::create_dir_all(&folder).unwrap();
    let mut study = synthetic::SyntheticStudy::new(a.next().unwrap().parse().unwrap());
    study.store(&folder);
    microslip::report::render(&folder).unwrap();
}
