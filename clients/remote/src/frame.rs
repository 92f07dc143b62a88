//! Frames on the connection: one byte for the kind, four bytes for the length (big-endian), and the
//! payload.
//!
//! A receiver knows the largest payload that it accepts, and rejects a longer frame at its header.

/// Bytes before the payload.
pub const HEADER: usize = 5;
/// Largest payload from a client, bytes: a command line. Design choice: many times the longest
/// useful one.
pub const CLIENT_MAX: usize = 32 << 10;
/// Largest payload from a server, bytes: one piece of output.
pub const SERVER_MAX: usize = 64 << 10;

/// Kind of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Kind {
    /// Sign of life, without payload.
    Alive = 1,
    /// Request of a client, JSON.
    Request = 2,
    /// Ctrl-C at the client, without payload.
    Interrupt = 3,
    /// Reply of the server, JSON.
    Reply = 4,
    /// Standard output of the command.
    Stdout = 5,
    /// Standard error of the command.
    Stderr = 6,
    /// Measurement of a round trip; the server sends it back.
    Echo = 7,
}

impl Kind {
    const ALL: [Self; 7] = [
        Self::Alive,
        Self::Request,
        Self::Interrupt,
        Self::Reply,
        Self::Stdout,
        Self::Stderr,
        Self::Echo,
    ];
}

/// Frame with its payload.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Kind.
    pub kind: Kind,
    /// Payload.
    pub payload: Vec<u8>,
}

/// Invalid frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FrameError {
    /// Unknown kind.
    #[error("frame of unknown kind {0}")]
    Kind(u8),
    /// Payload longer than the limit.
    #[error("frame of {length} bytes, the limit is {limit}")]
    Length {
        /// Length in the header.
        length: u32,
        /// Largest accepted length.
        limit: usize,
    },
}

/// Returns the bytes of a frame.
#[must_use]
pub fn encode(kind: Kind, payload: &[u8]) -> Vec<u8> {
    let length = u32::try_from(payload.len()).unwrap_or(u32::MAX);
    let mut bytes = Vec::with_capacity(HEADER + payload.len());
    bytes.push(kind as u8);
    bytes.extend_from_slice(&length.to_be_bytes());
    bytes.extend_from_slice(payload);
    bytes
}

/// Collects bytes and returns complete frames.
#[derive(Debug)]
pub struct Decoder {
    bytes: Vec<u8>,
    limit: usize,
}

impl Decoder {
    /// Creates a decoder that accepts payloads up to `limit` bytes.
    #[must_use]
    pub fn new(limit: usize) -> Self {
        Self {
            bytes: Vec::new(),
            limit,
        }
    }

    /// Returns true while a frame may be incomplete. Otherwise take the frames first.
    #[must_use]
    pub fn has_space(&self) -> bool {
        self.bytes.len() < HEADER + self.limit
    }

    /// Adds received bytes.
    pub fn push(&mut self, bytes: &[u8]) {
        self.bytes.extend_from_slice(bytes);
    }

    /// Returns the next complete frame.
    ///
    /// # Errors
    /// The header is invalid; the connection is unusable.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, FrameError> {
        let Some(&[kind, a, b, c, d]) = self.bytes.first_chunk() else {
            return Ok(None);
        };
        let known = Kind::ALL.into_iter().find(|known| *known as u8 == kind);
        let kind = known.ok_or(FrameError::Kind(kind))?;
        let length = u32::from_be_bytes([a, b, c, d]);
        let too_long = FrameError::Length {
            length,
            limit: self.limit,
        };
        let size = usize::try_from(length).map_err(|_| too_long)?;
        if size > self.limit {
            return Err(too_long);
        }
        if self.bytes.len() < HEADER + size {
            return Ok(None);
        }
        let payload = self.bytes[HEADER..HEADER + size].to_vec();
        self.bytes.drain(..HEADER + size);
        Ok(Some(Frame { kind, payload }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_arrive_in_any_pieces() {
        let sent = [(Kind::Request, b"abc".to_vec()), (Kind::Alive, vec![])];
        let bytes: Vec<u8> = sent.iter().flat_map(|(k, p)| encode(*k, p)).collect();
        for piece in 1..=bytes.len() {
            let (mut decoder, mut found) = (Decoder::new(8), Vec::new());
            for chunk in bytes.chunks(piece) {
                decoder.push(chunk);
                while let Some(frame) = decoder.next_frame().expect("valid") {
                    found.push((frame.kind, frame.payload));
                }
            }
            assert_eq!(found, sent);
        }
    }

    #[test]
    fn invalid_headers_are_refused_without_payload() {
        let check = |bytes: &[u8], expected| {
            let mut decoder = Decoder::new(8);
            decoder.push(bytes);
            assert_eq!(decoder.next_frame(), expected);
        };
        let (length, limit) = (u32::MAX, 8);
        let long = Err(FrameError::Length { length, limit });
        check(&[1, 0xFF, 0xFF, 0xFF, 0xFF], long);
        check(&[0, 0, 0, 0, 0], Err(FrameError::Kind(0)));
        check(b"GET / HTTP", Err(FrameError::Kind(b'G')));
        check(&[1, 0, 0, 0], Ok(None));
    }
}
