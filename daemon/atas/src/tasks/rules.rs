//! What makes a task sound: rules that hold for the built-in tables and that a user's own task must keep.
//!
//! A task that keeps them can be followed to its end, never presses without Module 3, never lets go of an object by
//! moving on, and never leaves both hands waiting for each other. Whether it does anything useful is the user's matter.

use super::name::Name;
use super::step::{Motion, Step, Transition};
use super::table::BehaviourTable;
use super::track::{STEPS_MAX, Task, Track};
use crate::modules::{IDS, ROLES, Roles};
use core::fmt;
use shm_schemas::ModuleId;

/// Longest time that a step may be given, s (ours, as for a goal's holding time).
pub const TIMEOUT_MAX_S: f64 = 3600.0;

/// Which of the two hands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The hand that the goal names.
    Acting,
    /// The other hand.
    Helping,
}

/// What a task does wrong, and where.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Whose steps.
    pub part: Part,
    /// Which step, from 0; `None` for all of them.
    pub step: Option<usize>,
    /// What is wrong.
    pub rule: Rule,
}

/// The rule that a task breaks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// A track has no step.
    NoSteps,
    /// A track has too many steps.
    TooManySteps(usize),
    /// A step's name is empty, too long, or of other characters than allowed.
    StepName,
    /// A task's name is empty, too long, or of other characters than allowed.
    TaskName,
    /// A task is called like a built-in one.
    BuiltIn,
    /// A timeout is no time that a step could take.
    Timeout(f64),
    /// A step that nothing but the hand decides about has no timeout.
    NoTimeout,
    /// A step has not the module that moves the hand.
    NoMover(ModuleId),
    /// A step has a module that would move the hand otherwise.
    WrongMover(ModuleId),
    /// Fingers press and Module 3 does not watch.
    NoForceLimit,
    /// A step ends by what a module says, and has no such module.
    NoModule(ModuleId),
    /// A step of this motion ends otherwise than by Module 4.
    NoEnd(ModuleId),
    /// A step stays where it is and waits to arrive.
    NeverArrives,
    /// A step moves an object that no step before has gripped, and is not the first one.
    NothingGripped,
    /// A step moves freely with an object in the hand.
    LetsGo,
    /// The motion is only for turning back from an obstacle.
    OnlyInRetreat,
    /// The motion, or the end of the step, is only for hands that a client leads.
    OnlyLed,
    /// A step waits for a hand that has nothing to do.
    Alone,
    /// Meeting points do not count up from 1.
    PointsCountUp,
    /// The hands wait for each other at different points.
    NeverMet(u8),
    /// A step reads a behaviour table, and the task has none.
    NoTable,
    /// A task has a behaviour table that no step reads.
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
                f.write_str("has no timeout_s; only steps until held or met may do without")
            }
            Self::NoMover(id) => write!(f, "moves the hand, needs \"{id}\" among its modules"),
            Self::WrongMover(id) => {
                write!(f, "has \"{id}\", which moves the hand otherwise; leave it out")
            }
            Self::NoForceLimit => write!(
                f,
                "presses an object, needs \"{}\" among its modules",
                ModuleId::FORCE_LIMIT
            ),
            Self::NoModule(id) => write!(f, "ends by what \"{id}\" says, needs it among its modules"),
            Self::NoEnd(id) => write!(f, "needs \"{id}\" and transition = \"concluded\": it has no other end"),
            Self::NeverArrives => f.write_str("stays where it is and cannot arrive; choose another until"),
            Self::NothingGripped => {
                f.write_str("moves an object, needs a step until gripped before it, or to be the first step")
            }
            Self::LetsGo => f.write_str(
                "would let go of the object on the way; carry or convey it, or open the hand before",
            ),
            Self::OnlyInRetreat => f.write_str("is a motion that only the daemon itself begins"),
            Self::OnlyLed => f.write_str("follows a client, which only the built-in tasks do; leave it out"),
            Self::Alone => f.write_str("waits for the other hand, which has no steps"),
            Self::PointsCountUp => f.write_str("needs a meeting point above the one before, from 1"),
            Self::NeverMet(point) => write!(
                f,
                "waits for the other hand at point {point}, which waits in turn, or never comes there"
            ),
            Self::NoTable => write!(
                f,
                "has \"{}\" among its modules, and the task has no table; give it one",
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
    /// A task of these steps, if it keeps every rule.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn checked(name: &str, acting: &[Step], helping: Option<&[Step]>) -> Result<Self, Fault> {
        Self::checked_with_table(name, acting, helping, None)
    }

    /// The same with what the module "behaviour table" reads.
    ///
    /// # Errors
    /// The first [`Fault`].
    pub fn checked_with_table(
        name: &str,
        acting: &[Step],
        helping: Option<&[Step]>,
        table: Option<BehaviourTable>,
    ) -> Result<Self, Fault> {
        let task = Self {
            name: checked_task_name(name).map_err(|rule| Fault {
                part: Part::Acting,
                step: None,
                rule,
            })?,
            acting: checked_track(acting, Part::Acting)?,
            helping: helping
                .map(|steps| checked_track(steps, Part::Helping))
                .transpose()?,
            table,
        };
        check_meetings(&task)?;
        check_table(&task)?;
        Ok(task)
    }
}

/// A step's name that can be typed as it is printed.
///
/// # Errors
/// [`Rule::StepName`].
pub fn checked_name(name: &str) -> Result<Name, Rule> {
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-' || c == ' ';
    if (1..=Name::MAX).contains(&name.len()) && name.chars().all(plain) {
        Ok(Name::new(name))
    } else {
        Err(Rule::StepName)
    }
}

/// The same for a task, whose name is one word and not taken.
fn checked_task_name(name: &str) -> Result<Name, Rule> {
    let checked = checked_name(name).map_err(|_| Rule::TaskName)?;
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

fn checked_track(steps: &[Step], part: Part) -> Result<Track, Fault> {
    let fault = |step, rule| Fault { part, step, rule };
    let track = Track::checked(steps).ok_or(fault(
        None,
        if steps.is_empty() {
            Rule::NoSteps
        } else {
            Rule::TooManySteps(steps.len())
        },
    ))?;
    // What the hand already holds may be moved at once, by the hand that the goal names.
    let mut grips = part == Part::Acting && steps.first().is_some_and(Step::takes_over);
    for (index, step) in steps.iter().enumerate() {
        let check = checked_name(&step.name)
            .and_then(|_| check_step(step))
            .and_then(|()| check_grip(step, grips));
        check.map_err(|rule| fault(Some(index), rule))?;
        grips = match (step.motion, step.transition) {
            (Motion::Open | Motion::LetGo, _) => false,
            (_, Transition::Gripped) => true,
            _ if step.is_read_off() => true,
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

/// The hand goes where one module says; two would contradict each other.
fn check_mover(step: &Step) -> Result<(), Rule> {
    let needed = match step.motion {
        Motion::Stay => None,
        Motion::Reach(_) | Motion::Carry(_) | Motion::Open | Motion::LetGo => Some(ModuleId::CARRY),
        Motion::Convey(_) | Motion::Lower => Some(ModuleId::TRANSFER),
        Motion::Square => Some(ModuleId::TRAJECTORY),
        Motion::Withdraw => return Err(Rule::OnlyInRetreat),
        Motion::Follow | Motion::Brake => return Err(Rule::OnlyLed),
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
        (_, Transition::GripWanted | Transition::OpeningWanted) => Err(Rule::OnlyLed),
        (_, Transition::AllTouched | Transition::Gripped) => needs(ModuleId::FIRST_TOUCH),
        (_, Transition::StiffnessKnown) => needs(ModuleId::PROBE),
        (_, Transition::Concluded) if !has_end => Err(Rule::NoModule(ModuleId::RELEASE_PLACED)),
        _ => Ok(()),
    }
}

/// Whether fingers press on an object; searching it and probing it have bounds of their own.
fn presses(step: &Step) -> bool {
    let searches = match step.transition {
        Transition::AllTouched => Some(ModuleId::FIRST_TOUCH),
        Transition::StiffnessKnown => Some(ModuleId::PROBE),
        _ => None,
    };
    let mut closers = with_role(step, |roles| roles.closes_fingers);
    step.motion.needs_grip() || closers.any(|id| Some(id) != searches)
}

/// The modules of a step that have this role.
fn with_role(step: &Step, has: fn(&Roles) -> bool) -> impl Iterator<Item = ModuleId> {
    let selected = step.modules;
    let known = IDS.into_iter().zip(ROLES);
    let with = known.filter(move |(id, roles)| selected.contains(*id) && has(roles));
    with.map(|(id, _)| id)
}

fn check_grip(step: &Step, grips: bool) -> Result<(), Rule> {
    match step.motion {
        Motion::Reach(_) if grips => Err(Rule::LetsGo),
        motion if motion.needs_grip() && !grips && !step.is_read_off() => Err(Rule::NothingGripped),
        _ => Ok(()),
    }
}

/// A table and the steps that read it come together.
fn check_table(task: &Task) -> Result<(), Fault> {
    let acting = task.acting.iter().position(Step::is_read_off);
    let helping = task.helping.as_ref();
    let helping = helping.and_then(|track| track.iter().position(Step::is_read_off));
    let fault = |part, step, rule| Err(Fault { part, step, rule });
    match (task.table, acting, helping) {
        (None, Some(step), _) => fault(Part::Acting, Some(step), Rule::NoTable),
        (None, None, Some(step)) => fault(Part::Helping, Some(step), Rule::NoTable),
        (Some(_), None, None) => fault(Part::Acting, None, Rule::UnreadTable),
        _ => Ok(()),
    }
}

/// Walks both hands from meeting point to meeting point.
fn check_meetings(task: &Task) -> Result<(), Fault> {
    let tracks = [Some(&task.acting), task.helping.as_ref()];
    let parts = [Part::Acting, Part::Helping];
    for (track, part) in tracks.iter().zip(parts) {
        let mut last = 0;
        for (index, point) in track.iter().flat_map(|track| meetings(track)) {
            let rule = match task.helping {
                None => Rule::Alone,
                Some(_) if point > last => {
                    last = point;
                    continue;
                }
                Some(_) => Rule::PointsCountUp,
            };
            return Err(Fault {
                part,
                step: Some(index),
                rule,
            });
        }
    }
    let Some(helping) = &task.helping else {
        return Ok(());
    };
    match stuck(meetings(&task.acting), meetings(helping)) {
        None => Ok(()),
        Some((hand, step, point)) => Err(Fault {
            part: parts[hand],
            step: Some(step),
            rule: Rule::NeverMet(point),
        }),
    }
}

/// The steps of a track at which it waits, with their points.
fn meetings(track: &Track) -> impl Iterator<Item = (usize, u8)> + '_ {
    let point = |(index, step): (usize, &Step)| match step.transition {
        Transition::Met(point) => Some((index, point)),
        _ => None,
    };
    track.iter().enumerate().filter_map(point)
}

/// Where a hand waits for ever: hand, step, point. A hand has come to a point when it waits at it or at a later one.
fn stuck(
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
