//! Which adapter a process takes.

use super::report::AdapterFacts;

/// The adapter that a process takes of `all`: one that `wanted` names by index, PCI address or part of its name, or without
/// `wanted` a discrete one, else one of the other pieces of hardware, never one that is software.
///
/// Where several fit, processes of one node take one each: that number `local_rank`, counted around.
pub(super) fn chosen<'a>(
    wanted: Option<&str>,
    local_rank: u64,
    all: &'a [AdapterFacts],
) -> Option<&'a AdapterFacts> {
    let candidates = match wanted {
        Some(wanted) => fitting(all, |facts| facts.is_called(wanted)),
        None => match fitting(all, |facts| facts.kind == "discrete") {
            none if none.is_empty() => fitting(all, AdapterFacts::is_hardware),
            discrete => discrete,
        },
    };
    let turn = local_rank.checked_rem(candidates.len() as u64)?;
    candidates.get(turn as usize).copied()
}

/// Those that fit. A device that two interfaces offer is one.
fn fitting(all: &[AdapterFacts], fits: impl Fn(&AdapterFacts) -> bool) -> Vec<&AdapterFacts> {
    let mut found: Vec<&AdapterFacts> = Vec::new();
    for facts in all.iter().filter(|facts| fits(facts)) {
        let same = |other: &&AdapterFacts| !facts.pci.is_empty() && other.pci == facts.pci;
        if !found.iter().any(same) {
            found.push(facts);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A node with two large and one small adapter, one of the large ones by two interfaces, and software.
    fn node() -> Vec<AdapterFacts> {
        let adapters = [
            ("llvmpipe", "software", ""),
            ("Small 100", "integrated", "0000:00:02.0"),
            ("Large 200", "discrete", "0000:18:00.0"),
            ("Large 200", "discrete", "0000:18:00.0"),
            ("Large 200", "discrete", "0000:9a:00.0"),
        ];
        let facts = |(index, (name, kind, pci)): (usize, (&str, &str, &str))| AdapterFacts {
            index,
            name: name.to_owned(),
            kind: kind.to_owned(),
            interface: "vulkan".to_owned(),
            driver: String::new(),
            pci: pci.to_owned(),
            largest_binding: 0,
            f64: false,
            timestamps: false,
        };
        adapters.into_iter().enumerate().map(facts).collect()
    }

    /// Processes of a node share its discrete adapters evenly. Seen to fail with the first adapter for every rank, and with a
    /// device of two interfaces counted twice.
    #[test]
    fn each_process_of_a_node_takes_its_own() {
        let node = node();
        let of_rank = |wanted, rank| chosen(wanted, rank, &node).map(|facts| facts.index);
        let ranks = |wanted| [0, 1, 2, 3].map(|rank| of_rank(wanted, rank).unwrap());
        assert_eq!(ranks(None), [2, 4, 2, 4], "discrete ones");
        assert_eq!(ranks(Some("large")), [2, 4, 2, 4], "by name");
        assert_eq!(ranks(Some("0000:9A:00.0")), [4; 4], "by PCI address");
        assert_eq!(ranks(Some("1")), [1; 4], "by index");
        assert_eq!(ranks(Some("llvmpipe")), [0; 4], "software by name");
        assert_eq!(of_rank(Some("none such"), 1), None);
    }

    /// Without a discrete one the other hardware is taken, and software never. Seen to fail with all adapters in place of hardware.
    #[test]
    fn software_is_never_taken_unasked() {
        let node = node();
        let of = |range: std::ops::Range<usize>| chosen(None, 1, &node[range]).map(|f| f.index);
        assert_eq!(of(0..2), Some(1));
        assert_eq!(of(0..1), None);
    }
}
