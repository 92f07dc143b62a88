//! Intake: validates tactile frames of one hand. Lost or old data makes the robot hold.
//!
//! Input: [`HandFrame`]. Output: [`ValidatedFrame`]. Every rejection is counted; safety-relevant
//! ones raise a [`Reason`]. Data is never repaired.

mod stuck;
mod validated;

pub use validated::ValidatedFrame;

use crate::limits;
use crate::sensor_setup::HandSensorSetup;
use crate::settings::Intake as Limits;
use crate::tick::Tick;
use crate::tick::{nanoseconds, seconds_between};
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Hand, HandFrame, Reason};
use stuck::StuckDetector;

const SIGN_BIT: u32 = 1 << 31;
/// Bits of the smallest normal number.
const MIN_NORMAL_BITS: u32 = f32::MIN_POSITIVE.to_bits();

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rejection {
    Corrupt,
    Foreign,
    Duplicate,
    Reordered,
    Mistimed,
    Resyncing,
}

/// Frame counts since the start, published in [`shm_schemas::HandStatus`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct FrameCounts {
    /// Accepted frames.
    pub frames: u64,
    /// Frames missing from the sequence.
    pub lost: u64,
    /// Frames received twice.
    pub duplicates: u64,
    /// Frames received after a newer one.
    pub reordered: u64,
    /// Frames with a wrong checksum.
    pub corrupt: u64,
    /// Frames stamped too far in the past or future.
    pub mistimed: u64,
    /// Frames of another writer, hand or layout.
    pub foreign: u64,
    /// Elements masked as not finite, denormal, out of range or stuck.
    pub masked_elements: u64,
    /// Writer restarts.
    pub restarts: u64,
}

/// Frame validator of one hand.
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
    /// Accepted writer and its last frame.
    pinned: Option<Pinned>,
    /// New writer on probation.
    candidate: Option<Candidate>,
    /// First reason of this tick to hold the robot.
    hold_reason: Reason,
    /// First rejection of this tick that needs no reaction.
    warning: Reason,
    identical: u32,
    stuck: [StuckDetector; FINGERS],
    were_stuck: [u64; FINGERS],
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
struct Pinned {
    epoch: u64,
    sequence: u64,
    captured_ns: u64,
    received_ns: u64,
    #[cfg_attr(feature = "serde", serde(with = "crate::serde_arrays::nested"))]
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
    /// Creates the intake of one hand.
    #[must_use]
    pub fn new(hand: Hand, wiring: &HandSensorSetup) -> Self {
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
            hold_reason: Reason::None,
            warning: Reason::None,
            identical: 0,
            stuck: Default::default(),
            were_stuck: [0; FINGERS],
        }
    }

    /// Frame counts since the start.
    #[must_use]
    pub fn counts(&self) -> &FrameCounts {
        &self.counts
    }

    /// Epoch of the accepted writer; 0 before the first frame.
    #[must_use]
    pub fn writer_epoch(&self) -> u64 {
        self.pinned.map_or(0, |p| p.epoch)
    }

    /// Sequence number of the newest accepted frame.
    #[must_use]
    pub fn sequence(&self) -> u64 {
        self.pinned.map_or(0, |p| p.sequence)
    }

    /// Age of the newest accepted frame, ns; `u64::MAX` before the first.
    #[must_use]
    pub fn age_ns(&self, tick: Tick) -> u64 {
        self.pinned
            .map_or(u64::MAX, |p| tick.now_ns.saturating_sub(p.captured_ns))
    }

    /// Starts a tick.
    pub fn begin(&mut self) {
        self.hold_reason = Reason::None;
        self.warning = Reason::None;
    }

    /// Rejection of this tick that needs no hold, for the event log.
    #[must_use]
    pub fn warning(&self) -> Reason {
        self.warning
    }

    /// Validates one frame; returns `None` and counts it on rejection.
    pub fn validate<'a>(
        &mut self,
        frame: &'a HandFrame,
        tick: Tick,
        limits: &Limits,
    ) -> Option<ValidatedFrame<'a>> {
        match self.admit(frame, tick, limits) {
            Ok(gap) => Some(self.accept(frame, gap, tick, limits)),
            Err(refusal) => {
                self.count(refusal, frame, tick, limits);
                None
            }
        }
    }

    /// Returns the reason to hold the robot, if any: first one of this tick, or missing frames.
    #[must_use]
    pub fn hold_reason(&self, tick: Tick, limits: &Limits) -> Reason {
        if !self.required || self.hold_reason.is_some() {
            return self.hold_reason;
        }
        let allowed_s = limits.hold_age_s.max(self.pause_max_s());
        let (hand, limit_ns) = (self.hand, allowed_s * 1e9);
        let Some(pinned) = &self.pinned else {
            return Reason::FramesStopped {
                hand,
                age_ns: None,
                limit_ns,
            };
        };
        let age_s = seconds_between(pinned.captured_ns, tick.now_ns);
        let age_ns = age_s * 1e9;
        if age_s <= allowed_s {
            Reason::None
        } else if seconds_between(pinned.captured_ns, pinned.received_ns) > allowed_s {
            // Already old on arrival.
            Reason::FrameStale {
                hand,
                age_ns,
                limit_ns,
            }
        } else {
            Reason::FramesStopped {
                hand,
                age_ns: Some(age_ns),
                limit_ns,
            }
        }
    }

    /// Returns the longest normal pause between frames, s: 3.5 sensor periods.
    fn pause_max_s(&self) -> f64 {
        3.5 * self.period_s
    }

    /// Runs the checks in order. `Ok` is the number of frames lost before this one.
    fn admit(&mut self, frame: &HandFrame, tick: Tick, limits: &Limits) -> Result<u64, Rejection> {
        if !frame.is_intact() {
            return Err(Rejection::Corrupt);
        }
        if frame.hand != self.hand
            || frame.layout_hash != self.layout_hash
            || frame.finger_count as usize != self.fingers
        {
            return Err(Rejection::Foreign);
        }
        let ahead_s = seconds_between(tick.now_ns, frame.stamp.captured_ns);
        if ahead_s > limits.future_s || -ahead_s > limits.reject_age_s {
            return Err(Rejection::Mistimed);
        }
        let Some(pinned) = self.pinned else {
            return Ok(0);
        };
        if frame.stamp.writer_epoch != pinned.epoch {
            return self.consider_writer(frame, pinned, tick, limits);
        }
        // Wrapping: a counter overflow to 0 is no gap.
        match frame.stamp.sequence.wrapping_sub(pinned.sequence) {
            0 => Err(Rejection::Duplicate),
            // An implausible jump counts as another writer, so it cannot block later frames.
            ahead if ahead > limits::FRAME_GAP_MAX => {
                match self.consider_writer(frame, pinned, tick, limits) {
                    Err(Rejection::Foreign) if ahead > u64::MAX / 2 => Err(Rejection::Reordered),
                    considered => considered,
                }
            }
            _ if frame.stamp.captured_ns <= pinned.captured_ns => Err(Rejection::Mistimed),
            ahead => Ok(ahead - 1),
        }
    }

    /// Accepts another writer after the current one fell silent and a run of valid frames.
    fn consider_writer(
        &mut self,
        frame: &HandFrame,
        pinned: Pinned,
        tick: Tick,
        limits: &Limits,
    ) -> Result<u64, Rejection> {
        let silent_ns = limits::WRITER_SILENT_NS.max(nanoseconds(self.pause_max_s()));
        if tick.now_ns.saturating_sub(pinned.received_ns) < silent_ns {
            return Err(Rejection::Foreign);
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
            return Err(Rejection::Resyncing);
        }
        self.counts.restarts += 1;
        self.escalate(Reason::SensorRestarted { hand: self.hand });
        Ok(0)
    }

    fn accept<'a>(
        &mut self,
        frame: &'a HandFrame,
        gap: u64,
        tick: Tick,
        limits: &Limits,
    ) -> ValidatedFrame<'a> {
        self.counts.frames += 1;
        self.candidate = None;
        self.counts.lost = self.counts.lost.saturating_add(gap);
        if gap as f64 > limits.gap_frames {
            self.escalate(Reason::FramesLost {
                hand: self.hand,
                lost: gap,
                limit: limits.gap_frames,
            });
        }
        self.detect_frozen(frame, limits);
        self.detect_stuck(frame);
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
        ValidatedFrame {
            frame,
            mask,
            step_s,
            age_s: seconds_between(frame.stamp.captured_ns, tick.now_ns).max(0.0),
        }
    }

    /// Returns the mask of valid elements; too many invalid ones make the robot hold.
    fn mask(&mut self, frame: &HandFrame, limits: &Limits) -> [u64; FINGERS] {
        let mut mask = [0; FINGERS];
        let mut worst = 0;
        let limit_n = largest_at_most(limits.element_force_n);
        for (finger, mask) in mask.iter_mut().enumerate().take(self.fingers) {
            let readings_n = &frame.force_n[finger][..self.elements as usize];
            let trusted = frame.valid_mask[finger] & !self.were_stuck[finger];
            *mask = trusted & believable(readings_n, limit_n);
            let invalid = u64::from(self.elements - mask.count_ones());
            self.counts.masked_elements += invalid;
            worst = worst.max(invalid);
        }
        // Per fingertip, because a good one does not compensate for a blind one.
        let share = worst as f64 / f64::from(self.elements);
        if share > limits.invalid_share {
            self.escalate(Reason::ElementsInvalid {
                hand: self.hand,
                share,
                limit: limits.invalid_share,
            });
        }
        mask
    }

    /// Detects a frozen sensor; real readings have noise and never repeat exactly.
    fn detect_frozen(&mut self, frame: &HandFrame, limits: &Limits) {
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
            self.escalate(Reason::FramesFrozen {
                hand: self.hand,
                identical: self.identical,
                limit: limits.frozen_frames,
            });
        }
    }

    /// Warns once of each stuck element and masks it until its reading changes.
    fn detect_stuck(&mut self, frame: &HandFrame) {
        let Some(pinned) = &self.pinned else { return };
        let elements = self.elements as usize;
        let mut first = None;
        for finger in 0..self.fingers {
            let (before_n, now_n) = (&pinned.force_n[finger], &frame.force_n[finger]);
            let stuck = self.stuck[finger].update(before_n, now_n, elements);
            let newly = stuck & !self.were_stuck[finger];
            self.were_stuck[finger] = stuck;
            if newly != 0 {
                first = first.or(Some((finger, newly.trailing_zeros())));
            }
        }
        if let Some((fingertip, element)) = first {
            self.warn(Reason::ElementStuck {
                hand: self.hand,
                fingertip,
                element,
            });
        }
    }

    fn count(&mut self, refusal: Rejection, frame: &HandFrame, tick: Tick, limits: &Limits) {
        match refusal {
            Rejection::Corrupt => {
                self.counts.corrupt += 1;
                self.warn(Reason::FrameCorrupt {
                    hand: self.hand,
                    corrupt: self.counts.corrupt,
                });
            }
            Rejection::Foreign => {
                self.counts.foreign += 1;
                self.warn(Reason::FrameForeign { hand: self.hand });
            }
            Rejection::Mistimed => {
                self.counts.mistimed += 1;
                self.warn(mistimed(self.hand, frame, tick, limits));
            }
            Rejection::Duplicate => self.counts.duplicates += 1,
            Rejection::Reordered => self.counts.reordered += 1,
            Rejection::Resyncing => self.escalate(Reason::SensorRestarted { hand: self.hand }),
        }
    }

    /// Keeps the first reason of a tick, which usually explains the later ones.
    fn escalate(&mut self, reason: Reason) {
        if !self.hold_reason.is_some() {
            self.hold_reason = reason;
        }
    }

    fn warn(&mut self, reason: Reason) {
        if !self.warning.is_some() {
            self.warning = reason;
        }
    }
}

type Forces = [[[f32; 3]; ELEMENTS]; FINGERS];

/// Returns the set of believable elements: no axis is above the limit, not a number or denormal. No
/// sensor resolves a denormal force; a broken decoder reads it instead of a grip.
fn believable(readings_n: &[[f32; 3]], limit_n: f32) -> u64 {
    // The bits of positive numbers have the order of the numbers; those of NaN are above. Without
    // branches over all values, because nearly all frames are valid as a whole.
    let is_valid = |axis: &f32| {
        let magnitude = axis.to_bits() & !SIGN_BIT;
        (magnitude <= limit_n.to_bits()) & ((magnitude == 0) | (magnitude >= MIN_NORMAL_BITS))
    };
    let values_n = readings_n.as_flattened().iter();
    if values_n.fold(true, |all, axis| all & is_valid(axis)) {
        return u64::MAX >> (ELEMENTS - readings_n.len());
    }
    let elements = readings_n.iter().enumerate();
    elements.fold(0, |set, (element, axes)| {
        set | u64::from(axes.iter().all(is_valid)) << element
    })
}

/// Returns the largest single-precision number at or below a positive limit.
fn largest_at_most(limit: f64) -> f32 {
    let nearest = limit as f32;
    if f64::from(nearest) > limit {
        nearest.next_down()
    } else {
        nearest
    }
}

/// Compares bitwise, because NaN never equals itself.
fn same_bits(a: &Forces, b: &Forces) -> bool {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    a.as_flattened()
        .iter()
        .zip(b.as_flattened())
        .all(|(a, b)| a.to_bits() == b.to_bits())
}

fn mistimed(hand: Hand, frame: &HandFrame, tick: Tick, limits: &Limits) -> Reason {
    let ahead_s = seconds_between(tick.now_ns, frame.stamp.captured_ns);
    if ahead_s > 0.0 {
        Reason::FrameFuture {
            hand,
            ahead_ns: ahead_s * 1e9,
            limit_ns: limits.future_s * 1e9,
        }
    } else {
        Reason::FrameStale {
            hand,
            age_ns: -ahead_s * 1e9,
            limit_ns: limits.reject_age_s * 1e9,
        }
    }
}
