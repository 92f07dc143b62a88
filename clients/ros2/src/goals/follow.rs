//! The daemon as hardware of ros2_control: joint commands of one hand as a stream of targets.
//!
//! `joint_state_topic_hardware_interface` publishes the commands of its controllers as joint states
//! and reads `/joint_states`. It is silent while its commands do not change, so silence keeps the
//! last target. The daemon moves the hand, not single joints: commands set place, direction and
//! opening of the hand, and the controller keeps the reflexes.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use robot_model::HandSide;
use shm_schemas::Hand;
use shm_schemas::capacity::JOINTS;

use super::grippers::Grippers;
use super::scene::Scene;
use super::stream::{ANSWER, Stream, target};
use crate::link::BusLink;
use crate::middleware::{Node, Quality, Subscribe};
use crate::wire::standard::JointState;

/// Silence after which the stream of an empty hand ends, so that other goals can run; the next
/// command opens it again. Design choice.
const IDLE: Duration = Duration::from_secs(10);

/// Follower of joint commands.
pub(super) struct Follow {
    commands: Box<dyn Subscribe<JointState>>,
    hand: Hand,
    /// Commanded positions by joint.
    wanted: BTreeMap<String, f64>,
    stream: Option<Stream>,
    commanded: Option<Instant>,
    /// True while a command waits for its first target.
    pending: bool,
    /// Last reported problem.
    problem: String,
}

impl Follow {
    pub(super) fn open(node: &mut Node, namespace: &str, hand: Hand) -> anyhow::Result<Self> {
        Ok(Self {
            commands: commands(node, namespace)?,
            hand,
            wanted: BTreeMap::new(),
            stream: None,
            commanded: None,
            pending: false,
            problem: String::new(),
        })
    }

    /// Continues with another participant.
    pub(super) fn reopen(&mut self, node: &mut Node, namespace: &str) -> anyhow::Result<()> {
        self.commands = commands(node, namespace)?;
        Ok(())
    }

    pub(super) fn poll(
        &mut self,
        link: &mut BusLink,
        scene: Option<&Scene>,
        grippers: &mut Grippers,
    ) {
        self.receive();
        let done = self.advance(link, scene, grippers);
        let problem = done.err().unwrap_or_default();
        if !problem.is_empty() && problem != self.problem {
            tracing::warn!("joint commands not executed: {problem}");
        }
        self.problem = problem;
    }

    fn receive(&mut self) {
        loop {
            match self.commands.take() {
                Ok(Some(command)) => match checked(&command) {
                    Ok(()) => {
                        let names = command.name.into_iter().zip(command.position);
                        self.wanted.extend(names);
                        (self.commanded, self.pending) = (Some(Instant::now()), true);
                    }
                    Err(why) => tracing::warn!("joint command ignored: {why}"),
                },
                Ok(None) => return,
                Err(error) => tracing::warn!("joint command ignored: {error:#}"),
            }
        }
    }

    fn advance(
        &mut self,
        link: &mut BusLink,
        scene: Option<&Scene>,
        grippers: &mut Grippers,
    ) -> Result<(), String> {
        if let Some(stream) = &mut self.stream
            && !stream.keep()
        {
            let (text, was_wanted) = (stream.text(), stream.ending.is_some());
            self.stream = None;
            if was_wanted {
                return Ok(());
            }
            self.pending = false;
            return Err(format!("the daemon ended the stream: {text}"));
        }
        let idle = self.commanded.is_none_or(|since| since.elapsed() > IDLE);
        if idle && let Some(stream) = self.stream.as_mut().filter(|of| !of.grips()) {
            stream.end();
        }
        if self
            .stream
            .as_ref()
            .is_some_and(|stream| stream.ending.is_some())
        {
            // A command that arrives now opens the next stream.
            return Ok(());
        }
        let Some(scene) = scene.filter(|_| self.pending) else {
            return Ok(());
        };
        let side = HandSide::BOTH[self.hand.index().unwrap_or(0)];
        let Some(place) = scene.with_joints(side, &self.wanted) else {
            return Ok(());
        };
        if self.stream.is_none() {
            if !grippers.make_way() || scene.is_arming() {
                return Ok(());
            }
            let now = scene.commanded(side).ok_or("no joint states")?;
            let session = link.session().map_err(|error| error.to_string())?;
            let stream = Stream::open(session, self.hand, &now, 0.0);
            self.pending = stream.is_ok();
            self.stream = Some(stream.map_err(|error| error.to_string())?);
        }
        let Some(stream) = &mut self.stream else {
            return Ok(());
        };
        if stream.is_accepted() {
            stream.target = target(self.hand, &place);
            self.pending = false;
        } else if stream.opened.elapsed() > ANSWER {
            (self.stream, self.pending) = (None, false);
            return Err(format!("no answer from the daemon within {ANSWER:?}"));
        }
        Ok(())
    }
}

fn commands(node: &mut Node, namespace: &str) -> anyhow::Result<Box<dyn Subscribe<JointState>>> {
    node.subscription(&format!("{namespace}/joint_commands"), Quality::STREAM)
}

/// Returns an error unless a command has a finite position per name.
fn checked(command: &JointState) -> Result<(), String> {
    let (names, positions) = (command.name.len(), command.position.len());
    if names != positions || names == 0 || names > JOINTS {
        return Err(format!(
            "it has {names} names and {positions} positions; give 1 to {JOINTS} of both"
        ));
    }
    let wrong = command
        .position
        .iter()
        .find(|position| !position.is_finite());
    wrong.map_or(Ok(()), |position| {
        Err(format!("a position is {position}; give finite numbers"))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invalid_joint_commands_are_ignored_with_cause() {
        let check = |names: usize, positions: &[f64], part: &str| {
            let command = JointState {
                name: vec!["joint".to_owned(); names],
                position: positions.to_vec(),
                ..JointState::default()
            };
            let error = checked(&command).err().unwrap_or_default();
            assert!(error.contains(part), "{error}");
            assert_eq!(error.is_empty(), part.is_empty(), "{error}");
        };
        check(1, &[0.5], "");
        check(0, &[], "0 names");
        check(2, &[0.5], "2 names and 1 positions");
        check(1, &[f64::NAN], "a position is NaN");
        check(JOINTS + 1, &[0.0; JOINTS + 1], "positions; give 1 to");
    }
}
