//! Streams for tests, written independently of the decoder.
#![allow(dead_code, reason = "each test program uses its own part")]

pub(crate) mod vectors;

/// Returns header, payload and the sum of both.
fn message(header: [u8; 4], payload: impl IntoIterator<Item = u8>) -> Vec<u8> {
    let mut bytes = header.to_vec();
    bytes.extend(payload);
    let sum: u16 = bytes.iter().map(|&byte| u16::from(byte)).sum();
    bytes.extend(sum.to_be_bytes());
    bytes
}

/// Returns a data frame with any number of values, which determines its kind.
pub(crate) fn data_frame(count: u16, status: u16, values: &[i16]) -> Vec<u8> {
    let payload_length = 4 + 2 * u8::try_from(values.len()).unwrap();
    let words = [count, status]
        .into_iter()
        .chain(values.iter().map(|value| value.cast_unsigned()));
    message(
        [0xAA, 0x07, 0x08, payload_length],
        words.flat_map(u16::to_be_bytes),
    )
}

/// Returns a one-channel frame whose forces follow from its count, so that a wrong frame is
/// detected.
pub(crate) fn numbered_frame(count: u16) -> Vec<u8> {
    data_frame(count, 0, &forces_of(count))
}

/// Returns the forces of [`numbered_frame`].
pub(crate) fn forces_of(count: u16) -> [i16; 3] {
    let scrambled = count.wrapping_mul(40503);
    [
        scrambled,
        scrambled.rotate_left(5),
        scrambled.rotate_left(11),
    ]
    .map(|word| word.cast_signed() % 2000)
}

/// Returns an acknowledgement.
pub(crate) fn acknowledgement(status: u8) -> Vec<u8> {
    message([0xAA, 0x00, 0x50, 0x01], [status])
}
