//! Decoder of damaged streams: finds every message.
//!
//! All serial formats share this decoder: a [`Wire`] examines the bytes at one position, and the
//! decoder searches. Junk, truncated or corrupted neighbours and false headers cannot hide a
//! message, because the search continues at the next byte after a failed candidate. [`ByteCounts`]
//! accounts for every byte:
//! * **data** or **acknowledgement**: part of a valid message; a byte shared by two counts for the
//!   first.
//! * **junk**: part of no valid message, also in a truncated or corrupted message.
//! * **pending**: may still become part of a message. [`Resync::finish`] decides.
//!
//! A **checksum failure** is a [`Candidate::Corrupt`] outside every valid message. A candidate that
//! the end of the stream truncates is junk, not a failure.

use crate::reading::ByteCounts;

/// Result of examining the bytes at one position.
#[derive(Debug)]
pub enum Candidate<M> {
    /// No message begins here.
    None,
    /// A message may begin here; more bytes are needed.
    Undecided,
    /// A header without a valid message.
    Corrupt,
    /// Message and its length in bytes.
    Valid(M, usize),
}

/// Serial wire format.
pub trait Wire {
    /// Message from the device.
    type Message;
    /// Length of the longest message, bytes; with this many bytes `examine` decides.
    const LENGTH_MAX: usize;
    /// True if the search continues inside a valid message, because two may share bytes. Only for
    /// formats whose header and checksum make a false message inside a valid one rare.
    const NESTED: bool;

    /// Examines the message that may begin at the first of `bytes`, at the offset `byte_offset`.
    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Self::Message>;

    /// Returns true if a message contains a reading.
    fn is_data(message: &Self::Message) -> bool;
}

/// Bytes per processing step.
const CHUNK_BYTES: usize = 4096;

/// Streaming decoder: chunks in, messages out. The result does not depend on the chunk boundaries.
///
/// It stores at most one message between chunks and allocates only on creation.
#[derive(Clone, Debug)]
pub struct Resync<W: Wire> {
    wire: W,
    /// Undecided bytes, from `start` on.
    window: Vec<u8>,
    start: usize,
    /// Number of undecided bytes at the front that belong to a reported message.
    claimed: usize,
    counts: ByteCounts,
}

impl<W: Wire + Default> Default for Resync<W> {
    fn default() -> Self {
        Self::new(W::default())
    }
}

impl<W: Wire> Resync<W> {
    /// Creates a decoder for the stream of one device.
    #[must_use]
    pub fn new(wire: W) -> Self {
        Self {
            wire,
            window: Vec::with_capacity(W::LENGTH_MAX + CHUNK_BYTES),
            start: 0,
            claimed: 0,
            counts: ByteCounts::default(),
        }
    }

    /// Returns the format.
    #[must_use]
    pub fn wire(&self) -> &W {
        &self.wire
    }

    /// Processes the next bytes and reports every message that they complete.
    pub fn push(&mut self, chunk: &[u8], mut report: impl FnMut(W::Message)) {
        for piece in chunk.chunks(CHUNK_BYTES) {
            self.window.extend_from_slice(piece);
            self.counts.received += piece.len() as u64;
            while self.decide_first_byte(&mut report) {}
            self.window.drain(..self.start);
            self.start = 0;
        }
    }

    /// Ends the stream: pending bytes become messages or junk. The decoder can then process another
    /// stream; offsets and counts continue.
    pub fn finish(&mut self, mut report: impl FnMut(W::Message)) {
        while self.start < self.window.len() {
            if !self.decide_first_byte(&mut report) {
                self.advance();
            }
        }
        self.window.clear();
        self.start = 0;
    }

    /// Returns the byte counts so far.
    #[must_use]
    pub fn counts(&self) -> ByteCounts {
        ByteCounts {
            pending: (self.window.len() - self.start - self.claimed) as u64,
            ..self.counts
        }
    }

    /// Decides whether a message begins at the first undecided byte, and advances. Returns false if
    /// more bytes are needed.
    fn decide_first_byte(&mut self, report: &mut impl FnMut(W::Message)) -> bool {
        let bytes = &self.window[self.start..];
        if bytes.is_empty() {
            return false;
        }
        let offset = self.counts.received - bytes.len() as u64;
        match self.wire.examine(bytes, offset) {
            Candidate::Undecided => return false,
            Candidate::None => self.advance(),
            Candidate::Corrupt => {
                self.counts.checksum_failures += u64::from(self.claimed == 0);
                self.advance();
            }
            Candidate::Valid(message, length) => {
                self.claim(W::is_data(&message), length);
                report(message);
                let settled = if W::NESTED { 1 } else { length };
                (0..settled).for_each(|_| self.advance());
            }
        }
        true
    }

    /// Counts the bytes of a message that begins at the first undecided byte.
    fn claim(&mut self, is_data: bool, length: usize) {
        let fresh = length.saturating_sub(self.claimed) as u64;
        if is_data {
            self.counts.frames += 1;
            self.counts.data += fresh;
        } else {
            self.counts.acknowledgements += 1;
            self.counts.acknowledgement += fresh;
        }
        self.claimed = self.claimed.max(length);
    }

    /// Advances by one byte, which is junk unless it belongs to a message.
    fn advance(&mut self) {
        if self.claimed > 0 {
            self.claimed -= 1;
        } else {
            self.counts.junk += 1;
        }
        self.start += 1;
    }
}
