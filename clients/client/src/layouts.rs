//! Layouts by the hash that frames carry.

use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// The layout of this hash, if it is one that has a name.
#[must_use]
pub fn named(hash: u64) -> Option<Layout> {
    let named = Layout::NAMES.iter().filter_map(|name| Layout::named(name));
    let pads = (1..=ELEMENTS).filter_map(|count| Layout::named(&format!("pad-{count}")));
    named.chain(pads).find(|layout| layout.hash() == hash)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_with_a_name_is_found_by_its_hash() {
        for name in ["dome-41", "dome-1", "pad-7", "pad-64"] {
            let layout = Layout::named(name).expect("known");
            let found = named(layout.hash()).expect(name);
            assert_eq!(
                (found.count, found.normal),
                (layout.count, layout.normal),
                "{name}"
            );
        }
        assert!(named(7).is_none());
    }
}
