//! Verdict on the reaction to one fault.

use anyhow::Context;
use atas_judge::{Allowance, GripError, Judge, Promise, ViolationKind};
use shm_schemas::{GoalState, ObjectTruth};

use crate::catalogue::{Fault, Reaction};
use crate::course::{Course, Phase, Progress};
use crate::injection::Injection;

/// Ticks that a run continues after the last required one. Design choice: an object that the hand
/// no longer holds falls by 5 m in this time.
pub(crate) const WATCH_TICKS: u64 = 1000;
/// Height above which an object counts as lifted, m. Design choice: above the vibration of the arm.
const LIFTED_M: f64 = 0.003;

/// Verdict on one run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Verdict {
    /// Number of the fault.
    pub fault: &'static str,
    /// Task.
    pub task: &'static str,
    /// Phase of the task in which the fault began.
    pub phase: String,
    /// Seed.
    pub seed: u64,
    /// Ticks until the required mode; `None` if none is required, or it did not appear.
    pub ticks: Option<u64>,
    /// First reason why the run failed; `None` if it passed.
    pub failure: Option<String>,
    /// Reason why this machine cannot show the fault.
    pub skipped: Option<String>,
    /// True: a command exceeded its limits, or an object was lost or harmed.
    pub is_unsafe: bool,
}

impl Verdict {
    /// Returns the verdict of a run without injection.
    pub(crate) fn skipped(
        fault: &Fault,
        course: &Course<'_>,
        phase: &Phase,
        reason: String,
    ) -> Self {
        Self {
            fault: fault.id,
            task: course.task.name(),
            phase: phase.name.clone(),
            seed: course.number,
            ticks: None,
            failure: None,
            skipped: Some(reason),
            is_unsafe: false,
        }
    }
}

/// Returns the verdict of a judge that has finished.
pub(crate) fn judged(
    fault: &Fault,
    course: &Course<'_>,
    phase: &Phase,
    judge: &Judge,
    reaction: Reaction,
) -> Verdict {
    let promises = [ViolationKind::PromiseBroken, ViolationKind::ForbiddenMode];
    let of_modes: u64 = promises.map(|kind| judge.count_of(kind)).into_iter().sum();
    let reached = judge.reached_after();
    Verdict {
        ticks: reached.filter(|_| reaction.required().is_some()),
        failure: judge.violations().first().map(ToString::to_string),
        skipped: None,
        is_unsafe: judge.violation_count() > of_modes,
        ..Verdict::skipped(fault, course, phase, String::new())
    }
}

/// Injects a fault into a copy of a run and judges the reaction.
pub(crate) fn verdict(
    course: &Course<'_>,
    phase: &Phase,
    progress: &Progress,
    (fault, injection, reaction): (&'static Fault, Injection, Reaction),
) -> anyhow::Result<Verdict> {
    let mut progress = progress
        .copy()
        .context("an external engine cannot be copied")?;
    prepare(&mut progress, injection, reaction)?;
    let side = course.robot.acting_side();
    injection.inject(&mut progress.run, side, course.fault_seed())?;
    let bound = reaction.required().map_or(0, |(_, ticks)| ticks);
    for _ in 0..bound + WATCH_TICKS {
        progress.advance();
    }
    progress.judge.finish();
    let mut verdict = judged(fault, course, phase, &progress.judge, reaction);
    verdict.failure = failure(&progress, reaction);
    Ok(verdict)
}

/// Returns the first violation, or the failure of a goal that must continue.
fn failure(progress: &Progress, reaction: Reaction) -> Option<String> {
    let violation = progress.judge.violations().first();
    let Some(violation) = violation else {
        return goal_failure(progress).filter(|_| reaction == Reaction::Continue);
    };
    let reason = progress
        .reason
        .map(|reason| format!("; the controller holds: {reason}"));
    Some(format!("{violation}{}", reason.unwrap_or_default()))
}

/// Prepares the judge for the fault and the required reaction.
fn prepare(
    progress: &mut Progress,
    injection: Injection,
    reaction: Reaction,
) -> Result<(), GripError> {
    let is_held = is_lifted(&progress.truth().objects[0]);
    let judge = &mut progress.judge;
    if injection.pause_ticks() > 0 {
        *judge = judge.clone().allowing(Allowance::MissedTicks);
    }
    if matches!(injection, Injection::Restart(_)) {
        judge.restarted();
    }
    if let Some((modes, within)) = reaction.required() {
        judge.promise(Promise::reach(modes, within));
    }
    if !reaction.forbidden().is_empty() {
        judge.promise(Promise::avoid(reaction.forbidden(), WATCH_TICKS));
    }
    if is_held && must_stay_in_hand(injection, reaction) {
        judge.expect_grip_kept(0)?;
    }
    Ok(())
}

/// Returns true if the goal cannot continue after the fault and set the object down.
fn must_stay_in_hand(injection: Injection, reaction: Reaction) -> bool {
    let is_short = matches!(
        injection,
        Injection::Frames(_, Some(_)) | Injection::Joints(_, Some(_)) | Injection::Pause(_)
    );
    let stops = reaction.required().is_some()
        || matches!(injection, Injection::Restart(_) | Injection::Disconnected);
    stops && !is_short
}

/// Returns true from the lift until the object touches a support, or a cap its thread.
pub(crate) fn is_lifted(object: &ObjectTruth) -> bool {
    let is_supported = object.landed_ns > 0 || object.table_n > 0.0 || object.cap_engaged == 1;
    object.lifted_m > LIFTED_M && !is_supported && object.pressed == 1
}

fn goal_failure(progress: &Progress) -> Option<String> {
    let end = progress
        .end
        .filter(|end| end.state != GoalState::SUCCEEDED)?;
    Some(format!("the goal ends as {}: {}", end.state, end.reason))
}
