//! Validation rules for built-in and user-defined tasks.
//!
//! A valid task can end, never presses without Module 3, never drops an object and never deadlocks
//! the hands.

use super::name::Name;
use super::step::{Motion, Step, Transition};
use super::step_sequence::{STEPS_MAX, StepSequence, Task};
use super::table::BehaviourTable;
use crate::modules::{IDS, ROLES, Roles};
use core::fmt;
use shm_schemas::ModuleId;

/// Maximum timeout of a step, s (design choice; equals the maximum hold time of a goal).
pub const TIMEOUT_MAX_S: f64 = 3600.0;

/// Role of a hand in a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Hand that the goal names.
    Acting,
    /// Other hand.
    Helping,
}

/// Rule violation and its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RuleViolation {
    /// Hand concerned.
    pub part: Part,
    /// Index of the step; `None` for the whole sequence.
    pub step: Option<usize>,
    /// Violated rule.
    pub rule: Rule,
}

/// Rules for tasks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// Empty sequence.
    NoSteps,
    /// Too many steps.
    TooManySteps(usize),
    /// Invalid step name.
    StepName,
    /// Invalid task name.
    TaskName,
    /// Name of a built-in task.
    BuiltIn,
    /// Timeout out of range.
    Timeout(f64),
    /// Missing timeout.
    NoTimeout,
    /// Missing module for the motion.
    NoMover(ModuleId),
    /// Module that conflicts with the motion.
    WrongMover(ModuleId),
    /// Pressing without Module 3.
    NoForceLimit,
    /// Missing module that ends the step.
    NoModule(ModuleId),
    /// Motion that only Module 4 can end.
    NoEnd(ModuleId),
    /// Stationary step that waits for arrival.
    NeverArrives,
    /// Motion with an object that no earlier step gripped.
    NothingGripped,
    /// Free motion with an object in hand.
    ReleasesObject,
    /// Motion reserved for recovery.
    OnlyInRecovery,
    /// Motion or transition reserved for teleoperation.
    OnlyTeleoperated,
    /// Wait for a hand without steps.
    NoOtherHand,
    /// Meeting points not counting up from 1.
    PointOrder,
    /// Deadlock of both hands.
    Deadlock(u8),
    /// Step that reads a missing behaviour table.
    NoTable,
    /// Behaviour table that no step reads.
    UnreadTable,
}

impl fmt::Display for Rule {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoSteps => f.write_str("has no steps, needs at least one"),
            Self::TooManySteps(count) => write!(f, "has {count} steps, needs at most {STEPS_MAX}"),
            Self::StepName => write!(
                f,
                "needs a step name of 1 to {} lowercase letters, digits, spaces and hyphens",
                Name::MAX
            ),
            Self::TaskName => write!(
                f,
                "needs a name of 1 to {} lowercase letters, digits and hyphens",
                Name::MAX
            ),
            Self::BuiltIn => f.write_str("is the name of a built-in task; choose another one"),
            Self::Timeout(s) => write!(
                f,
                "timeout_s is {s}, needs more than 0 and at most {TIMEOUT_MAX_S}"
            ),
            Self::NoTimeout => {
                f.write_str("has no timeout_s, needs one unless its transition is held or met")
            }
            Self::NoMover(id) => write!(f, "moves the hand, needs \"{id}\" among its modules"),
            Self::WrongMover(id) => {
                write!(
                    f,
                    "has \"{id}\", which conflicts with the motion of this step; remove it"
                )
            }
            Self::NoForceLimit => write!(
                f,
                "presses an object, needs \"{}\" among its modules",
                ModuleId::FORCE_LIMIT
            ),
            Self::NoModule(id) => write!(
                f,
                "ends by a conclusion of \"{id}\", needs it among its \
                modules"
            ),
            Self::NoEnd(id) => write!(
                f,
                "needs \"{id}\" and transition = \"concluded\": no other \
                transition ends this motion"
            ),
            Self::NeverArrives => f.write_str(
                "does not move and cannot arrive; choose another \
                transition",
            ),
            Self::NothingGripped => f.write_str(
                "moves an object, needs an earlier step with transition = \"gripped\", \
                    or must be the first step",
            ),
            Self::ReleasesObject => f.write_str(
                "would release the object on the way; use carry or convey, or open the hand before",
            ),
            Self::OnlyInRecovery => f.write_str(
                "has a motion reserved for recovery; choose another \
                motion",
            ),
            Self::OnlyTeleoperated => f.write_str(
                "has a motion or transition reserved for teleoperation; \
                choose another one",
            ),
            Self::NoOtherHand => f.write_str("waits for the other hand, which has no steps"),
            Self::PointOrder => f.write_str(
                "needs a meeting point above the previous one, \
                starting from 1",
            ),
            Self::Deadlock(point) => write!(
                f,
                "waits at meeting point {point}, which the other hand never reaches"
            ),
            Self::NoTable => write!(
                f,
                "has \"{}\" among its modules, but the task has no table; add a table",
                ModuleId::BEHAVIOUR_TABLE
            ),
            Self::UnreadTable => write!(
                f,
                "has a table that no step reads, needs a step with \"{}\" among its modules",
                ModuleId::BEHAVIOUR_TABLE
            ),
        }
    }
}

impl Task {
    /// Validates a task without a behaviour table.
    ///
    /// # Errors
    /// The first [`RuleViolation`].
    pub fn validated(
        name: &str,
        acting: &[Step],
        helping: Option<&[Step]>,
    ) -> Result<Self, RuleViolation> {
        Self::validated_with_table(name, acting, helping, None)
    }

    /// Validates a task.
    ///
    /// # Errors
    /// The first [`RuleViolation`].
    pub fn validated_with_table(
        name: &str,
        acting: &[Step],
        helping: Option<&[Step]>,
        table: Option<BehaviourTable>,
    ) -> Result<Self, RuleViolation> {
        let task = Self {
            name: validated_task_name(name).map_err(|rule| RuleViolation {
                part: Part::Acting,
                step: None,
                rule,
            })?,
            acting: validated_sequence(acting, Part::Acting)?,
            helping: helping
                .map(|steps| validated_sequence(steps, Part::Helping))
                .transpose()?,
            table,
        };
        check_meetings(&task)?;
        check_table(&task)?;
        Ok(task)
    }
}

/// Validates a step name.
///
/// # Errors
/// [`Rule::StepName`].
pub fn validated_step_name(name: &str) -> Result<Name, Rule> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == ' ';
    if (1..=Name::MAX).contains(&name.len()) && name.chars().all(plain) {
        Ok(Name::new(name))
    } else {
        Err(Rule::StepName)
    }
}

/// Validates a task name: one word, not built in.
fn validated_task_name(name: &str) -> Result<Name, Rule> {
    let checked = validated_step_name(name).map_err(|_| Rule::TaskName)?;
    if name.contains(' ') {
        return Err(Rule::TaskName);
    }
    if super::built_in::BUILT_IN
        .iter()
        .any(|task| task.name == name)
    {
        return Err(Rule::BuiltIn);
    }
    Ok(checked)
}

fn validated_sequence(steps: &[Step], part: Part) -> Result<StepSequence, RuleViolation> {
    let fault = |step, rule| RuleViolation { part, step, rule };
    let track = StepSequence::validated(steps).ok_or(fault(
        None,
        if steps.is_empty() {
            Rule::NoSteps
        } else {
            Rule::TooManySteps(steps.len())
        },
    ))?;
    // The acting hand may start with an object in hand.
    let mut grips = part == Part::Acting && steps.first().is_some_and(Step::starts_with_object);
    for (index, step) in steps.iter().enumerate() {
        let check = validated_step_name(&step.name)
            .and_then(|_| check_step(step))
            .and_then(|()| check_grip(step, grips));
        check.map_err(|rule| fault(Some(index), rule))?;
        grips = match (step.motion, step.transition) {
            (Motion::Open | Motion::LetGo, _) => false,
            (_, Transition::Gripped) => true,
            _ if step.uses_table() => true,
            _ => grips,
        };
    }
    Ok(track)
}

fn check_step(step: &Step) -> Result<(), Rule> {
    check_timeout(step)?;
    check_mover(step)?;
    check_end(step)?;
    if presses(step) && !step.modules.contains(ModuleId::FORCE_LIMIT) {
        return Err(Rule::NoForceLimit);
    }
    Ok(())
}

fn check_timeout(step: &Step) -> Result<(), Rule> {
    let s = step.timeout_s;
    if s == f64::INFINITY {
        return if step.transition.is_open_ended() {
            Ok(())
        } else {
            Err(Rule::NoTimeout)
        };
    }
    if s > 0.0 && s <= TIMEOUT_MAX_S {
        Ok(())
    } else {
        Err(Rule::Timeout(s))
    }
}

/// Checks that exactly the module of the motion moves the hand.
fn check_mover(step: &Step) -> Result<(), Rule> {
    let needed = match step.motion {
        Motion::Stay => None,
        Motion::Reach(_) | Motion::Carry(_) | Motion::Open | Motion::LetGo => Some(ModuleId::CARRY),
        Motion::Convey(_) | Motion::Lower => Some(ModuleId::TRANSFER),
        Motion::Square => Some(ModuleId::TRAJECTORY),
        Motion::Withdraw => return Err(Rule::OnlyInRecovery),
        Motion::Teleop | Motion::Brake => return Err(Rule::OnlyTeleoperated),
    };
    let has = |id: &ModuleId| step.modules.contains(*id);
    if let Some(id) = needed.filter(|id| !has(id)) {
        return Err(Rule::NoMover(id));
    }
    let other = with_role(step, |roles| roles.moves_hand).find(|id| Some(*id) != needed);
    other.map_or(Ok(()), |id| Err(Rule::WrongMover(id)))
}

fn check_end(step: &Step) -> Result<(), Rule> {
    let needs = |id: ModuleId| {
        if step.modules.contains(id) {
            Ok(())
        } else {
            Err(Rule::NoModule(id))
        }
    };
    let has_end = with_role(step, |roles| roles.concludes).next().is_some();
    let concludes = step.transition == Transition::Concluded;
    match (step.motion, step.transition) {
        (Motion::Lower, _) if !concludes || !step.modules.contains(ModuleId::RELEASE_PLACED) => {
            Err(Rule::NoEnd(ModuleId::RELEASE_PLACED))
        }
        (Motion::Square, _) if !concludes || !step.modules.contains(ModuleId::TERMINATE_SCREW) => {
            Err(Rule::NoEnd(ModuleId::TERMINATE_SCREW))
        }
        (Motion::Stay, Transition::Arrived) => Err(Rule::NeverArrives),
        (_, Transition::GripRequested | Transition::OpeningRequested) => {
            Err(Rule::OnlyTeleoperated)
        }
        (_, Transition::AllTouched | Transition::Gripped) => needs(ModuleId::FIRST_TOUCH),
        (_, Transition::StiffnessKnown) => needs(ModuleId::PROBE),
        (_, Transition::Concluded) if !has_end => Err(Rule::NoModule(ModuleId::RELEASE_PLACED)),
        _ => Ok(()),
    }
}

/// Returns true if the fingers press beyond first touch and probe, which limit their own force.
fn presses(step: &Step) -> bool {
    let searches = match step.transition {
        Transition::AllTouched => Some(ModuleId::FIRST_TOUCH),
        Transition::StiffnessKnown => Some(ModuleId::PROBE),
        _ => None,
    };
    let mut closers = with_role(step, |roles| roles.closes_fingers);
    step.motion.needs_grip() || closers.any(|id| Some(id) != searches)
}

/// Returns the modules of a step with this role.
fn with_role(step: &Step, has: fn(&Roles) -> bool) -> impl Iterator<Item = ModuleId> {
    let selected = step.modules;
    let known = IDS.into_iter().zip(ROLES);
    let with = known.filter(move |(id, roles)| selected.contains(*id) && has(roles));
    with.map(|(id, _)| id)
}

fn check_grip(step: &Step, grips: bool) -> Result<(), Rule> {
    match step.motion {
        Motion::Reach(_) if grips => Err(Rule::ReleasesObject),
        motion if motion.needs_grip() && !grips && !step.uses_table() => Err(Rule::NothingGripped),
        _ => Ok(()),
    }
}

/// Checks that a table exists exactly if a step reads it.
fn check_table(task: &Task) -> Result<(), RuleViolation> {
    let acting = task.acting.iter().position(Step::uses_table);
    let helping = task.helping.as_ref();
    let helping = helping.and_then(|track| track.iter().position(Step::uses_table));
    let fault = |part, step, rule| Err(RuleViolation { part, step, rule });
    match (task.table, acting, helping) {
        (None, Some(step), _) => fault(Part::Acting, Some(step), Rule::NoTable),
        (None, None, Some(step)) => fault(Part::Helping, Some(step), Rule::NoTable),
        (Some(_), None, None) => fault(Part::Acting, None, Rule::UnreadTable),
        _ => Ok(()),
    }
}

/// Simulates both hands from meeting point to meeting point.
fn check_meetings(task: &Task) -> Result<(), RuleViolation> {
    let tracks = [Some(&task.acting), task.helping.as_ref()];
    let parts = [Part::Acting, Part::Helping];
    for (track, part) in tracks.iter().zip(parts) {
        let mut last = 0;
        for (index, point) in track.iter().flat_map(|track| meetings(track)) {
            let rule = match task.helping {
                None => Rule::NoOtherHand,
                Some(_) if point > last => {
                    last = point;
                    continue;
                }
                Some(_) => Rule::PointOrder,
            };
            return Err(RuleViolation {
                part,
                step: Some(index),
                rule,
            });
        }
    }
    let Some(helping) = &task.helping else {
        return Ok(());
    };
    match deadlock(meetings(&task.acting), meetings(helping)) {
        None => Ok(()),
        Some((hand, step, point)) => Err(RuleViolation {
            part: parts[hand],
            step: Some(step),
            rule: Rule::Deadlock(point),
        }),
    }
}

/// Returns the steps of a sequence that wait, with their points.
fn meetings(track: &StepSequence) -> impl Iterator<Item = (usize, u8)> + '_ {
    let point = |(index, step): (usize, &Step)| match step.transition {
        Transition::Met(point) => Some((index, point)),
        _ => None,
    };
    track.iter().enumerate().filter_map(point)
}

/// Returns hand, step and point of a deadlock. A hand has reached its current waiting point and all
/// earlier ones.
fn deadlock(
    acting: impl Iterator<Item = (usize, u8)>,
    helping: impl Iterator<Item = (usize, u8)>,
) -> Option<(usize, usize, u8)> {
    let (mut acting, mut helping) = (acting.peekable(), helping.peekable());
    let mut reached = [0; 2];
    loop {
        let waits = [acting.peek().copied(), helping.peek().copied()];
        for (reached, wait) in reached.iter_mut().zip(waits) {
            *reached = wait.map_or(*reached, |(_, point)| point);
        }
        match waits {
            [Some((_, point)), _] if reached[1] >= point => drop(acting.next()),
            [_, Some((_, point))] if reached[0] >= point => drop(helping.next()),
            [Some((step, point)), _] => return Some((0, step, point)),
            [_, Some((step, point))] => return Some((1, step, point)),
            [None, None] => return None,
        }
    }
}
