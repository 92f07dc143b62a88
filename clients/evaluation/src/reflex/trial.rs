//! One trial: a family member, a coarse position policy, and the true outcome.

use std::collections::VecDeque;

use anyhow::Context;
use atas_core::{Goal, OperatorRequest, Settings};
use robot_model::RobotModel;
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, Hand, Stamp};
use sim_backend::random::Random;
use sim_backend::{Object, Scene};

use super::coarse_policy::{CoarsePolicy, LATENCY_TICKS, LIFT_M};
use super::onset::Onsets;
use crate::SIDE;
use crate::judge::{SLIP_MAX_M, TURN_MAX_RAD};
use crate::offline::OfflineRun;
use crate::trial_seed;

/// Writer epoch of the policy. Any value different from a sensor's.
const POLICY_EPOCH: u64 = 0x706f_6c69_6379;
/// Random stream of the policy.
const POLICY_STREAM: u64 = 0x6a65_726b;
/// Minimum share of the lift, and normal force (N) of a grasp side in contact; as for the grasp.
const LIFTED_SHARE: f64 = 0.5;
const CONTACT_N: f64 = 0.03;
/// Touch threshold that no force reaches, N: the hand executes commanded widths.
const UNREACHABLE_TOUCH_N: f64 = 10_000.0;
/// Step of a teleoperated hand that carries an object.
const CARRY_STEP: &str = "carry";

#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Failure key.
    pub(super) failure: Option<String>,
    pub(super) crushed: bool,
    pub(super) weakly: bool,
    pub(super) onsets: Onsets,
    /// Mean final normal force over the force against sliding; `None` without success.
    pub(super) over_grip: Option<f64>,
}

pub(super) fn without_reflex(settings: &Settings) -> Settings {
    let mut settings = *settings;
    settings.perception.touch_on_n = UNREACHABLE_TOUCH_N;
    settings.perception.touch_off_n = UNREACHABLE_TOUCH_N;
    settings
}

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
    let mut script = CoarsePolicy::new(hint, hand, number.is_multiple_of(2), random);
    let mut order = Some(teleop_request(&run, robot, hand)?);
    let mut late = VecDeque::new();
    let sides = robot.hand(SIDE).grasp_sides();
    let mut onsets = Onsets::new(sides);
    let mut ended = None;
    for tick in 0..CoarsePolicy::ticks() {
        let made = script.target(tick, run.world().now_ns(), POLICY_EPOCH);
        late.extend(made.map(|target| (tick + LATENCY_TICKS, target)));
        while late.front().is_some_and(|(due, _)| *due <= tick) {
            late.pop_front()
                .into_iter()
                .for_each(|(_, target)| run.push_target(target));
        }
        let outputs = *run.step(order.take().as_ref());
        let ends = outputs.goal_update.filter(|update| update.state.is_final());
        ended = ended.or(ends);
        let carries = run.controller().step_name() == CARRY_STEP;
        let report = &outputs.report.hands[SIDE.index()];
        onsets.update(tick, run.world(), SIDE.index(), report, carries);
    }
    if let Some(fault) = run.world().fault() {
        return Err(fault).with_context(|| format!("object {:?}, seed {number}", object.name));
    }
    let truth = run.world().truth();
    let object = &truth.objects[0];
    let normal_n = |fingertip: usize| truth.normal_n[SIDE.index()][fingertip];
    let pressed = sides.both_exceed(CONTACT_N, normal_n);
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
    let over_grip = sides.mean_sum(normal_n) / scene.objects[0].object.required_normal_n();
    Ok(Trial {
        over_grip: failure.is_none().then_some(over_grip),
        failure,
        crushed: object.crushed != 0,
        weakly: script.is_weak(),
        onsets,
    })
}

fn teleop_request(
    run: &OfflineRun,
    robot: &RobotModel,
    hand: Hand,
) -> anyhow::Result<OperatorRequest> {
    let request = GoalRequest {
        stamp: Stamp {
            captured_ns: run.world().now_ns(),
            writer_epoch: POLICY_EPOCH,
            ..Stamp::default()
        },
        goal_id: 1,
        kind: GoalKind::TELEOP,
        hand,
        policy: GoalPolicy::ATTACHED,
        ..GoalRequest::default()
    };
    let now = run.controller().goal_context(robot, &[]);
    let goal: Result<Goal, _> = atas_core::check::check(&request, &now);
    Ok(OperatorRequest::Start(goal.map_err(|reason| {
        anyhow::anyhow!("could not start the teleoperation: {reason}")
    })?))
}
