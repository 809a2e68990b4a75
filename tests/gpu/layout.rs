//! Do host and shaders agree on the layout, and is every text valid? Needs no adapter.

use crate::states::located;
use microslip::aft::gpu::{Precision, Reflection, Shape};
use microslip::harmonics::HarmonicSet;

#[test]
fn texts_are_valid() {
    for precision in [Precision::F32, Precision::F64] {
        for h in [1, 3, 5, 7, 9, 13, 21] {
            for n_time in [64, 128, 256] {
                let set = HarmonicSet::up_to(h);
                if n_time <= 4 * h {
                    continue;
                }
                let Some(shape) = Shape::of(&located::<f64>(&set, n_time), precision) else {
                    eprintln!("none {h} {n_time}");
                    continue;
                };
                Reflection::of(&shape.text()).unwrap_or_else(|e| panic!("H = {h}: {e}"));
            }
        }
    }
}
