//! Finds every message in a damaged stream.

use super::frame::{Candidate, MAX_LENGTH, Message, examine};

/// Where the bytes of a stream went: `received = data + acknowledgement + junk + pending`, always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ByteCounts {
    /// Bytes given to the decoder.
    pub received: u64,
    /// Bytes of valid data frames.
    pub data: u64,
    /// Bytes of valid acknowledgements.
    pub acknowledgement: u64,
    /// Bytes that belong to no valid message.
    pub junk: u64,
    /// Bytes that may still become a message; 0 after [`Decoder::finish`].
    pub pending: u64,
    /// Valid data frames.
    pub frames: u64,
    /// Valid acknowledgements.
    pub acknowledgements: u64,
    /// Headers outside valid messages whose checksum did not match.
    pub checksum_failures: u64,
}

/// A streaming decoder: any chunks in, messages out; the result does not depend on how the stream is cut into chunks.
///
/// It keeps at most one message's worth of bytes and never allocates. See the [module](super) for what counts as what.
#[derive(Clone, Debug)]
pub struct Decoder {
    /// The first `length` bytes begin at the first offset that is not settled yet.
    window: [u8; MAX_LENGTH],
    length: usize,
    /// How many of the first bytes of the window lie in a message that was already reported.
    claimed: usize,
    counts: ByteCounts,
}

impl Default for Decoder {
    fn default() -> Self {
        Self {
            window: [0; MAX_LENGTH],
            length: 0,
            claimed: 0,
            counts: ByteCounts::default(),
        }
    }
}

impl Decoder {
    /// Takes the next bytes of the stream and reports every message that they complete.
    pub fn push(&mut self, chunk: &[u8], mut report: impl FnMut(Message)) {
        for &byte in chunk {
            // There is room: an undecided candidate is shorter than the longest message.
            self.window[self.length] = byte;
            self.length += 1;
            self.counts.received += 1;
            while self.settle_first_byte(&mut report) {}
        }
    }

    /// Ends the stream: what is pending becomes messages where it can, junk where it cannot. The decoder can then be
    /// used for another stream, whose byte offsets and counts continue.
    pub fn finish(&mut self, mut report: impl FnMut(Message)) {
        while self.length > 0 {
            if !self.settle_first_byte(&mut report) {
                self.advance();
            }
        }
    }

    /// What happened to the bytes so far.
    #[must_use]
    pub fn counts(&self) -> ByteCounts {
        ByteCounts {
            pending: (self.length - self.claimed) as u64,
            ..self.counts
        }
    }

    /// Decides whether a message begins at the first byte of the window and moves on to the next byte. Returns false
    /// when that cannot be decided yet.
    fn settle_first_byte(&mut self, report: &mut impl FnMut(Message)) -> bool {
        if self.length == 0 {
            return false;
        }
        let offset = self.counts.received - self.length as u64;
        match examine(&self.window[..self.length], offset) {
            Candidate::Undecided => return false,
            Candidate::None => {}
            Candidate::Corrupt => self.counts.checksum_failures += u64::from(self.claimed == 0),
            Candidate::Valid(message, length) => {
                self.claim(&message, length);
                report(message);
            }
        }
        self.advance();
        true
    }

    /// Books the bytes of a message that begins at the first byte of the window.
    fn claim(&mut self, message: &Message, length: usize) {
        let fresh = length.saturating_sub(self.claimed) as u64;
        match message {
            Message::Data(_) => {
                self.counts.frames += 1;
                self.counts.data += fresh;
            }
            Message::Acknowledgement(_) => {
                self.counts.acknowledgements += 1;
                self.counts.acknowledgement += fresh;
            }
        }
        self.claimed = self.claimed.max(length);
    }

    /// Drops the first byte of the window; it is junk unless a message claimed it.
    fn advance(&mut self) {
        if self.claimed > 0 {
            self.claimed -= 1;
        } else {
            self.counts.junk += 1;
        }
        self.window.copy_within(1..self.length, 0);
        self.length -= 1;
    }
}
