//! Finds every message in a damaged stream.
//!
//! The one decoder of all serial formats: a [`Wire`] says what stands at the beginning of some bytes, and this searches.
//! Junk, a truncated or corrupted neighbour, or a false header cannot hide a message, because after a failed candidate
//! the search goes on at the very next byte. Every byte is accounted for in [`ByteCounts`]:
//! * **data** or **acknowledgement**: it lies in a valid message; a byte shared by two is the first one's.
//! * **junk**: it lies in none, also when it is part of a truncated or corrupted message.
//! * **pending**: it may still become a message. [`Resync::finish`] settles them.
//!
//! A **checksum failure** is a [`Candidate::Corrupt`] outside every valid message. A candidate that the end of the
//! stream cuts short is junk, not a failure.

use crate::reading::ByteCounts;

/// What stands at the beginning of some bytes.
#[derive(Debug)]
pub enum Candidate<M> {
    /// No message can begin here.
    None,
    /// A message may begin here; more bytes decide.
    Undecided,
    /// A message was announced, but it does not hold.
    Corrupt,
    /// A message and its length in bytes.
    Valid(M, usize),
}

/// A serial wire format.
pub trait Wire {
    /// One message from the device.
    type Message;
    /// Bytes of the longest message; with so many, `examine` decides.
    const LONGEST: usize;
    /// Whether the search goes on inside a valid message, because two may share bytes. Only for formats whose header
    /// and checksum make a false message inside a true one rare.
    const NESTED: bool;

    /// Examines the message that may begin at the first of `bytes`, which has the offset `byte_offset`.
    fn examine(&self, bytes: &[u8], byte_offset: u64) -> Candidate<Self::Message>;

    /// Whether a message carries a reading.
    fn is_data(message: &Self::Message) -> bool;
}

/// Bytes taken at a time.
const PIECE: usize = 4096;

/// A streaming decoder: any chunks in, messages out; the result does not depend on how the stream is cut into chunks.
///
/// It keeps at most one message's worth of bytes between chunks and never allocates after its making.
#[derive(Clone, Debug)]
pub struct Resync<W: Wire> {
    wire: W,
    /// From `start` on, bytes that are not settled yet.
    window: Vec<u8>,
    start: usize,
    /// How many of the first unsettled bytes lie in a message that was already reported.
    claimed: usize,
    counts: ByteCounts,
}

impl<W: Wire + Default> Default for Resync<W> {
    fn default() -> Self {
        Self::new(W::default())
    }
}

impl<W: Wire> Resync<W> {
    /// For one device's stream.
    #[must_use]
    pub fn new(wire: W) -> Self {
        Self {
            wire,
            window: Vec::with_capacity(W::LONGEST + PIECE),
            start: 0,
            claimed: 0,
            counts: ByteCounts::default(),
        }
    }

    /// The format.
    #[must_use]
    pub fn wire(&self) -> &W {
        &self.wire
    }

    /// Takes the next bytes of the stream and reports every message that they complete.
    pub fn push(&mut self, chunk: &[u8], mut report: impl FnMut(W::Message)) {
        for piece in chunk.chunks(PIECE) {
            self.window.extend_from_slice(piece);
            self.counts.received += piece.len() as u64;
            while self.settle_first_byte(&mut report) {}
            self.window.drain(..self.start);
            self.start = 0;
        }
    }

    /// Ends the stream: what is pending becomes messages where it can, junk where it cannot. The decoder can then be
    /// used for another stream, whose byte offsets and counts continue.
    pub fn finish(&mut self, mut report: impl FnMut(W::Message)) {
        while self.start < self.window.len() {
            if !self.settle_first_byte(&mut report) {
                self.advance();
            }
        }
        self.window.clear();
        self.start = 0;
    }

    /// What happened to the bytes so far.
    #[must_use]
    pub fn counts(&self) -> ByteCounts {
        ByteCounts {
            pending: (self.window.len() - self.start - self.claimed) as u64,
            ..self.counts
        }
    }

    /// Decides whether a message begins at the first unsettled byte and moves on. Returns false when that cannot be
    /// decided yet.
    fn settle_first_byte(&mut self, report: &mut impl FnMut(W::Message)) -> bool {
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

    /// Books the bytes of a message that begins at the first unsettled byte.
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

    /// Settles one byte; it is junk unless a message claimed it.
    fn advance(&mut self) {
        if self.claimed > 0 {
            self.claimed -= 1;
        } else {
            self.counts.junk += 1;
        }
        self.start += 1;
    }
}
