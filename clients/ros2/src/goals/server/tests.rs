use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use super::*;
use crate::middleware::test_caller;
use crate::wire::action::{GetResultRequest, GripperCommandAction, SendGoalRequest};
use crate::wire::gripper::{GripperGoal, GripperResult};

type A = GripperCommandAction;

/// Requests and answers of one client.
#[derive(Default)]
struct Wire {
    goals: VecDeque<Uuid>,
    cancels: VecDeque<GoalInfo>,
    results: VecDeque<Uuid>,
    accepted: Vec<bool>,
    cancelled: Vec<CancelGoalResponse>,
    answered: Vec<(i8, GripperResult)>,
    statuses: Vec<i8>,
}

#[derive(Clone, Default)]
struct Client(Arc<Mutex<Wire>>);

impl ActionPorts<A> for Client {
    fn take_goal(&mut self) -> anyhow::Result<Option<(Caller, SendGoalRequest<A>)>> {
        let id = self.0.lock().expect("alive").goals.pop_front();
        Ok(id.map(|id| {
            (
                test_caller(),
                SendGoalRequest::new(id, GripperGoal::default()),
            )
        }))
    }
    fn respond_goal(&mut self, _: Caller, response: SendGoalResponse<A>) -> anyhow::Result<()> {
        self.0
            .lock()
            .expect("alive")
            .accepted
            .push(response.accepted);
        Ok(())
    }
    fn take_cancel(&mut self) -> anyhow::Result<Option<(Caller, CancelGoalRequest)>> {
        let goal_info = self.0.lock().expect("alive").cancels.pop_front();
        Ok(goal_info.map(|goal_info| (test_caller(), CancelGoalRequest { goal_info })))
    }
    fn respond_cancel(&mut self, _: Caller, response: CancelGoalResponse) -> anyhow::Result<()> {
        self.0.lock().expect("alive").cancelled.push(response);
        Ok(())
    }
    fn take_result(&mut self) -> anyhow::Result<Option<(Caller, GetResultRequest<A>)>> {
        let id = self.0.lock().expect("alive").results.pop_front();
        Ok(id.map(|id| (test_caller(), GetResultRequest::new(id))))
    }
    fn respond_result(&mut self, _: Caller, response: GetResultResponse<A>) -> anyhow::Result<()> {
        let answer = (response.status, response.result);
        self.0.lock().expect("alive").answered.push(answer);
        Ok(())
    }
    fn feedback(&mut self, _: FeedbackMessage<A>) -> anyhow::Result<()> {
        Ok(())
    }
    fn statuses(&mut self, message: GoalStatusArray) -> anyhow::Result<()> {
        let statuses = message.status_list.iter().map(|of| of.status).collect();
        self.0.lock().expect("alive").statuses = statuses;
        Ok(())
    }
}

fn id(of: u8) -> Uuid {
    Uuid { uuid: [of; 16] }
}

fn of_goal(of: u8) -> GoalInfo {
    GoalInfo {
        goal_id: id(of),
        stamp: Time::default(),
    }
}

fn server() -> (Client, ActionServer<A>) {
    let client = Client::default();
    let server = ActionServer::new("/gripper", Box::new(client.clone()));
    (client, server)
}

#[test]
fn result_arrives_before_and_after_the_end() {
    let (client, mut server) = server();
    let wire = || client.0.lock().expect("alive");
    wire().goals.push_back(id(1));
    wire().results.push_back(id(1));
    assert_eq!(server.poll().len(), 1);
    assert!(wire().answered.is_empty(), "the goal has not ended");
    server.execute(&id(1));
    assert_eq!(wire().statuses, [status::EXECUTING]);
    let done = GripperResult {
        stalled: true,
        ..GripperResult::default()
    };
    server.finish(&id(1), status::SUCCEEDED, &done);
    wire().results.push_back(id(1));
    wire().results.push_back(id(9));
    assert!(server.poll().is_empty());
    let known = (status::SUCCEEDED, done);
    let unknown = (status::UNKNOWN, GripperResult::default());
    assert_eq!(wire().answered, [known.clone(), known, unknown]);
}

#[test]
fn reused_identifier_is_rejected() {
    let (client, mut server) = server();
    client.0.lock().expect("alive").goals.extend([id(1), id(1)]);
    assert_eq!(server.poll().len(), 1);
    assert_eq!(client.0.lock().expect("alive").accepted, [true, false]);
}

#[test]
fn cancellation_selects_goals_and_states_its_result() {
    let (client, mut server) = server();
    let wire = || client.0.lock().expect("alive");
    wire().goals.extend([id(1), id(2)]);
    server.poll();
    let mut cancel = |info: GoalInfo| {
        wire().cancels.push_back(info);
        let wanted = server.poll().len();
        let response = wire().cancelled.pop().expect("answered");
        if response.return_code == cancel::DONE {
            let ids: Vec<Uuid> = response
                .goals_canceling
                .iter()
                .map(|i| i.goal_id.clone())
                .collect();
            ids.iter()
                .for_each(|id| server.finish(id, status::CANCELED, &GripperResult::default()));
        }
        (response.return_code, wanted)
    };
    assert_eq!(cancel(of_goal(7)), (cancel::UNKNOWN_GOAL, 0));
    assert_eq!(cancel(of_goal(1)), (cancel::DONE, 1));
    assert_eq!(cancel(of_goal(1)), (cancel::GOAL_TERMINATED, 0));
    assert_eq!(
        cancel(GoalInfo::default()),
        (cancel::DONE, 1),
        "all that remain"
    );
    assert_eq!(cancel(GoalInfo::default()), (cancel::REJECTED, 0));
    assert_eq!(wire().statuses, [status::CANCELED; 2]);
}

#[test]
fn oldest_results_are_forgotten() {
    let (client, mut server) = server();
    for n in 0..GOALS_MAX as u32 + 5 {
        let mut uuid = [0; 16];
        uuid[..4].copy_from_slice(&(n + 1).to_le_bytes());
        client
            .0
            .lock()
            .expect("alive")
            .goals
            .push_back(Uuid { uuid });
        server.poll();
        server.finish(&Uuid { uuid }, status::ABORTED, &GripperResult::default());
    }
    server.poll();
    assert_eq!(server.goals.len(), GOALS_MAX);
}
