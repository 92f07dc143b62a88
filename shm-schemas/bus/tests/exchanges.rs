//! Goals and control requests: round trip, and behaviour when one side ends.

mod common;

use std::time::Duration;

use common::{Peer, peer_role, ready, until};
use shm_bus::{ActiveGoal, Bus, BusError, BusName, FreshBus, GoalServer, Realtime};
use shm_schemas::{
    ControlOp, ControlOutcome, ControlReply, ControlRequest, GoalKind, GoalRequest, GoalState,
    GoalUpdate, Text,
};

const LONG: Duration = Duration::from_secs(60);

fn open(bus: &BusName, role: &str) -> Bus {
    Bus::open(bus, role, Realtime::No).expect("the bus opens")
}

fn goal(goal_id: u64) -> GoalRequest {
    GoalRequest {
        goal_id,
        kind: GoalKind::GRASP,
        ..GoalRequest::default()
    }
}

fn update(goal_id: u64, state: GoalState, tick: u64) -> GoalUpdate {
    GoalUpdate {
        goal_id,
        state,
        tick,
        ..GoalUpdate::default()
    }
}

fn take(server: &GoalServer) -> ActiveGoal {
    let mut taken = None;
    until("a goal arrives", || {
        taken = server.poll().expect("polled");
        taken.is_some()
    });
    taken.expect("a goal")
}

#[test]
fn peer() {
    let Some((role, name)) = peer_role() else {
        return;
    };
    let bus = open(&name, &role);
    match role.as_str() {
        "server" => {
            let server = bus.goal_server().expect("server");
            ready();
            let active = take(&server);
            active
                .update(&update(active.request().goal_id, GoalState::RUNNING, 1))
                .expect("updated");
            std::thread::sleep(LONG);
        }
        "client" => {
            let _pending = bus
                .goal_client()
                .expect("client")
                .send(&goal(7))
                .expect("sent");
            ready();
            std::thread::sleep(LONG);
        }
        "control" => {
            let server = bus.control_server().expect("server");
            ready();
            loop {
                if let Some(call) = server.poll().expect("polled") {
                    let request = *call.request();
                    let reply = ControlReply {
                        outcome: ControlOutcome::DONE,
                        value: 2.0 * request.value,
                        ..ControlReply::default()
                    };
                    call.reply(&reply).expect("answered");
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        other => panic!("no role {other}"),
    }
}

#[test]
fn goal_updates_arrive_in_order() {
    let name = FreshBus::new("goal");
    let (daemon, cli) = (open(&name, "atasd"), open(&name, "cli"));
    let (server, client) = (
        daemon.goal_server().expect("server"),
        cli.goal_client().expect("client"),
    );
    assert!(server.poll().expect("polled").is_none());
    let mut pending = client.send(&goal(42)).expect("sent");
    let active = take(&server);
    assert_eq!(active.request(), &goal(42));
    assert!(active.client_alive() && !active.cancel_requested());
    assert_eq!(pending.next().expect("no error"), None);
    let steps = [
        GoalState::ACCEPTED,
        GoalState::RUNNING,
        GoalState::SUCCEEDED,
    ];
    for (tick, state) in (0..).zip(steps) {
        active.update(&update(42, state, tick)).expect("updated");
    }
    drop(active);
    for (tick, state) in (0..).zip(steps) {
        assert!(!pending.has_ended());
        assert_eq!(
            pending.next().expect("no error"),
            Some(update(42, state, tick))
        );
    }
    assert!(pending.has_ended());
    assert_eq!(pending.next().expect("the end is not an error"), None);
}

#[test]
fn client_can_cancel_a_goal() {
    let name = FreshBus::new("cancel");
    let bus = open(&name, "both");
    let (server, client) = (
        bus.goal_server().expect("server"),
        bus.goal_client().expect("client"),
    );
    let mut pending = client.send(&goal(1)).expect("sent");
    let active = take(&server);
    assert!(!active.cancel_requested());
    pending.cancel();
    assert!(active.cancel_requested());
    assert!(active.client_alive(), "the client waits for the end");
    active
        .update(&update(1, GoalState::CANCELLED, 9))
        .expect("updated");
    assert_eq!(
        pending.next().expect("no error").map(|update| update.state),
        Some(GoalState::CANCELLED)
    );
}

#[test]
fn dropped_client_is_detected() {
    let name = FreshBus::new("letgo");
    let bus = open(&name, "both");
    let (server, client) = (
        bus.goal_server().expect("server"),
        bus.goal_client().expect("client"),
    );
    let pending = client.send(&goal(1)).expect("sent");
    let active = take(&server);
    drop(pending);
    assert!(!active.client_alive());
    let refused = active
        .update(&GoalUpdate::default())
        .expect_err("client is gone");
    assert!(matches!(refused, BusError::ClientGone { .. }), "{refused}");
}

#[test]
fn killed_client_is_detected_after_clean_up() {
    let name = FreshBus::new("killcli");
    let bus = open(&name, "atasd");
    let server = bus.goal_server().expect("server");
    let client = Peer::start(&name, "client");
    let active = take(&server);
    assert_eq!(active.request().goal_id, 7);
    assert!(active.client_alive());
    client.kill();
    until("the client is gone", || {
        bus.clean_dead();
        // The server updates its connections when it polls.
        server.poll().expect("polled");
        !active.client_alive()
    });
}

#[test]
fn killed_server_is_detected() {
    let name = FreshBus::new("killsrv");
    let bus = open(&name, "cli");
    let client = bus.goal_client().expect("client");
    let server = Peer::start(&name, "server");
    let mut pending = client.send(&goal(3)).expect("sent");
    until("the goal runs", || pending.next().expect("alive").is_some());
    server.kill();
    let mut end = None;
    until("the end is noticed", || {
        end = pending.next().err();
        end.is_some()
    });
    assert!(matches!(end, Some(BusError::ServerGone { .. })), "{end:?}");
    drop(pending);
    let absent = client.send(&goal(4)).expect_err("no server");
    assert!(matches!(absent, BusError::NoServer { .. }), "{absent}");
    let _next = Peer::start(&name, "server");
    let mut pending = client.send(&goal(5)).expect("the next server is found");
    until("the goal runs", || pending.next().expect("alive").is_some());
}

#[test]
fn request_without_server_is_rejected() {
    let name = FreshBus::new("absent");
    let bus = open(&name, "cli");
    let refused = bus
        .goal_client()
        .expect("client")
        .send(&goal(1))
        .expect_err("no server");
    assert!(matches!(refused, BusError::NoServer { .. }), "{refused}");
    let refused = bus
        .control_client()
        .expect("client")
        .call(&ControlRequest::default(), LONG)
        .expect_err("no server");
    assert!(refused.to_string().contains(name.as_str()), "{refused}");
}

#[test]
fn open_requests_are_bounded() {
    let name = FreshBus::new("bounded");
    let bus = open(&name, "both");
    let (server, client) = (
        bus.goal_server().expect("server"),
        bus.goal_client().expect("client"),
    );
    let mut pending: Vec<_> = (0..4)
        .map(|id| client.send(&goal(id)).expect("sent"))
        .collect();
    let refused = client.send(&goal(4)).expect_err("one too many");
    assert!(
        matches!(refused, BusError::TooManyRequests { limit: 4, .. }),
        "{refused}"
    );
    let taken: Vec<_> = std::iter::from_fn(|| server.poll().expect("polled")).collect();
    assert_eq!(
        taken
            .iter()
            .map(|goal| goal.request().goal_id)
            .collect::<Vec<_>>(),
        [0, 1, 2, 3]
    );
    pending.pop();
    client.send(&goal(5)).expect("there is room again");
}

#[test]
fn slow_client_receives_the_final_update() {
    let name = FreshBus::new("hang");
    let bus = open(&name, "both");
    let (server, client) = (
        bus.goal_server().expect("server"),
        bus.goal_client().expect("client"),
    );
    let mut pending = client.send(&goal(1)).expect("sent");
    let active = take(&server);
    for tick in 0..200 {
        active
            .update(&update(1, GoalState::RUNNING, tick))
            .expect("never waits");
    }
    active
        .update(&update(1, GoalState::SUCCEEDED, 200))
        .expect("updated");
    let received: Vec<_> = std::iter::from_fn(|| pending.next().expect("no error")).collect();
    assert_eq!(received.len(), 64);
    assert_eq!(
        received.last().map(|update| update.state),
        Some(GoalState::SUCCEEDED)
    );
}

#[test]
fn second_server_is_rejected() {
    let name = FreshBus::new("oneserv");
    let server = Peer::start(&name, "server");
    let bus = open(&name, "intruder");
    let refused = bus.goal_server().expect_err("taken");
    let BusError::Taken { role, pid, .. } = &refused else {
        panic!("{refused}")
    };
    assert_eq!((role.as_str(), *pid), ("server", server.pid()));
}

#[test]
fn control_is_answered() {
    let name = FreshBus::new("control");
    let _server = Peer::start(&name, "control");
    let client = open(&name, "cli").control_client().expect("client");
    for value in [1.0, 2.5] {
        let request = ControlRequest {
            op: ControlOp::PARAM_SET,
            value,
            name: Text::new("f1_gain"),
            ..ControlRequest::default()
        };
        let reply = client.call(&request, LONG).expect("answered");
        assert_eq!(
            (reply.outcome, reply.value),
            (ControlOutcome::DONE, 2.0 * value)
        );
    }
}

#[test]
fn call_times_out_without_an_answer() {
    let name = FreshBus::new("stuck");
    let bus = open(&name, "both");
    let server = bus.control_server().expect("server");
    let client = bus.control_client().expect("client");
    let refused = client
        .call(&ControlRequest::default(), Duration::from_millis(5))
        .expect_err("no answer");
    assert!(refused.to_string().contains(name.as_str()), "{refused}");
    assert!(matches!(refused, BusError::NoAnswer { .. }));
    assert!(
        server.poll().expect("polled").is_none(),
        "a request without a waiting client is not delivered"
    );
}
