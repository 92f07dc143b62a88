//! Gripper commands as a stream of teleoperation targets: the hand keeps its place, and the
//! controller closes the fingers and chooses the force by touch.
//!
//! The stream stays open while the hand holds an object, so that a later command can open it. It
//! ends after a command without a grip, on cancellation, and before any other goal of the bridge;
//! the hand then keeps its grip.

use std::time::{Duration, Instant};

use atas_client::Session;
use shm_schemas::Hand;

use super::gripper_action::{Command, GripperState};
use super::limits::{check_force, check_opening, force_n, side};
use super::scene::Scene;
use super::stream::{ANSWER, Stream};

/// Time after a new target before its effect is judged. Design choice: ten statuses.
const EFFECT: Duration = Duration::from_millis(200);
/// Distance to the commanded opening that counts as reached, m. Design choice: finger lag at rest.
const REACHED_M: f64 = 0.001;
/// Change of the opening that counts as motion, m. Design choice: above the noise of encoders.
const MOTION_M: f64 = 0.0002;
/// Rest after which free fingers count as stalled. Design choice.
const REST: Duration = Duration::from_secs(3);
/// Longest command. Design choice: the daemon's own limits of touch, probe and grip, 28 s.
const COMMAND_MAX: Duration = Duration::from_secs(30);

/// Step of a teleoperated hand with free fingers, as in the controller's table.
const FREE: &str = "teleop";

/// End of a command.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Ended {
    /// Executed, with or without reaching the opening.
    Done(GripperState),
    /// Not executed; the state has the cause.
    Failed(GripperState),
    /// Cancelled; the hand keeps its grip.
    Cancelled(GripperState),
}

struct Running {
    hand: Hand,
    command: Command,
    since: Instant,
    /// First target of this command.
    targeted: Option<Instant>,
    /// Last opening that differed, and its time.
    moved: (f64, Instant),
    cancelled: bool,
}

/// Grippers of all hands; one at a time moves.
#[derive(Default)]
pub(super) struct Gripper {
    stream: Option<Stream>,
    running: Option<Running>,
}

impl Gripper {
    /// Starts a command. The caller has ended the previous one.
    pub(super) fn start(&mut self, hand: Hand, command: Command) {
        let now = Instant::now();
        self.running = Some(Running {
            hand,
            command,
            since: now,
            targeted: None,
            moved: (f64::NAN, now),
            cancelled: false,
        });
    }

    /// Cancels the command.
    pub(super) fn cancel(&mut self) {
        if let Some(running) = &mut self.running {
            running.cancelled = true;
        }
        self.end_stream();
    }

    /// Forgets the stream of a daemon that is gone.
    pub(super) fn forget(&mut self) {
        self.stream = None;
    }

    /// Ends an idle stream; returns true if there is none.
    pub(super) fn make_way(&mut self) -> bool {
        if self.running.is_none() {
            self.end_stream();
        }
        self.stream.is_none() || self.running.is_some()
    }

    fn end_stream(&mut self) {
        if let Some(stream) = &mut self.stream {
            stream.end();
        }
    }

    /// Returns opening and force of a hand.
    pub(super) fn state(&self, hand: Hand, scene: &Scene) -> GripperState {
        let opening_m = scene
            .measured(side(hand))
            .map_or(0.0, |pose| pose.opening_m);
        GripperState {
            opening_m,
            force_n: force_n(hand, scene),
            ..GripperState::default()
        }
    }

    /// Advances the command and the stream; returns the end of the command.
    pub(super) fn poll(&mut self, session: &Session, scene: &Scene) -> Option<Ended> {
        let Some(hand) = self.running.as_ref().map(|running| running.hand) else {
            self.keep_idle_stream();
            return None;
        };
        let state = self.state(hand, scene);
        let ended = match self.advance(session, scene, &state) {
            Ok(ended) => ended,
            Err(cause) => Some(Ended::Failed(GripperState { cause, ..state })),
        };
        if ended.is_some() {
            self.running = None;
            if !self.stream.as_ref().is_some_and(Stream::grips) {
                self.end_stream();
            }
        }
        ended
    }

    /// Sends the last target again, so that the hand keeps its place and grip.
    fn keep_idle_stream(&mut self) {
        if self.stream.as_mut().is_some_and(|stream| !stream.keep()) {
            self.stream = None;
        }
    }

    fn advance(
        &mut self,
        session: &Session,
        scene: &Scene,
        state: &GripperState,
    ) -> Result<Option<Ended>, String> {
        let Some(running) = &mut self.running else {
            return Ok(None);
        };
        if let Some(stream) = &mut self.stream {
            stream.poll().map_err(|error| error.to_string())?;
            if stream.sender.has_ended() {
                let text = stream.text();
                let was_wanted = stream.ending.is_some();
                self.stream = None;
                if running.cancelled {
                    return Ok(Some(Ended::Cancelled(state.clone())));
                }
                // A stream that ended for this command is replaced below.
                if !was_wanted {
                    return Err(format!("goal ended by the daemon: {text}"));
                }
            } else if let Some(since) = stream.ending {
                if since.elapsed() > ANSWER {
                    self.stream = None;
                    return Err(format!(
                        "the daemon did not end the previous goal in {ANSWER:?}"
                    ));
                }
                return Ok(None);
            }
        } else if running.cancelled {
            return Ok(Some(Ended::Cancelled(state.clone())));
        }
        if running.since.elapsed() > COMMAND_MAX {
            return Err(format!("the command took longer than {COMMAND_MAX:?}"));
        }
        if self.is_unfit_stream(state.opening_m)? {
            self.end_stream();
            return Ok(None);
        }
        self.open_stream(session, scene)?;
        self.judge(state)
    }

    /// Returns true if the open stream cannot execute the command.
    fn is_unfit_stream(&self, opening_m: f64) -> Result<bool, String> {
        let (Some(stream), Some(running)) = (&self.stream, &self.running) else {
            return Ok(false);
        };
        if stream.hand != running.hand {
            return Ok(true);
        }
        let (has_n, wants_n) = (stream.max_force_n, running.command.max_force_n);
        if (has_n - wants_n).abs() < f64::EPSILON || running.targeted.is_some() {
            return Ok(false);
        }
        let opens = running.command.opening_m > opening_m + REACHED_M;
        if stream.grips() && !opens {
            return Err(format!(
                "goal rejected: max_effort is {wants_n} N, but the grip of the held object has \
                 {has_n} N; open the hand first"
            ));
        }
        Ok(!stream.grips())
    }

    /// Opens a stream if there is none, after validating the command.
    fn open_stream(&mut self, session: &Session, scene: &Scene) -> Result<(), String> {
        let Some(running) = &self.running else {
            return Ok(());
        };
        if self.stream.is_some() || (scene.is_arming() && running.since.elapsed() < ANSWER) {
            return Ok(());
        }
        let (hand, command) = (running.hand, running.command);
        let Some(place) = scene.commanded(side(hand)) else {
            if running.since.elapsed() < ANSWER {
                return Ok(());
            }
            return Err(format!(
                "goal rejected: no joint states of the {hand} hand; check `atas status`"
            ));
        };
        check_opening(command.opening_m, hand, scene)?;
        check_force(command.max_force_n, session)?;
        let stream = Stream::open(session, hand, &place, command.max_force_n)
            .map_err(|error| format!("goal not sent: {error}"))?;
        self.stream = Some(stream);
        Ok(())
    }

    /// Sends the target and judges its effect.
    fn judge(&mut self, state: &GripperState) -> Result<Option<Ended>, String> {
        let (Some(stream), Some(running)) = (&mut self.stream, &mut self.running) else {
            return Ok(None);
        };
        if !stream.is_accepted() {
            return if stream.opened.elapsed() > ANSWER {
                Err(format!(
                    "no answer from the daemon within {ANSWER:?}; see `atas status`"
                ))
            } else {
                Ok(None)
            };
        }
        let wanted_m = running.command.opening_m;
        let now = Instant::now();
        if running.targeted.is_none() {
            (running.targeted, running.moved) = (Some(now), (state.opening_m, now));
            (stream.target.opening_m, stream.sent) = (Some(wanted_m), None);
        }
        stream
            .send()
            .map_err(|error| format!("target not sent: {error}"))?;
        if (state.opening_m - running.moved.0).abs() > MOTION_M {
            running.moved = (state.opening_m, now);
        }
        if running
            .targeted
            .is_some_and(|since| since.elapsed() < EFFECT)
        {
            return Ok(None);
        }
        let step = stream.step();
        let reached = (state.opening_m - wanted_m).abs() < REACHED_M;
        let rests = running.moved.1.elapsed() > REST;
        if stream.grips() || (step == FREE && reached) {
            return Ok(Some(Ended::Done(GripperState {
                stalled: !reached,
                reached,
                ..state.clone()
            })));
        }
        if step == FREE && rests {
            let cause = format!(
                "the fingers stopped at {:.1} mm, commanded {:.1} mm; check the space around the \
                 hand",
                state.opening_m * 1e3,
                wanted_m * 1e3
            );
            return Ok(Some(Ended::Failed(GripperState {
                stalled: true,
                cause,
                ..state.clone()
            })));
        }
        Ok(None)
    }
}
