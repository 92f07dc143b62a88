//! Sending of a goal: shows its progress and prints its result.

use atas_client::{Cancelled, GoalExecution, GoalProgress, Run, Session, json, text};
use atas_console::arguments::SendOptions;
use atas_console::{Exit, ExitError, Interrupt, Output, Progress, number};
use shm_schemas::{GoalKind, GoalPolicy, GoalRequest, GoalState};

pub(crate) fn send(
    goal: GoalRequest,
    sending: &SendOptions,
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
    let fingers = Run::read(session.bus(), &status)?.fingertips(&status);
    let fingers = fingers[goal.hand.index().unwrap_or(0)];
    let mut live = Progress::new(name(&goal));
    let pursuit = GoalExecution {
        session: &session,
        stop: interrupt.flag(),
        timeout: sending.timeout,
    };
    let (progress, cancelled) = pursuit.run(&goal, |so_far| {
        statuses.newest(&mut status)?;
        live.show_goal(
            so_far,
            fingers,
            Some(&status),
            &distance_text(&goal, so_far),
        );
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

/// Formats the distance the object has moved.
fn distance_text(goal: &GoalRequest, progress: &GoalProgress) -> String {
    let by_mm = number(f64::from(progress.last().figures.lifted_m) * 1e3, 1);
    match goal.kind {
        GoalKind::GRASP | GoalKind::RELEASE => format!("lifted {by_mm} mm"),
        _ => format!("carried {by_mm} mm"),
    }
}

fn name(goal: &GoalRequest) -> &str {
    match goal.kind {
        GoalKind::CUSTOM => goal.task.as_str(),
        kind => kind.name(),
    }
}

fn success(goal: &GoalRequest, progress: &GoalProgress, fingers: usize) -> String {
    let figures = progress.figures();
    let pressed = text::newtons(&figures.normal_n[..fingers]);
    match goal.kind {
        GoalKind::GRASP => format!(
            "holds with F_n {pressed} N (F_1 {:.2}, F_2 {:.2}), stiffness {:.0} N/m, lifted {:.1} mm",
            figures.f1_n,
            figures.f2_n,
            figures.stiffness_n_m,
            figures.lifted_m * 1e3
        ),
        GoalKind::PICK_PLACE => format!(
            "object set down and released; carried with F_n {pressed} N (F_1 {:.2}, F_2 {:.2}), \
             stiffness {:.0} N/m; the hand is at home",
            figures.f1_n, figures.f2_n, figures.stiffness_n_m,
        ),
        GoalKind::SCREW => "the cap is tight; the hand is at home".into(),
        GoalKind::ASSEMBLE => "the cap is on the bottle and tight; both hands are at home".into(),
        GoalKind::RELEASE => "released; the hand is at home".into(),
        _ => format!("{} done", name(goal)),
    }
}

/// Returns the error of a goal without success.
fn failure(
    goal: &GoalRequest,
    progress: &GoalProgress,
    cancelled: Option<Cancelled>,
) -> anyhow::Error {
    let state = progress.last().state;
    let (step, hands) = (progress.step(), hands_text(goal, progress));
    match cancelled.filter(|_| state == GoalState::CANCELLED) {
        Some(Cancelled::Interrupted) => ExitError::with_code(
            Exit::Interrupted,
            format!("interrupted: goal cancelled in step {step:?}; {hands}"),
        ),
        Some(Cancelled::TimedOut(timeout)) => ExitError::with_code(
            Exit::Refused,
            format!("goal cancelled in step {step:?}: it took longer than {timeout:?}; {hands}"),
        ),
        None if state == GoalState::FAILED && may_hold(goal, progress) => {
            ExitError::with_code(Exit::Refused, format!("{}; {hands}", progress.text()))
        }
        None => ExitError::with_code(Exit::Refused, progress.text()),
    }
}

/// Returns true if a hand may hold an object. Updates contain only the forces of the acting hand.
fn may_hold(goal: &GoalRequest, progress: &GoalProgress) -> bool {
    goal.kind == GoalKind::ASSEMBLE || progress.presses()
}

/// Describes the hands after a goal without success; they never drop an object.
fn hands_text(goal: &GoalRequest, progress: &GoalProgress) -> String {
    match goal.kind {
        GoalKind::ASSEMBLE => {
            "both hands keep their grip; open them with `atas release --hand left` and `--hand \
             right`"
                .into()
        }
        _ if may_hold(goal, progress) => format!(
            "the hand keeps its grip; open it with `atas release --hand {}`",
            goal.hand
        ),
        _ => "the hand stays where it is".into(),
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use atas_console::exit_of;

    use super::*;
    use shm_schemas::{GoalField, GoalUpdate, Hand, ModuleId, Reason, Text};

    fn update(state: GoalState, step: &str, reason: Reason) -> GoalUpdate {
        GoalUpdate {
            goal_id: 7,
            state,
            step: Text::new(step),
            reason: reason.into(),
            ..GoalUpdate::default()
        }
    }

    fn failure_of(
        updates: &[(GoalState, &str, Reason)],
        cancelled: Option<Cancelled>,
    ) -> (String, Exit) {
        let mut progress = GoalProgress::default();
        for (state, step, reason) in updates {
            progress.add(&update(*state, step, *reason));
        }
        let error = failure(&GoalRequest::default(), &progress, cancelled);
        (error.to_string(), exit_of(&error))
    }

    #[test]
    fn failure_names_step_cause_limit_and_module() {
        let check = |updates: &[(GoalState, &str, Reason)], expected: &str| {
            assert_eq!(
                failure_of(updates, None),
                (expected.to_owned(), Exit::Refused)
            );
        };
        let running = |step| (GoalState::RUNNING, step, Reason::None);
        let heavy = Reason::TooHeavy {
            force_n: 8.0,
            limit_n: 8.0,
            module: ModuleId::FORCE_LIMIT,
        };
        check(
            &[
                running("lift"),
                running("lower"),
                running("leave"),
                (GoalState::REFUSED, "leave", heavy),
            ],
            "lift: object too heavy: not held with 8.00 N, the limit is 8.00 N (`grasp.f2_max_n`) (module 3, force limit)",
        );
        check(
            &[(GoalState::REJECTED, "", Reason::Busy { active: None })],
            "another goal is active; wait for it or cancel it",
        );
        check(
            &[(
                GoalState::REJECTED,
                "",
                Reason::Unreachable {
                    field: GoalField::FROM_X,
                    value: 0.9,
                    limit: 0.4,
                },
            )],
            "goal out of reach: from x is 0.9000 m, the limit is 0.4000 m; use at most 0.4000 m",
        );
        check(
            &[
                running("approach"),
                (
                    GoalState::FAILED,
                    "approach",
                    Reason::NothingTouched {
                        width_m: 0.026,
                        limit_m: 0.026,
                        module: ModuleId::FIRST_TOUCH,
                    },
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
                    Reason::TimedOut {
                        elapsed_s: 10.0,
                        limit_s: 10.0,
                    },
                ),
            ],
            "open: took 10.0 s, allowed 10.0 s",
        );
    }

    #[test]
    fn failed_task_describes_the_hands() {
        let check = |kind, state, normal_n, part: &str| {
            let goal = GoalRequest {
                kind,
                hand: Hand::LEFT,
                ..GoalRequest::default()
            };
            let mut progress = GoalProgress::default();
            let mut end = update(
                state,
                "screw",
                Reason::TimedOut {
                    elapsed_s: 9.0,
                    limit_s: 9.0,
                },
            );
            end.figures.normal_n = [normal_n; 4];
            progress.add(&end);
            let reported = failure(&goal, &progress, None).to_string();
            assert_eq!(reported, format!("screw: took 9.0 s, allowed 9.0 s{part}"));
        };
        let (screw, assemble) = (GoalKind::SCREW, GoalKind::ASSEMBLE);
        let keeps = "; the hand keeps its grip; open it with `atas release --hand left`";
        let keep = "; both hands keep their grip; open them with `atas release --hand left` and `--hand \
             right`";
        check(screw, GoalState::FAILED, 2.0, keeps);
        check(screw, GoalState::FAILED, 0.02, "");
        check(assemble, GoalState::FAILED, 0.0, keep);
        check(assemble, GoalState::REFUSED, 0.0, "");
    }

    #[test]
    fn cancelled_goal_describes_the_hand() {
        let cancelled = |step| [(GoalState::CANCELLED, step, Reason::Cancelled)];
        let check = |step, why, expected: &str, exit| {
            let end = failure_of(&cancelled(step), Some(why));
            assert_eq!(end, (expected.to_owned(), exit));
        };
        check(
            "reach",
            Cancelled::Interrupted,
            "interrupted: goal cancelled in step \"reach\"; the hand stays where it is",
            Exit::Interrupted,
        );
        check(
            "reach",
            Cancelled::TimedOut(Duration::from_secs(3)),
            "goal cancelled in step \"reach\": it took longer than 3s; the hand stays where it is",
            Exit::Refused,
        );
    }
}
