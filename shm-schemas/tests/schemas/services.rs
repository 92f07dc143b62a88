//! Service names are unique and well-formed.

use shm_schemas::service::*;
use std::collections::HashSet;

#[test]
fn service_names_are_unique_and_versioned() {
    let names = NAMES.map(|(_, name)| name);
    assert_eq!(names.iter().collect::<HashSet<_>>().len(), names.len());
    for name in names {
        let mut parts = name.split('/');
        assert_eq!(parts.next(), Some("atas"), "{name}");
        let version = parts
            .next()
            .and_then(|v| v.strip_prefix('v'))
            .map(str::parse::<u32>);
        assert!(matches!(version, Some(Ok(1..))), "{name}");
        let rest: Vec<_> = parts.collect();
        let plain = |part: &&str| {
            !part.is_empty() && part.chars().all(|c| c.is_ascii_lowercase() || c == '-')
        };
        assert!(!rest.is_empty() && rest.iter().all(plain), "{name}");
    }
}

#[test]
fn hand_services_are_named_after_their_hands() {
    for (name, hand) in HAND_FRAME.iter().zip(shm_schemas::Hand::BOTH) {
        assert!(name.ends_with(hand.name()));
    }
}
