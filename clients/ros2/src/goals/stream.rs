//! Stream of teleoperation targets for one hand.

use std::time::{Duration, Instant};

use atas_client::{ClientError, Session, TeleopHands, TeleopSender, TeleopTarget};
use robot_model::PinchPose;
use shm_schemas::Hand;

/// Interval of targets. Design choice: half the interval of a keyboard.
const INTERVAL: Duration = Duration::from_millis(25);
/// Validity of a target, ns. Design choice: several times the delay on a busy computer.
const VALID_NS: u64 = 400_000_000;
/// Longest wait for the daemon's answer and for the end of a stream.
pub(super) const ANSWER: Duration = Duration::from_secs(2);
/// Step of a hand that holds an object, as in the controller's table.
const GRIPPED: &str = "carry";

/// Open stream.
pub(super) struct Stream {
    pub(super) sender: TeleopSender,
    pub(super) hand: Hand,
    pub(super) target: TeleopTarget,
    pub(super) max_force_n: f64,
    pub(super) opened: Instant,
    pub(super) sent: Option<Instant>,
    /// True while the hand holds an object.
    pub(super) gripped: bool,
    /// Set when the end was requested.
    pub(super) ending: Option<Instant>,
}

impl Stream {
    /// Opens a stream at the present place of a hand.
    pub(super) fn open(
        session: &Session,
        hand: Hand,
        place: &PinchPose,
        max_force_n: f64,
    ) -> Result<Self, ClientError> {
        Ok(Self {
            sender: TeleopSender::open_limited(session, TeleopHands::One(hand), max_force_n)?,
            hand,
            target: target(hand, place),
            max_force_n,
            opened: Instant::now(),
            sent: None,
            gripped: false,
            ending: None,
        })
    }

    /// Requests the end of the stream; the hand keeps its place and grip.
    pub(super) fn end(&mut self) {
        if self.ending.is_none() {
            self.sender.end();
            self.ending = Some(Instant::now());
        }
    }

    /// Sends the last target again; returns false if the stream has ended or is lost.
    pub(super) fn keep(&mut self) -> bool {
        if self.poll().is_err() || self.sender.has_ended() {
            return false;
        }
        match self.ending {
            Some(since) => since.elapsed() < ANSWER,
            None => self.send().is_ok(),
        }
    }
    pub(super) fn poll(&mut self) -> Result<(), ClientError> {
        let progress = self.sender.poll()?;
        self.gripped = progress.last().step.as_str() == GRIPPED;
        Ok(())
    }

    pub(super) fn is_accepted(&mut self) -> bool {
        let is_known = self
            .sender
            .poll()
            .is_ok_and(|progress| progress.last().goal_id != 0);
        is_known && self.sender.now_ns() != 0
    }

    pub(super) fn step(&mut self) -> String {
        let progress = self.sender.poll().ok();
        progress.map_or_else(String::new, |of| of.last().step.to_string())
    }

    pub(super) fn text(&mut self) -> String {
        self.sender
            .poll()
            .map_or_else(|error| error.to_string(), |of| of.text())
    }

    pub(super) fn grips(&self) -> bool {
        self.gripped
    }

    pub(super) fn send(&mut self) -> Result<(), ClientError> {
        if self.sent.is_some_and(|sent| sent.elapsed() < INTERVAL) {
            return Ok(());
        }
        self.sent = Some(Instant::now());
        self.sender.send(&self.target, VALID_NS)
    }
}

/// Returns the target that keeps a place.
pub(super) fn target(hand: Hand, place: &PinchPose) -> TeleopTarget {
    let [x, y, z] = [place.centre_m.x, place.centre_m.y, place.centre_m.z];
    TeleopTarget {
        hand,
        centre_m: [x, y, z],
        yaw_rad: place.closing_yaw_rad,
        opening_m: Some(place.opening_m.max(0.0)),
    }
}
