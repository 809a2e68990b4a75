//! Do host and shaders agree on the layout, and is every text valid? Needs no adapter.

use crate::states::{located, plan};
use microslip::contact::{Events, FrictionLaw};
use microslip::gpu::{Access, Precision, Reflection, ShaderKey};
use microslip::harmonics::HarmonicSet;

const PRECISIONS: [(Precision, u64); 2] = [(Precision::F32, 4), (Precision::F64, 8)];

/// Blocks of a derivative and passes per law.
const LAWS: [(FrictionLaw, Events, u64, usize); 4] = [
    (FrictionLaw::Box, Events::Located, 5, 5),
    (FrictionLaw::Circle, Events::Located, 7, 7),
    (FrictionLaw::Circle, Events::Interpolated, 7, 4),
    (FrictionLaw::Circle, Events::Sampled, 7, 4),
];

/// Sets that ladder, default study and alert use, with the time points that come with them.
fn shapes(precision: Precision, (law, events): (FrictionLaw, Events)) -> Vec<ShaderKey> {
    let mut shapes = Vec::new();
    for h in [1, 2, 3, 5, 7, 8, 9, 13, 21] {
        for n_time in [64, 128, 256] {
            let set = HarmonicSet::up_to(h);
            if n_time > 4 * h {
                let shape = ShaderKey::of(&plan::<f64>(&set, n_time, law, events), precision);
                shapes.push(shape.unwrap_or_else(|| panic!("H = {h}, Nt = {n_time}: no shader")));
            }
        }
    }
    let odd = HarmonicSet::new(vec![0, 1, 3, 5]).unwrap();
    shapes.extend(ShaderKey::of(
        &plan::<f64>(&odd, 64, law, events),
        precision,
    ));
    shapes
}

/// Seen to fail with: the root of a constant in double precision, which naga refuses.
#[test]
fn every_text_is_valid() {
    for (precision, _) in PRECISIONS {
        for (law, events, ..) in LAWS {
            for shape in shapes(precision, (law, events)) {
                for hardware in [false, true] {
                    if let Err(error) = Reflection::of(&shape.text(hardware)) {
                        panic!("{shape:?}: {error}");
                    }
                }
            }
        }
    }
}

/// What the host writes and reads are plain arrays of the numbers that it converts to, with as many per state as its own
/// rows have.
/// Seen to fail with: `states` declared as `array<vec2<real>>`.
#[test]
fn the_hosts_arrays_are_what_the_shaders_declare() {
    for ((precision, size), (law, events, blocks, passes)) in PRECISIONS
        .into_iter()
        .flat_map(|p| LAWS.map(|law| (p, law)))
    {
        for shape in shapes(precision, (law, events)) {
            let read = Reflection::of(&shape.text(true)).unwrap();
            let binding = |name: &str| read.bindings[name];
            let set_size = binding("deviations").per_state.unwrap() / 3;
            let expected = [
                ("coefficients", size, Some(3 * (set_size - 1)), Access::Read),
                ("states", size, Some(4), Access::Read),
                ("deviations", size, Some(3 * set_size), Access::ReadWrite),
                (
                    "tangents",
                    size,
                    Some(blocks * set_size * set_size),
                    Access::ReadWrite,
                ),
                ("flags", 4, Some(1), Access::ReadWrite),
                ("slots", 4, Some(1), Access::ReadWrite),
                ("n_moving", 4, None, Access::ReadWrite),
                ("orders", 4, None, Access::Read),
                ("circle", size, None, Access::Read),
                ("batch", 4, None, Access::Uniform),
            ];
            for (name, element_bytes, per_state, access) in expected {
                let found = binding(name);
                assert_eq!(
                    (found.element_bytes, found.per_state, found.access),
                    (element_bytes, per_state, access),
                    "{name} in {shape:?}"
                );
            }
            let numbers: std::collections::BTreeSet<u32> =
                read.bindings.values().map(|b| b.number).collect();
            assert_eq!(
                numbers.len(),
                read.bindings.len(),
                "every buffer has its own number"
            );
            assert_eq!(read.entry_points.len(), passes, "{:?}", read.entry_points);
        }
    }
}

/// Events without a shader stay with the processor, and shapes whose loops a software adapter would cut are known.
/// Seen to fail with: no bound on the iterations.
#[test]
fn other_events_have_no_shader() {
    let set = HarmonicSet::up_to(5);
    for events in [Events::Sampled, Events::Interpolated] {
        let plan = plan::<f64>(&set, 128, FrictionLaw::Box, events);
        assert!(ShaderKey::of(&plan, Precision::F32).is_none());
    }
    let suits = |h: usize, n_time: usize| {
        let plan = located::<f64>(&HarmonicSet::up_to(h), n_time);
        ShaderKey::of(&plan, Precision::F32)
            .unwrap()
            .suits_software()
    };
    assert!(suits(5, 128) && !suits(13, 256) && !suits(21, 256));
}
