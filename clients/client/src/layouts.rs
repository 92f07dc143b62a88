//! Layouts by the hash that frames carry.

use shm_schemas::Layout;
use shm_schemas::capacity::ELEMENTS;

/// The layout of this hash, if it is one that has a name.
#[must_use]
pub fn named(hash: u64) -> Option<Layout> {
    Layout::named(&name(hash)?)
}

/// The name of the layout of this hash, if it is one of those whose names say it all: grids of any pitch have none here.
#[must_use]
pub fn name(hash: u64) -> Option<String> {
    let names = Layout::NAMES.iter().map(|name| (*name).to_owned());
    let pads = (1..=ELEMENTS).map(|count| format!("pad-{count}"));
    let is_it = |name: &String| Layout::named(name).is_some_and(|layout| layout.hash() == hash);
    names.chain(pads).find(is_it)
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
            assert_eq!(super::name(layout.hash()).as_deref(), Some(name));
        }
        assert!(named(7).is_none());
    }
}
