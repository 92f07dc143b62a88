//! A goal as the operator wants it sent: its progress shown, its end told in one sentence.

use atas_client::{Cancelled, GoalProgress, Pursuit, Run, Session, json, words};
use atas_console::arguments::Sending;
use atas_console::{Ended, Exit, Interrupt, Output, Progress, number};
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, GoalState};

/// Sends a goal as the user wants it sent, shows its progress and prints its end.
pub(crate) fn send(
    goal: GoalRequest,
    sending: &Sending,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let goal = GoalRequest {
        hand: sending.hand.into(),
        policy: if sending.attached {
            GoalPolicy::ATTACHED
        } else {
            GoalPolicy::DETACHED
        },
        ..goal
    };
    let session = Session::existing(&sending.bus.bus)?;
    let (mut statuses, mut status) = session.watch_status()?;
    let fingers = Run::of(session.bus(), &status)?.fingers(&status);
    let fingers = fingers[goal.hand.index().unwrap_or(0)];
    let mut live = Progress::new(name(&goal));
    let pursuit = Pursuit {
        session: &session,
        stop: interrupt.flag(),
        timeout: sending.timeout,
    };
    let (progress, cancelled) = pursuit.run(&goal, |so_far| {
        statuses.newest(&mut status)?;
        live.show(so_far, fingers, Some(&status), &carried(&goal, so_far));
        anyhow::Ok(())
    })?;
    drop(live);
    if output.is_json() {
        output.json(&json::goal(&progress, fingers))?;
    }
    match progress.last().state {
        GoalState::SUCCEEDED if output.is_json() => Ok(()),
        GoalState::SUCCEEDED => output.line(success(&goal, &progress, fingers)),
        _ => Err(failure(&goal, &progress, cancelled)),
    }
}

/// How far the hand has taken the object, for people who watch.
fn carried(goal: &GoalRequest, progress: &GoalProgress) -> String {
    let by_mm = number(f64::from(progress.last().figures.lifted_m) * 1e3, 1);
    match goal.kind {
        GoalKind::GRASP | GoalKind::RELEASE => format!("lifted {by_mm} mm"),
        _ => format!("carried {by_mm} mm"),
    }
}

/// What a goal is called.
fn name(goal: &GoalRequest) -> &str {
    match goal.kind {
        GoalKind::CUSTOM => goal.task.as_str(),
        kind => kind.name(),
    }
}

fn success(goal: &GoalRequest, progress: &GoalProgress, fingers: usize) -> String {
    let figures = progress.figures();
    let pressed = words::newtons(&figures.normal_n[..fingers]);
    match goal.kind {
        GoalKind::GRASP => format!(
            "holds with F_n {pressed} N (F_1 {:.2}, F_2 {:.2}), stiffness {:.0} N/m, lifted {:.1} mm",
            figures.f1_n,
            figures.f2_n,
            figures.stiffness_n_m,
            figures.lifted_m * 1e3
        ),
        GoalKind::PICK_PLACE => format!(
            "set down and let go; carried with F_n {pressed} N (F_1 {:.2}, F_2 {:.2}), stiffness {:.0} N/m; \
             the hand is at home",
            figures.f1_n, figures.f2_n, figures.stiffness_n_m,
        ),
        GoalKind::SCREW => "the cap is tight; the hand is at home".into(),
        GoalKind::ASSEMBLE => "the cap is on the bottle and tight; both hands are at home".into(),
        GoalKind::RELEASE => "released; the hand is at home".into(),
        _ => format!("{} done", name(goal)),
    }
}

/// The one sentence about an end without success.
fn failure(
    goal: &GoalRequest,
    progress: &GoalProgress,
    cancelled: Option<Cancelled>,
) -> anyhow::Error {
    let state = progress.last().state;
    let (step, hands) = (progress.step(), hands_now(goal, progress));
    match cancelled.filter(|_| state == GoalState::CANCELLED) {
        Some(Cancelled::Interrupted) => Ended::with(
            Exit::Interrupted,
            format!("interrupted, goal cancelled in step {step:?}; {hands}"),
        ),
        Some(Cancelled::TimedOut(timeout)) => Ended::with(
            Exit::Refused,
            format!("took longer than {timeout:?}, goal cancelled in step {step:?}; {hands}"),
        ),
        None if state == GoalState::FAILED && may_hold(goal, progress) => {
            Ended::with(Exit::Refused, format!("{}; {hands}", progress.sentence()))
        }
        None => Ended::with(Exit::Refused, progress.sentence()),
    }
}

/// Whether a hand may have something between its fingers. Only the acting hand's forces are told.
fn may_hold(goal: &GoalRequest, progress: &GoalProgress) -> bool {
    goal.kind == GoalKind::ASSEMBLE || progress.presses()
}

/// What the hands do after an end without success: a goal that ends lets nothing fall.
fn hands_now(goal: &GoalRequest, progress: &GoalProgress) -> String {
    match goal.kind {
        GoalKind::ASSEMBLE => {
            "each hand keeps what it holds; `atas release --hand left` and `--hand right` let go"
                .into()
        }
        _ if may_hold(goal, progress) => format!(
            "the hand keeps what it has between its fingers; `atas release --hand {}` lets go",
            goal.hand
        ),
        _ => "the hand stays where it is".into(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;
    use shm_schemas::{Cause, GoalUpdate, Hand, ModuleId, Reason, Text};

    fn update(state: GoalState, step: &str, reason: Reason) -> GoalUpdate {
        GoalUpdate {
            goal_id: 7,
            state,
            step: Text::new(step),
            reason,
            ..GoalUpdate::default()
        }
    }

    fn told(updates: &[(GoalState, &str, Reason)], cancelled: Option<Cancelled>) -> (String, Exit) {
        let mut progress = GoalProgress::default();
        for (state, step, reason) in updates {
            progress.add(&update(*state, step, *reason));
        }
        let error = failure(&GoalRequest::default(), &progress, cancelled);
        (error.to_string(), Exit::of(&error))
    }

    #[test]
    fn failures_are_one_sentence_with_step_cause_value_limit_and_module() {
        let check = |updates: &[(GoalState, &str, Reason)], expected: &str| {
            assert_eq!(told(updates, None), (expected.to_owned(), Exit::Refused));
        };
        let running = |step| (GoalState::RUNNING, step, Reason::default());
        let heavy = Reason::limit(Cause::TOO_HEAVY, 8.0, 8.0).by(ModuleId::FORCE_LIMIT);
        check(
            &[
                running("lift"),
                running("lower"),
                running("leave"),
                (GoalState::REFUSED, "leave", heavy),
            ],
            "lift: 8.00 N do not hold it, and the fingers may press with 8.00 N at most (`grasp.f2_max_n`): object too heavy (module 3, \
             force limit)",
        );
        check(
            &[(GoalState::REJECTED, "", Reason::of(Cause::BUSY))],
            "another goal is active; wait for it or cancel it",
        );
        check(
            &[(
                GoalState::REJECTED,
                "",
                Reason::limit(Cause::UNREACHABLE, 0.9, 0.4).about(0),
            )],
            "the hand cannot reach it: from x is 0.9000 m, the limit is 0.4000 m; move the object nearer",
        );
        check(
            &[
                running("approach"),
                (
                    GoalState::FAILED,
                    "approach",
                    Reason::limit(Cause::NOTHING_TOUCHED, 0.026, 0.026).by(ModuleId::FIRST_TOUCH),
                ),
            ],
            "approach: closed to 26.0 mm and touched nothing; is the object there? (module 1, first touch)",
        );
        check(
            &[
                running("open"),
                (
                    GoalState::FAILED,
                    "open",
                    Reason::limit(Cause::TIMED_OUT, 10.0, 10.0),
                ),
            ],
            "open: took 10.0 s, allowed 10.0 s",
        );
    }

    #[test]
    fn an_end_in_mid_task_says_what_the_hands_do_now() {
        let check = |kind, state, normal_n, part: &str| {
            let goal = GoalRequest {
                kind,
                hand: Hand::LEFT,
                ..GoalRequest::default()
            };
            let mut progress = GoalProgress::default();
            let mut end = update(state, "screw", Reason::limit(Cause::TIMED_OUT, 9.0, 9.0));
            end.figures.normal_n = [normal_n; 4];
            progress.add(&end);
            let told = failure(&goal, &progress, None).to_string();
            assert_eq!(told, format!("screw: took 9.0 s, allowed 9.0 s{part}"));
        };
        let (screw, assemble) = (GoalKind::SCREW, GoalKind::ASSEMBLE);
        let keeps =
            "; the hand keeps what it has between its fingers; `atas release --hand left` lets go";
        let keep =
            "; each hand keeps what it holds; `atas release --hand left` and `--hand right` let go";
        check(screw, GoalState::FAILED, 2.0, keeps);
        check(screw, GoalState::FAILED, 0.02, "");
        check(assemble, GoalState::FAILED, 0.0, keep);
        check(assemble, GoalState::REFUSED, 0.0, "");
    }

    #[test]
    fn a_cancelled_goal_says_what_the_hand_does_now() {
        let cancelled = |step| [(GoalState::CANCELLED, step, Reason::of(Cause::CANCELLED))];
        let check = |step, why, expected: &str, exit| {
            let end = told(&cancelled(step), Some(why));
            assert_eq!(end, (expected.to_owned(), exit));
        };
        check(
            "reach",
            Cancelled::Interrupted,
            "interrupted, goal cancelled in step \"reach\"; the hand stays where it is",
            Exit::Interrupted,
        );
        check(
            "reach",
            Cancelled::TimedOut(Duration::from_secs(3)),
            "took longer than 3s, goal cancelled in step \"reach\"; the hand stays where it is",
            Exit::Refused,
        );
    }
}
