//! Goal requests from command-line arguments, one function per command.

use atas_client::goal::{self, Target};
use atas_client::scenes::DefaultScene;
use atas_console::arguments::{
    Assemble, Grasp, ObjectProperties, PickPlace, Place, Release, Screw, UserTask,
};
use atas_console::{Interrupt, Output};
use shm_schemas::{GoalKind, GoalRequest, Hand, Text};

use crate::send::send;

pub(crate) fn grasp(
    arguments: &Grasp,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let object = Target {
        at_m: arguments.at,
        yaw_rad: arguments.yaw.to_radians(),
        width_m: arguments.width * 1e-3,
        ..Target::default()
    };
    let object = with_properties(object, &arguments.known);
    let hand = arguments.sending.hand.into();
    let goal = goal::grasp(&object, hand, arguments.lift * 1e-3, arguments.hold);
    send(goal, &arguments.sending, interrupt, output)
}

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

pub(crate) fn pick_place(
    arguments: &PickPlace,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let hand: Hand = arguments.sending.hand.into();
    let usual = DefaultScene::PickPlace.nominal(hand);
    let from = target(
        &usual.object,
        arguments.from,
        arguments.yaw,
        arguments.width,
    );
    let from = with_properties(from, &arguments.known);
    let to_m = place_m(&usual.place, arguments.to, from.at_m[2]);
    let to_yaw_rad = arguments.to_yaw.map_or(from.yaw_rad, f64::to_radians);
    let goal = GoalRequest {
        to_yaw_rad,
        ..goal::pick_place(&from, hand, to_m, arguments.lift * 1e-3)
    };
    send(goal, &arguments.sending, interrupt, output)
}

pub(crate) fn screw(
    arguments: &Screw,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let hand: Hand = arguments.sending.hand.into();
    let usual = DefaultScene::Screw.nominal(hand);
    let cap = target(&usual.object, arguments.at, arguments.yaw, arguments.width);
    let goal = GoalRequest {
        turn: arguments.turn.into(),
        ..goal::screw(&cap, hand)
    };
    send(goal, &arguments.sending, interrupt, output)
}

pub(crate) fn assemble(
    arguments: &Assemble,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let (yaw, width) = (arguments.yaw, arguments.cap_width);
    let hand: Hand = arguments.sending.hand.into();
    let usual = DefaultScene::Assembly.nominal(hand);
    let cap = target(&usual.object, arguments.cap, yaw, width);
    let on_bottle = target(&usual.place, arguments.on, yaw, width);
    let bottle_width_m = arguments
        .bottle_width
        .map_or(usual.bottle_width_m, |width_mm| width_mm * 1e-3);
    let goal = GoalRequest {
        turn: arguments.turn.into(),
        ..goal::assemble(&cap, &on_bottle, bottle_width_m, hand)
    };
    send(goal, &arguments.sending, interrupt, output)
}

pub(crate) fn task(
    arguments: &UserTask,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let hand: Hand = arguments.sending.hand.into();
    let usual = DefaultScene::PickPlace.nominal(hand);
    let from = target(
        &usual.object,
        arguments.from,
        arguments.yaw,
        arguments.width,
    );
    let from = with_properties(from, &arguments.known);
    let to_m = place_m(&usual.place, arguments.to, from.at_m[2]);
    let goal = GoalRequest {
        kind: GoalKind::CUSTOM,
        task: Text::new(&arguments.name),
        to_yaw_rad: arguments.to_yaw.map_or(from.yaw_rad, f64::to_radians),
        hold_s: arguments.hold,
        helper_width_m: arguments.helper_width * 1e-3,
        turn: arguments.turn.into(),
        ..goal::pick_place(&from, hand, to_m, arguments.lift * 1e-3)
    };
    send(goal, &arguments.sending, interrupt, output)
}

/// Returns the given properties of an object, with the defaults of the scene for the rest.
fn target(
    usual: &Target,
    place: Option<Place>,
    yaw_deg: Option<f64>,
    width_mm: Option<f64>,
) -> Target {
    Target {
        at_m: place_m(usual, place, usual.at_m[2]),
        yaw_rad: yaw_deg.map_or(usual.yaw_rad, f64::to_radians),
        width_m: width_mm.map_or(usual.width_m, |width_mm| width_mm * 1e-3),
        ..*usual
    }
}

/// Adds the optional properties of an object.
fn with_properties(object: Target, known: &ObjectProperties) -> Target {
    let top_m = known.top.map_or(0.0, |top_mm| top_mm * 1e-3);
    object.with_limits(top_m, known.max_force.unwrap_or(0.0))
}

/// Returns the given position, with `z_m` as the default height; without a position the default
/// one.
fn place_m(usual: &Target, place: Option<Place>, z_m: f64) -> [f64; 3] {
    place.map_or(usual.at_m, |place| place.or_height(z_m))
}
