#![allow(missing_docs, clippy::all)]
use std::cell::RefCell;
use std::time::Instant;
#[derive(Default, Clone, Debug)]
pub struct Stats {
    pub compliance: (usize, f64),
    pub contact: (usize, f64),
    pub jacobian: (usize, f64),
    pub solve: (usize, f64),
    pub trials: usize,
    pub rejects: usize,
    pub total: f64,
}
thread_local! {
    pub static STAGE: RefCell<usize> = const { RefCell::new(0) };
    pub static ALL: RefCell<Vec<Stats>> = RefCell::new(vec![Stats::default(); 10]);
    pub static LOG: RefCell<String> = const { RefCell::new(String::new()) };
    static SINCE: RefCell<Option<Instant>> = const { RefCell::new(None) };
}
pub fn stage(s: usize) -> usize {
    let old = STAGE.with(|x| std::mem::replace(&mut *x.borrow_mut(), s));
    let now = Instant::now();
    let before = SINCE.with(|x| x.borrow_mut().replace(now));
    if let Some(b) = before {
        with_at(old, |st| st.total += (now - b).as_secs_f64());
    }
    old
}
fn with_at(s: usize, f: impl FnOnce(&mut Stats)) {
    ALL.with(|a| f(&mut a.borrow_mut()[s]));
}
pub fn with(f: impl FnOnce(&mut Stats)) {
    with_at(STAGE.with(|x| *x.borrow()), f);
}
pub fn timed<T>(slot: fn(&mut Stats) -> &mut (usize, f64), f: impl FnOnce() -> T) -> T {
    let t = Instant::now();
    let v = f();
    let e = t.elapsed().as_secs_f64();
    with(|s| {
        let x = slot(s);
        x.0 += 1;
        x.1 += e;
    });
    v
}
pub fn log(s: String) {
    LOG.with(|l| l.borrow_mut().push_str(&s));
}
pub fn take() -> (Vec<Stats>, String) {
    stage(0);
    (
        ALL.with(|a| std::mem::replace(&mut *a.borrow_mut(), vec![Stats::default(); 10])),
        LOG.with(|l| std::mem::take(&mut *l.borrow_mut())),
    )
}
pub fn env(name: &str, default: f64) -> f64 {
    use std::collections::HashMap;
    use std::sync::{Mutex, OnceLock};
    static M: OnceLock<Mutex<HashMap<String, f64>>> = OnceLock::new();
    let mut m = M.get_or_init(Default::default).lock().unwrap();
    *m.entry(name.to_owned()).or_insert_with(|| {
        std::env::var(name).ok().and_then(|s| s.parse().ok()).unwrap_or(default)
    })
}
