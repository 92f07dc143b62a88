//! Any input: no driver panics, miscounts a byte, or depends on chunk boundaries.

mod common;

use atas_sensors::wire::{SENSORS, SensorType};
use common::vectors::{cases_of, driver, is_stream, receive};
use proptest::prelude::*;

/// Streams of a sensor: its vectors complete, truncated, damaged and repeated, with junk between.
fn stream(sensor: &'static SensorType) -> impl Strategy<Value = Vec<u8>> {
    let known: Vec<Vec<u8>> = cases_of(sensor.name)
        .into_iter()
        .map(|case| case.bytes)
        .collect();
    let whole = prop::sample::select(known);
    let cut = (whole.clone(), any::<prop::sample::Index>())
        .prop_map(|(bytes, at)| bytes[..at.index(bytes.len())].to_vec());
    let damaged = (whole.clone(), any::<prop::sample::Index>(), any::<u8>()).prop_map(
        |(mut bytes, at, with)| {
            let at = at.index(bytes.len());
            bytes[at] = with;
            bytes
        },
    );
    let piece = prop_oneof![
        3 => whole,
        2 => cut,
        3 => damaged,
        2 => prop::collection::vec(any::<u8>(), 0..80),
    ];
    prop::collection::vec(piece, 0..8).prop_map(|pieces| pieces.concat())
}

fn sensor_and_stream() -> impl Strategy<Value = (&'static SensorType, Vec<u8>)> {
    (0..SENSORS.len()).prop_flat_map(|n| {
        let sensor: &'static SensorType = Box::leak(Box::new(SENSORS[n]));
        stream(sensor).prop_map(move |bytes| (sensor, bytes))
    })
}

proptest! {
    #[test]
    fn any_bytes_are_survived_and_accounted_for(
        (sensor, bytes) in sensor_and_stream(),
        size in 1_usize..200,
    ) {
        let mut one = driver(sensor, &[]);
        let events = receive(one.as_mut(), [bytes.as_slice()]);
        let counts = one.counts();
        prop_assert_eq!(counts.received, bytes.len() as u64);
        prop_assert_eq!(counts.received, counts.data + counts.acknowledgement + counts.junk);
        prop_assert_eq!(counts.pending, 0);
        if is_stream(sensor) {
            let mut other = driver(sensor, &[]);
            prop_assert_eq!(events, receive(other.as_mut(), bytes.chunks(size)));
            prop_assert_eq!(counts, other.counts());
        }
    }
}
