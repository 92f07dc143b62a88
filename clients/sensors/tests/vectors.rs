//! Test vectors of every sensor: received bytes and their meaning.

mod common;

use std::collections::BTreeSet;

use atas_sensors::wire::SENSORS;
use common::vectors::{cases_of, driver, names, receive};

#[test]
fn sensors_and_vector_tables_match() {
    let sensors: BTreeSet<String> = SENSORS.iter().map(|s| s.name.to_owned()).collect();
    assert_eq!(sensors, names());
}

#[test]
fn vectors_decode_as_listed_for_any_chunks() {
    for sensor in &SENSORS {
        let cases = cases_of(sensor.name);
        assert!(
            cases
                .iter()
                .any(|case| case.expect.iter().any(|event| event.starts_with("frame"))),
            "{} has no frame among its vectors",
            sensor.name
        );
        for case in cases {
            let sizes = if common::vectors::is_stream(sensor) {
                vec![1, 3, 64, case.bytes.len().max(1)]
            } else {
                vec![case.bytes.len().max(1)]
            };
            for size in sizes {
                let mut driver = driver(sensor, &case.options);
                let events = receive(driver.as_mut(), case.bytes.chunks(size));
                assert_eq!(
                    events, case.expect,
                    "{}: {}, in chunks of {size}",
                    sensor.name, case.about
                );
                let counts = driver.counts();
                assert_eq!(
                    counts.received,
                    counts.data + counts.acknowledgement + counts.junk + counts.pending
                );
            }
        }
    }
}
