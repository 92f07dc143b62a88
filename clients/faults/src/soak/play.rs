//! Play of an episode under the judge.

use std::collections::VecDeque;

use atas_core::OperatorRequest;
use atas_core::settings::PARAMETERS;
use atas_evaluation::offline::OfflineRun;
use atas_judge::{Allowance, Judge, Promise, Violation};
use shm_schemas::{GoalRequest, Mode, Reason};
use sim_backend::TICK_NS;
use sim_backend::faults::{Fault, FaultPipeline};

use super::episode::Episode;
use super::event::EventKind;
use crate::course::joint_bounds;
use crate::verdict::is_lifted;

const STOPPED: &[Mode] = &[Mode::SAFE_STOP, Mode::FAULT];

/// Result of a play.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Played {
    /// Ticks that the world has run.
    pub(super) ticks: u64,
    pub(super) violations: u64,
    /// First violation, and the number of ticks that show it.
    pub(super) first: Option<(Violation, u64)>,
}

/// Run in progress.
struct Play<'a> {
    episode: &'a Episode<'a>,
    run: OfflineRun,
    judge: Judge,
    /// Requests that wait for the next tick; one per tick.
    requests: VecDeque<OperatorRequest>,
    first: Option<(Violation, u64)>,
    /// Mode of the last command.
    mode: Mode,
    next_goal_id: u64,
}

/// Plays an episode for this number of ticks. With `is_short`, ends at the first violation.
pub(super) fn play(episode: &Episode<'_>, ticks: u64, is_short: bool) -> anyhow::Result<Played> {
    let mut play = Play::new(episode)?;
    let mut events = episode.events.iter().peekable();
    while play.run.ticks() < ticks {
        while let Some(event) = events.next_if(|event| event.tick <= play.run.ticks()) {
            play.act(&event.kind);
        }
        play.step();
        if is_short && play.first.is_some() {
            break;
        }
    }
    Ok(Played {
        ticks: play.run.ticks(),
        violations: play.judge.violation_count(),
        first: play.first,
    })
}

impl<'a> Play<'a> {
    fn new(episode: &'a Episode<'a>) -> anyhow::Result<Self> {
        let settings = episode.settings;
        let mut run = OfflineRun::new(episode.robot, &episode.scene, episode.seed, settings)?;
        let faults: Result<Vec<Fault>, _> = episode
            .events
            .iter()
            .filter_map(|event| match &event.kind {
                EventKind::Fault(text) => Some(text.parse()),
                _ => None,
            })
            .collect();
        run.inject(FaultPipeline::new(&faults?, episode.seed));
        let valid_ns = (settings.safety.valid_s * 1e9).round() as u64;
        let judge = Judge::new(joint_bounds(episode.robot), TICK_NS, valid_ns)?;
        let mut play = Self {
            episode,
            run,
            judge: judge.allowing(Allowance::MissedTicks),
            requests: VecDeque::new(),
            first: None,
            mode: Mode::INIT,
            next_goal_id: episode.goal.goal_id,
        };
        play.send(episode.goal);
        Ok(play)
    }

    fn step(&mut self) {
        let request = self.requests.pop_front();
        match &request {
            Some(OperatorRequest::Recover) => {
                // A recovery without a stop permits no transition.
                if self.mode == Mode::SAFE_STOP {
                    self.judge.recover_requested();
                }
                self.judge.release_grip();
            }
            Some(OperatorRequest::Stop(_)) => self.judge.promise(Promise::reach(STOPPED, 0)),
            Some(OperatorRequest::Start(_)) => self.judge.release_grip(),
            _ => {}
        }
        let command = self.run.step(request.as_ref()).command;
        self.mode = command.mode;
        let truth = self.run.world().truth();
        self.judge.observe(&command, &truth);
        if self.first.is_none()
            && let Some(violation) = self.judge.violations().first()
        {
            self.first = Some((violation.clone(), self.run.ticks()));
        }
        if matches!(request, Some(OperatorRequest::Stop(_))) && is_lifted(&truth.objects[0]) {
            // A lifted object is in the hand, so this cannot fail.
            let _ = self.judge.expect_grip_kept(0);
        }
    }

    fn act(&mut self, event: &EventKind) {
        let goal_id = self.next_goal_id;
        match *event {
            // The pipeline of faults is complete from the start.
            EventKind::Fault(_) => {}
            EventKind::Pause(ticks) => self.run.pause_controller(ticks),
            EventKind::Restart(ticks) => {
                self.run.pause_controller(ticks);
                self.run.restart_controller();
                self.judge.restarted();
                self.requests.clear();
            }
            EventKind::Stop => self.queue(OperatorRequest::Stop(Reason::Estop)),
            EventKind::Recover => self.queue(OperatorRequest::Recover),
            EventKind::Hold => {
                self.queue(OperatorRequest::Hold(Reason::SupervisorSilent {
                    silent_s: 0.0,
                    limit_s: 0.0,
                }));
            }
            EventKind::Cancel => self.queue(OperatorRequest::Cancel { goal_id }),
            EventKind::Disconnect => self.queue(OperatorRequest::ClientDisconnected { goal_id }),
            EventKind::Goal(error_m) => {
                let mut goal = self.episode.goal;
                for (coordinate, error_m) in goal.from_m.iter_mut().zip(error_m) {
                    *coordinate += error_m;
                }
                self.next_goal_id += 1;
                goal.goal_id = self.next_goal_id;
                self.send(goal);
            }
            EventKind::Parameter(index, value) => {
                debug_assert!(index < PARAMETERS.len());
                self.queue(OperatorRequest::SetParameter { index, value });
            }
            EventKind::Bias(hand) => self.queue(OperatorRequest::Bias { hand }),
        }
    }

    fn queue(&mut self, request: OperatorRequest) {
        self.requests.push_back(request);
    }

    /// Sends a goal; the daemon rejects one during another, or one that is impossible now.
    fn send(&mut self, goal: GoalRequest) {
        let is_busy = self.run.controller().goal().is_some();
        if let (false, Ok(request)) = (is_busy, self.run.request(&goal)) {
            self.queue(request);
        }
    }
}
