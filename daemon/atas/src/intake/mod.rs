//! Intake: decides which frames and joint states are believed. Lost or old data degrades towards caution.
//!
//! A [`CheckedFrame`] can only be made here. Every refusal is counted, and what matters for safety becomes a
//! [`Reason`]; nothing is ever repaired silently.

mod checked;
mod stuck;

pub use checked::CheckedFrame;

use crate::limits;
use crate::settings::Intake as Limits;
use crate::tick::Tick;
use crate::tick::{nanoseconds, seconds_between};
use crate::wiring::HandWiring;
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Cause, Hand, HandFrame, Reason};
use stuck::StuckWatch;

/// Why a frame was not believed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refusal {
    Corrupt,
    Foreign,
    Duplicate,
    Reordered,
    Mistimed,
    Resyncing,
}

/// Counts since the start, as [`shm_schemas::HandStatus`] shows them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameCounts {
    /// Believed.
    pub frames: u64,
    /// Missing from the sequence.
    pub lost: u64,
    /// Seen twice.
    pub duplicates: u64,
    /// Came after a newer one.
    pub reordered: u64,
    /// Failed the checksum.
    pub corrupt: u64,
    /// Stamped too far in the past or in the future.
    pub mistimed: u64,
    /// Another writer, hand or layout.
    pub foreign: u64,
    /// Elements masked because they were not finite, out of range or stuck.
    pub masked_elements: u64,
    /// Restarts of the writer.
    pub restarts: u64,
}

/// The gatekeeper of one hand's frames.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameIntake {
    hand: Hand,
    layout_hash: u64,
    elements: u32,
    fingers: usize,
    required: bool,
    period_s: f64,
    counts: FrameCounts,
    /// The writer that is believed, and the last frame from it.
    pinned: Option<Pinned>,
    /// A new writer that is on probation.
    candidate: Option<Candidate>,
    /// What of this tick's frames the robot must hold for.
    hold_reason: Reason,
    /// What of this tick's frames was refused but needs no reaction.
    warning: Reason,
    identical: u32,
    stuck: [StuckWatch; FINGERS],
    /// Elements that were stuck in the frame before, a bit each.
    were_stuck: [u64; FINGERS],
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Pinned {
    epoch: u64,
    sequence: u64,
    captured_ns: u64,
    received_ns: u64,
    #[cfg_attr(feature = "serde", serde(with = "crate::large::each"))]
    force_n: Forces,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Candidate {
    epoch: u64,
    sequence: u64,
    good: u32,
}

impl FrameIntake {
    /// An intake for one hand's sensor.
    #[must_use]
    pub fn new(hand: Hand, wiring: &HandWiring) -> Self {
        Self {
            hand,
            layout_hash: wiring.layout.hash(),
            elements: wiring.layout.count as u32,
            fingers: wiring.fingers,
            required: wiring.required,
            period_s: 1.0 / wiring.rate_hz,
            counts: FrameCounts::default(),
            pinned: None,
            candidate: None,
            hold_reason: Reason::default(),
            warning: Reason::default(),
            identical: 0,
            stuck: Default::default(),
            were_stuck: [0; FINGERS],
        }
    }

    /// Counts since the start.
    #[must_use]
    pub fn counts(&self) -> &FrameCounts {
        &self.counts
    }

    /// Epoch of the pinned writer, 0 before the first frame.
    #[must_use]
    pub fn writer_epoch(&self) -> u64 {
        self.pinned.map_or(0, |p| p.epoch)
    }

    /// Sequence of the newest believed frame.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.pinned.map_or(0, |p| p.sequence)
    }

    /// Age of the newest believed frame, ns; `u64::MAX` before the first.
    #[must_use]
    pub fn age_ns(&self, tick: Tick) -> u64 {
        self.pinned
            .map_or(u64::MAX, |p| tick.now_ns.saturating_sub(p.captured_ns))
    }

    /// Begins a tick.
    pub fn begin(&mut self) {
        self.hold_reason = Reason::default();
        self.warning = Reason::default();
    }

    /// What was refused in this tick without need to hold, for the event log.
    #[must_use]
    pub fn warning(&self) -> Reason {
        self.warning
    }

    /// Checks one frame. `None` if it is not believed; the counts and [`FrameIntake::hold_reason`] say why.
    pub fn check<'a>(
        &mut self,
        frame: &'a HandFrame,
        tick: Tick,
        limits: &Limits,
    ) -> Option<CheckedFrame<'a>> {
        match self.admit(frame, tick, limits) {
            Ok(gap) => Some(self.accept(frame, gap, tick, limits)),
            Err(refusal) => {
                self.count(refusal, frame, tick, limits);
                None
            }
        }
    }

    /// What the robot must hold for, if anything: the worst doubt of this tick, or silence.
    #[must_use]
    pub fn hold_reason(&self, tick: Tick, limits: &Limits) -> Reason {
        if !self.required || self.hold_reason.is_some() {
            return self.hold_reason;
        }
        let allowed_s = limits.hold_age_s.max(self.longest_silence_s());
        let index = self.hand.0 as usize;
        match self.pinned {
            None => {
                Reason::limit(Cause::FRAMES_STOPPED, f64::INFINITY, allowed_s * 1e9).about(index)
            }
            Some(p) => {
                let age_s = seconds_between(p.captured_ns, tick.now_ns);
                // A frame that was old when it came is stale; one that has aged since then is the last of its kind.
                let cause = if seconds_between(p.captured_ns, p.received_ns) > allowed_s {
                    Cause::FRAME_STALE
                } else {
                    Cause::FRAMES_STOPPED
                };
                if age_s > allowed_s {
                    Reason::limit(cause, age_s * 1e9, allowed_s * 1e9).about(index)
                } else {
                    Reason::default()
                }
            }
        }
    }

    /// A slow sensor is silent between its frames: three and a half periods are no reason to worry.
    fn longest_silence_s(&self) -> f64 {
        3.5 * self.period_s
    }

    /// The checks in order; `Ok` carries the number of frames lost before this one.
    fn admit(&mut self, frame: &HandFrame, tick: Tick, limits: &Limits) -> Result<u64, Refusal> {
        if !frame.is_intact() {
            return Err(Refusal::Corrupt);
        }
        if frame.hand != self.hand
            || frame.layout_hash != self.layout_hash
            || frame.finger_count as usize != self.fingers
        {
            return Err(Refusal::Foreign);
        }
        let ahead_s = seconds_between(tick.now_ns, frame.stamp.captured_ns);
        if ahead_s > limits.future_s || -ahead_s > limits.reject_age_s {
            return Err(Refusal::Mistimed);
        }
        let Some(pinned) = self.pinned else {
            return Ok(0);
        };
        if frame.stamp.writer_epoch != pinned.epoch {
            return self.consider_writer(frame, pinned, tick, limits);
        }
        // Wrapping: a counter that begins again at 0 after its last value is no gap.
        match frame.stamp.sequence.wrapping_sub(pinned.sequence) {
            0 => Err(Refusal::Duplicate),
            // Farther than any loss: as good as another writer. One such frame must not shut out those that follow it.
            ahead if ahead > limits::FRAMES_AHEAD_MAX => {
                match self.consider_writer(frame, pinned, tick, limits) {
                    Err(Refusal::Foreign) if ahead > u64::MAX / 2 => Err(Refusal::Reordered),
                    considered => considered,
                }
            }
            _ if frame.stamp.captured_ns <= pinned.captured_ns => Err(Refusal::Mistimed),
            ahead => Ok(ahead - 1),
        }
    }

    /// Another writer is believed only after the pinned one fell silent and a run of good frames.
    fn consider_writer(
        &mut self,
        frame: &HandFrame,
        pinned: Pinned,
        tick: Tick,
        limits: &Limits,
    ) -> Result<u64, Refusal> {
        let silent_ns = limits::WRITER_SILENT_NS.max(nanoseconds(self.longest_silence_s()));
        if tick.now_ns.saturating_sub(pinned.received_ns) < silent_ns {
            return Err(Refusal::Foreign);
        }
        let (epoch, sequence) = (frame.stamp.writer_epoch, frame.stamp.sequence);
        let good = match self.candidate {
            Some(c) if c.epoch == epoch && sequence > c.sequence => c.good + 1,
            _ => 1,
        };
        self.candidate = Some(Candidate {
            epoch,
            sequence,
            good,
        });
        if f64::from(good) < limits.resync_frames {
            return Err(Refusal::Resyncing);
        }
        self.counts.restarts += 1;
        self.worsen(Reason::of(Cause::SENSOR_RESTARTED));
        Ok(0)
    }

    fn accept<'a>(
        &mut self,
        frame: &'a HandFrame,
        gap: u64,
        tick: Tick,
        limits: &Limits,
    ) -> CheckedFrame<'a> {
        self.counts.frames += 1;
        self.candidate = None;
        self.counts.lost = self.counts.lost.saturating_add(gap);
        if gap as f64 > limits.gap_frames {
            self.worsen(Reason::limit(
                Cause::FRAMES_LOST,
                gap as f64,
                limits.gap_frames,
            ));
        }
        self.watch_frozen(frame, limits);
        self.watch_stuck(frame);
        let mask = self.mask(frame, limits);
        let step_s = self
            .pinned
            .map_or(self.period_s, |p| {
                seconds_between(p.captured_ns, frame.stamp.captured_ns)
            })
            .clamp(0.0, limits::FILTER_STEP_MAX_S);
        self.pinned = Some(Pinned {
            epoch: frame.stamp.writer_epoch,
            sequence: frame.stamp.sequence,
            captured_ns: frame.stamp.captured_ns,
            received_ns: tick.now_ns,
            force_n: frame.force_n,
        });
        CheckedFrame {
            frame,
            mask,
            step_s,
        }
    }

    /// Masks elements that are flagged invalid, not finite, beyond belief or stuck; too many of them are a doubt.
    fn mask(&mut self, frame: &HandFrame, limits: &Limits) -> [u64; FINGERS] {
        let mut mask = [0; FINGERS];
        let mut worst = 0;
        for (finger, mask) in mask.iter_mut().enumerate().take(self.fingers) {
            let mut invalid = 0;
            for element in 0..self.elements as usize {
                let trusted = frame.valid_mask[finger] & !self.were_stuck[finger];
                let flagged = trusted >> element & 1 == 1;
                let force = frame.force_n[finger][element];
                // The comparison is false for NaN, so a NaN is masked before any arithmetic sees it.
                let believable = force
                    .iter()
                    .all(|f| f64::from(f.abs()) <= limits.element_force_n);
                if flagged && believable {
                    *mask |= 1 << element;
                } else {
                    invalid += 1;
                }
            }
            self.counts.masked_elements += invalid;
            worst = worst.max(invalid);
        }
        // Per finger: a blind fingertip is no better for a good one beside it.
        let share = worst as f64 / f64::from(self.elements);
        if share > limits.invalid_share {
            self.worsen(Reason::limit(
                Cause::ELEMENTS_INVALID,
                share,
                limits.invalid_share,
            ));
        }
        mask
    }

    /// A living sensor has noise: readings that repeat exactly while the counter advances are not readings.
    fn watch_frozen(&mut self, frame: &HandFrame, limits: &Limits) {
        let same = self
            .pinned
            .as_ref()
            .is_some_and(|p| same_bits(&p.force_n, &frame.force_n));
        self.identical = if same {
            self.identical.saturating_add(1)
        } else {
            0
        };
        if limits.frozen_frames > 0.0 && f64::from(self.identical) >= limits.frozen_frames {
            self.worsen(Reason::limit(
                Cause::FRAMES_FROZEN,
                f64::from(self.identical),
                limits.frozen_frames,
            ));
        }
    }

    /// Single elements that are stuck are said once, and not believed until they move again.
    fn watch_stuck(&mut self, frame: &HandFrame) {
        let Some(pinned) = &self.pinned else { return };
        let elements = self.elements as usize;
        let mut first = None;
        for finger in 0..self.fingers {
            let (before_n, now_n) = (&pinned.force_n[finger], &frame.force_n[finger]);
            let stuck = self.stuck[finger].look(before_n, now_n, elements);
            let newly = stuck & !self.were_stuck[finger];
            self.were_stuck[finger] = stuck;
            if newly != 0 {
                first = first.or(Some((finger, newly.trailing_zeros())));
            }
        }
        if let Some((finger, element)) = first {
            let about = Reason::limit(Cause::ELEMENT_STUCK, f64::from(element), finger as f64);
            self.warn(about);
        }
    }

    fn count(&mut self, refusal: Refusal, frame: &HandFrame, tick: Tick, limits: &Limits) {
        match refusal {
            Refusal::Corrupt => {
                self.counts.corrupt += 1;
                self.warn(Reason::limit(
                    Cause::FRAME_CORRUPT,
                    self.counts.corrupt as f64,
                    0.0,
                ));
            }
            Refusal::Foreign => {
                self.counts.foreign += 1;
                self.warn(Reason::of(Cause::FRAME_FOREIGN));
            }
            Refusal::Mistimed => {
                self.counts.mistimed += 1;
                self.warn(mistimed(frame, tick, limits));
            }
            Refusal::Duplicate => self.counts.duplicates += 1,
            Refusal::Reordered => self.counts.reordered += 1,
            Refusal::Resyncing => self.worsen(Reason::of(Cause::SENSOR_RESTARTED)),
        }
    }

    /// Keeps the first doubt of a tick: it is the one that explains the others.
    fn worsen(&mut self, reason: Reason) {
        if !self.hold_reason.is_some() {
            self.hold_reason = reason.about(self.hand.0 as usize);
        }
    }

    fn warn(&mut self, reason: Reason) {
        if !self.warning.is_some() {
            self.warning = reason.about(self.hand.0 as usize);
        }
    }
}

type Forces = [[[f32; 3]; ELEMENTS]; FINGERS];

/// Bit by bit, because a NaN would make frozen frames look different from each other.
fn same_bits(a: &Forces, b: &Forces) -> bool {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    a.as_flattened()
        .iter()
        .zip(b.as_flattened())
        .all(|(a, b)| a.to_bits() == b.to_bits())
}

fn mistimed(frame: &HandFrame, tick: Tick, limits: &Limits) -> Reason {
    let ahead_s = seconds_between(tick.now_ns, frame.stamp.captured_ns);
    if ahead_s > 0.0 {
        Reason::limit(Cause::FRAME_FUTURE, ahead_s * 1e9, limits.future_s * 1e9)
    } else {
        Reason::limit(
            Cause::FRAME_STALE,
            -ahead_s * 1e9,
            limits.reject_age_s * 1e9,
        )
    }
}
