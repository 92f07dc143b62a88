//! Common Data Representation (OMG DDS-XTypes 1.3, 7.4.1: plain CDR, little-endian): the
//! serialisation of ROS 2.

/// The encapsulation header: plain CDR, little-endian, no options.
const HEADER: [u8; 4] = [0, 1, 0, 0];

/// Message being written.
#[derive(Clone, Debug)]
pub(super) struct Cdr(Vec<u8>);

impl Cdr {
    pub(super) fn new() -> Self {
        Self(HEADER.to_vec())
    }

    /// Begins the next message in the same memory.
    pub(super) fn begin(&mut self) -> &mut Self {
        self.0.truncate(HEADER.len());
        self
    }

    pub(super) fn bytes(&self) -> &[u8] {
        &self.0
    }

    /// Writes a number, aligned to its size, counted from the end of the header.
    fn number<const N: usize>(&mut self, bytes: [u8; N]) -> &mut Self {
        let used = self.0.len() - HEADER.len();
        let padded = HEADER.len() + used.next_multiple_of(N);
        self.0.resize(padded, 0);
        self.0.extend_from_slice(&bytes);
        self
    }

    pub(super) fn u8(&mut self, value: u8) -> &mut Self {
        self.number([value])
    }

    pub(super) fn u32(&mut self, value: u32) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(super) fn f64(&mut self, value: f64) -> &mut Self {
        self.number(value.to_le_bytes())
    }

    pub(super) fn f64s(&mut self, values: &[f64]) -> &mut Self {
        values.iter().fold(self, |cdr, value| cdr.f64(*value))
    }

    /// Writes the length including the terminating zero, the bytes, the zero.
    pub(super) fn text(&mut self, text: &str) -> &mut Self {
        self.length(text.len() + 1);
        self.0.extend_from_slice(text.as_bytes());
        self.u8(0)
    }

    /// Writes the number of elements of a sequence.
    pub(super) fn length(&mut self, elements: usize) -> &mut Self {
        self.u32(u32::try_from(elements).unwrap_or(u32::MAX))
    }

    /// Writes a sequence of bytes.
    pub(super) fn blob(&mut self, bytes: &[u8]) -> &mut Self {
        self.length(bytes.len());
        self.0.extend_from_slice(bytes);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_aligned_and_texts_terminated() {
        let mut cdr = Cdr::new();
        cdr.u8(7).u32(1).text("ab").f64(1.0);
        let expected = [
            &HEADER[..],
            &[7, 0, 0, 0],
            &[1, 0, 0, 0],
            &[3, 0, 0, 0, b'a', b'b', 0, 0],
            &1.0_f64.to_le_bytes(),
        ]
        .concat();
        // 1 + 3 + 4 + 4 + 3 bytes precede the last number, which is at offset 16.
        assert_eq!(cdr.bytes(), expected);
        assert_eq!(cdr.begin().u8(9).bytes(), [0, 1, 0, 0, 9]);
    }
}
