//! Element layouts by the hash in a frame, and of a run.

use shm_schemas::capacity::{ELEMENTS, HANDS};
use shm_schemas::{HandWiringRecord, Layout, RunHeader};

/// Returns the element layout of each hand in a run; the dome of the paper without a header.
#[must_use]
pub fn of_run(header: Option<&RunHeader>) -> [Layout; HANDS] {
    let layout = |wiring: &HandWiringRecord| Layout {
        count: (wiring.element_count as usize).min(ELEMENTS),
        normal: wiring.normal,
        tangent1: wiring.tangent1,
        tangent2: wiring.tangent2,
        position_m: wiring.position_m,
        element_area_m2: wiring.element_area_m2,
    };
    header.map_or_else(
        || [Layout::dome_41(), Layout::dome_41()],
        |header| header.hands.each_ref().map(layout),
    )
}

/// Returns the named layout with this hash, if any.
///
/// ```
/// use shm_schemas::Layout;
///
/// let hash = Layout::dome_41().hash();
/// assert_eq!(atas_client::layouts::name(hash).as_deref(), Some("dome-41"));
/// ```
#[must_use]
pub fn named(hash: u64) -> Option<Layout> {
    Layout::from_name(&name(hash)?)
}

/// Returns the name of the layout with this hash, if the name alone defines it; grids of arbitrary
/// pitch have no name here.
#[must_use]
pub fn name(hash: u64) -> Option<String> {
    let names = Layout::NAMES.iter().map(|name| (*name).to_owned());
    let pads = (1..=ELEMENTS).map(|count| format!("pad-{count}"));
    let is_it = |name: &String| Layout::from_name(name).is_some_and(|layout| layout.hash() == hash);
    names.chain(pads).find(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_layout_is_found_by_hash() {
        for name in ["dome-41", "dome-1", "pad-7", "pad-64"] {
            let layout = Layout::from_name(name).expect("known");
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
