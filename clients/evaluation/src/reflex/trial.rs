//! One trial: a member of an object's family, a clumsy policy, and what truly became of the object.

use std::collections::VecDeque;

use anyhow::Context;
use atas_core::{Goal, Order, Settings};
use robot_model::{RobotModel, VIRTUAL_FINGERS};
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, Hand, Stamp};
use sim_backend::random::Random;
use sim_backend::{Object, Scene};

use super::onset::Onsets;
use super::script::{LATENCY_TICKS, LIFT_M, Script};
use crate::judge::{SLIP_MAX_M, TURN_MAX_RAD};
use crate::offline::OfflineRun;
use crate::task::SIDE;
use crate::trial_seed;

/// Epoch of the policy as a writer (ours: any but a sensor's).
const POLICY: u64 = 0x706f_6c69_6379;
/// The policy's stream of random numbers.
const POLICY_STREAM: u64 = 0x6a65_726b;
/// Share of the lift that the object must truly have risen at the end, and force of a finger that still presses, N: as for the
/// grasp.
const LIFTED_SHARE: f64 = 0.5;
const PRESSED_N: f64 = 0.03;
/// A touch that no fingertip ever feels, N: what makes the hand obey widths as they are.
const NEVER_N: f64 = 10_000.0;
/// The step in which a led hand carries.
const CARRIES: &str = "carry";

/// What became of one trial.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Why it is no success; `None` if it is.
    pub(super) failure: Option<String>,
    /// Whether the object was crushed, whatever else.
    pub(super) crushed: bool,
    /// Whether the policy closed too weakly.
    pub(super) weakly: bool,
    /// The slips of what was carried.
    pub(super) onsets: Onsets,
    /// Mean true normal force of both sides in the end over the force that keeps the object from sliding; nothing of one that is not
    /// in the hand as it was taken.
    pub(super) over_grip: Option<f64>,
}

/// The settings of a hand without the reflex: it feels nothing.
pub(super) fn numb(settings: &Settings) -> Settings {
    let mut settings = *settings;
    settings.perception.touch_on_n = NEVER_N;
    settings.perception.touch_off_n = NEVER_N;
    settings
}

/// Runs the policy on a member of the object's family.
pub(super) fn run(
    robot: &RobotModel,
    object: &Object,
    number: u64,
    settings: &Settings,
) -> anyhow::Result<Trial> {
    let seed = trial_seed(&object.name, number);
    let scene = Scene::grasp(object.clone(), SIDE).varied(seed);
    let hint = scene.grasp_hint(0).context("a grasp has its object")?;
    let mut run = OfflineRun::new(robot, &scene, seed, *settings)?;
    let hand = Hand::BOTH[SIDE.index()];
    let random = Random::new(seed, POLICY_STREAM);
    let mut script = Script::new(hint, hand, number.is_multiple_of(2), random);
    let mut order = Some(follow(&run, robot, hand)?);
    let mut late = VecDeque::new();
    let mut onsets = Onsets::default();
    let mut ended = None;
    for tick in 0..Script::ticks() {
        let made = script.make(tick, run.world().now_ns(), POLICY);
        late.extend(made.map(|target| (tick + LATENCY_TICKS, target)));
        while late.front().is_some_and(|(due, _)| *due <= tick) {
            late.pop_front()
                .into_iter()
                .for_each(|(_, target)| run.lead(target));
        }
        let outputs = *run.step(order.take().as_ref());
        let ends = outputs.goal_update.filter(|update| update.state.is_final());
        ended = ended.or(ends);
        let carries = run.controller().step_name() == CARRIES;
        let report = &outputs.report.hands[SIDE.index()];
        onsets.watch(tick, run.world(), SIDE.index(), report, carries);
    }
    if let Some(fault) = run.world().fault() {
        return Err(fault).with_context(|| format!("object {:?}, seed {number}", object.name));
    }
    let truth = run.world().truth();
    let object = &truth.objects[0];
    let sides_n = &truth.normal_n[SIDE.index()][..VIRTUAL_FINGERS];
    let pressed = sides_n.iter().all(|n| *n > PRESSED_N);
    let failure = match () {
        () if object.crushed != 0 => Some("crushed".to_owned()),
        () if object.dropped != 0 => Some("dropped".to_owned()),
        () if !(pressed && object.lifted_m >= LIFTED_SHARE * LIFT_M) => Some(match ended {
            Some(update) => format!("not lifted: {} in {}", update.reason.cause, update.step),
            None => "not lifted".to_owned(),
        }),
        () if object.slip_in_hand_m > SLIP_MAX_M => Some("slipped in the hand".to_owned()),
        () if object.turn_in_hand_rad > TURN_MAX_RAD => Some("turned in the hand".to_owned()),
        () => None,
    };
    let mean_n = sides_n.iter().sum::<f64>() / VIRTUAL_FINGERS as f64;
    let over_grip = mean_n / scene.objects[0].object.needed_n();
    Ok(Trial {
        over_grip: failure.is_none().then_some(over_grip),
        failure,
        crushed: object.crushed != 0,
        weakly: script.is_weak(),
        onsets,
    })
}

/// The goal that opens the stream.
fn follow(run: &OfflineRun, robot: &RobotModel, hand: Hand) -> anyhow::Result<Order> {
    let request = GoalRequest {
        stamp: Stamp {
            captured_ns: run.world().now_ns(),
            writer_epoch: POLICY,
            ..Stamp::default()
        },
        goal_id: 1,
        kind: GoalKind::FOLLOW,
        hand,
        policy: GoalPolicy::ATTACHED,
        ..GoalRequest::default()
    };
    let now = run.controller().circumstances(robot, &[]);
    let goal: Result<Goal, _> = atas_core::check::check(&request, &now);
    Ok(Order::Start(goal.map_err(|reason| {
        anyhow::anyhow!("could not follow because {reason}")
    })?))
}
