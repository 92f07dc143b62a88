//! From what the user typed to a goal: one function per command.

use robot_model::Side;
use shm_schemas::{GoalKind, GoalRequest, Text};
use sim_backend::GraspHint;

use super::pursuit::send;
use crate::arguments::{Assemble, Grasp, PickPlace, Place, Release, Screw, UserTask};
use crate::interrupt::Interrupt;
use crate::nominal::Usual;
use crate::output::Output;
use crate::rehearsal::{assemble_goal, pick_place_goal, screw_goal};

/// `atas grasp`.
pub(crate) fn grasp(
    arguments: &Grasp,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let goal = GoalRequest {
        kind: GoalKind::GRASP,
        from_m: arguments.at,
        from_yaw_rad: arguments.yaw.to_radians(),
        width_m: arguments.width * 1e-3,
        lift_m: arguments.lift * 1e-3,
        hold_s: arguments.hold,
        ..GoalRequest::default()
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// `atas release`.
pub(crate) fn release(
    arguments: &Release,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let goal = GoalRequest {
        kind: GoalKind::RELEASE,
        ..GoalRequest::default()
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// `atas pick-place`.
pub(crate) fn pick_place(
    arguments: &PickPlace,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let side = arguments.sending.hand.into();
    let usual = Usual::PickPlace.nominal(side)?;
    let from = hint(
        &usual.object,
        arguments.from,
        arguments.yaw,
        arguments.width,
    );
    let to_m = place_m(&usual.place, arguments.to, from.from_m[2]);
    let to_yaw_rad = arguments.to_yaw.map_or(from.yaw_rad, f64::to_radians);
    let goal = GoalRequest {
        to_yaw_rad,
        ..pick_place_goal(&from, side, to_m, arguments.lift * 1e-3)
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// `atas screw`.
pub(crate) fn screw(
    arguments: &Screw,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let side = arguments.sending.hand.into();
    let usual = Usual::Screw.nominal(side)?;
    let cap = hint(&usual.object, arguments.at, arguments.yaw, arguments.width);
    let goal = GoalRequest {
        turn: arguments.turn.into(),
        ..screw_goal(&cap, side)
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// `atas assemble`.
pub(crate) fn assemble(
    arguments: &Assemble,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let (yaw, width) = (arguments.yaw, arguments.cap_width);
    let side = arguments.sending.hand.into();
    let usual = Usual::Assembly.nominal(side)?;
    let cap = hint(&usual.object, arguments.cap, yaw, width);
    let on_bottle = hint(&usual.place, arguments.on, yaw, width);
    let bottle_width_m = arguments
        .bottle_width
        .map_or(usual.bottle_width_m, |width_mm| width_mm * 1e-3);
    let goal = GoalRequest {
        turn: arguments.turn.into(),
        ..assemble_goal(&cap, &on_bottle, bottle_width_m, side)
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// `atas task`.
pub(crate) fn task(
    arguments: &UserTask,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let side: Side = arguments.sending.hand.into();
    let usual = Usual::PickPlace.nominal(side)?;
    let from = hint(
        &usual.object,
        arguments.from,
        arguments.yaw,
        arguments.width,
    );
    let to_m = place_m(&usual.place, arguments.to, from.from_m[2]);
    let goal = GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new(&arguments.name),
        to_yaw_rad: arguments.to_yaw.map_or(from.yaw_rad, f64::to_radians),
        hold_s: arguments.hold,
        helper_width_m: arguments.helper_width * 1e-3,
        turn: arguments.turn.into(),
        ..pick_place_goal(&from, side, to_m, arguments.lift * 1e-3)
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// What the user said of an object, and what is usual for the rest.
fn hint(
    usual: &GraspHint,
    place: Option<Place>,
    yaw_deg: Option<f64>,
    width_mm: Option<f64>,
) -> GraspHint {
    GraspHint {
        from_m: place_m(usual, place, usual.from_m[2]),
        yaw_rad: yaw_deg.map_or(usual.yaw_rad, f64::to_radians),
        width_m: width_mm.map_or(usual.width_m, |width_mm| width_mm * 1e-3),
        ..*usual
    }
}

/// Where the user said, at this height if he did not say how high; else the usual place.
fn place_m(usual: &GraspHint, place: Option<Place>, z_m: f64) -> [f64; 3] {
    place.map_or(usual.from_m, |place| place.or_height(z_m))
}
