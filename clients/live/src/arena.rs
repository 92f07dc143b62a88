//! Swarm fields for the page, while a field process runs and after its end.

use std::time::{Duration, Instant};

use atas_client::{ClientError, Session, json};
use serde_json::Value;
use shm_bus::{STREAMS, Subscriber};
use shm_schemas::{ArenaTruth, service};

use crate::feed::Feed;

/// Number of fields drawn, from the first; more would be too small to see and costly.
const FIELDS_MAX: u32 = 64;
/// Silence after which the presence of a field process is checked (design choice: 60 missing
/// pictures).
const SILENCE: Duration = Duration::from_secs(1);
/// Polls between two such checks, each of which reopens the service.
const HOST_CHECK_POLLS: u64 = 30;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum FieldState {
    Runs,
    /// It waits for a controller of its agents.
    Waits,
    Ended,
}

impl FieldState {
    fn name(self) -> &'static str {
        match self {
            Self::Runs => "runs",
            Self::Waits => "waits",
            Self::Ended => "ended",
        }
    }
}

pub(crate) struct Arena {
    truths: Subscriber<ArenaTruth>,
    truth: Box<ArenaTruth>,
    last_received: Instant,
    host: FieldState,
    polls: u64,
}

impl Arena {
    /// Joins the bus. A swarm may start and end at any time.
    ///
    /// # Errors
    /// No free reader slot.
    pub(crate) fn join(session: &Session) -> Result<Self, ClientError> {
        Ok(Self {
            truths: session.bus().subscriber(service::ARENA_TRUTH)?,
            truth: Box::default(),
            last_received: Instant::now(),
            host: FieldState::Ended,
            polls: 0,
        })
    }

    /// Sends new data to the pages, or the last data if `has_new_page`.
    ///
    /// # Errors
    /// The shared memory of the field process cannot be read.
    pub(crate) fn poll(
        &mut self,
        session: &Session,
        feed: &Feed,
        has_new_page: bool,
    ) -> Result<(), ClientError> {
        let before = self.host;
        let is_new = self.truths.newest(&mut self.truth)?;
        if is_new {
            self.last_received = Instant::now();
            self.host = FieldState::Runs;
        } else if self.polls.is_multiple_of(HOST_CHECK_POLLS)
            && self.last_received.elapsed() > SILENCE
        {
            self.host = silent_state(session)?;
        }
        self.polls += 1;
        let is_wanted = is_new || has_new_page || self.host != before;
        if is_wanted && self.truth.field_count > 0 && feed.pages() > 0 {
            feed.send("arena", &arena_json(&self.truth, self.host));
        }
        Ok(())
    }
}

/// Returns the state of a silent field process.
fn silent_state(session: &Session) -> Result<FieldState, ClientError> {
    let stream = STREAMS.iter().find(|s| s.service == service::ARENA_TRUTH);
    let traffic = stream.map_or(Ok(Default::default()), |s| session.bus().port_count(s))?;
    Ok(match traffic.writers {
        0 => FieldState::Ended,
        _ => FieldState::Waits,
    })
}

/// Formats the arena as `atas topic echo` does, limited to the drawn fields, with the state of the
/// field process.
fn arena_json(truth: &ArenaTruth, host: FieldState) -> Value {
    let field_count = truth.field_count.min(FIELDS_MAX);
    let mut value = json::arena(&ArenaTruth {
        field_count,
        agent_count: truth.agent_count.min(field_count * truth.team),
        ..*truth
    });
    value["field_count"] = truth.field_count.into();
    value["host"] = host.name().into();
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_contains_drawn_fields_only() {
        let check = |field_count, team, fields, agents| {
            let mut truth = Box::<ArenaTruth>::default();
            (truth.field_count, truth.team) = (field_count, team);
            truth.agent_count = field_count * team;
            let value = arena_json(&truth, FieldState::Runs);
            let count = |key: &str| value[key].as_array().map_or(0, Vec::len);
            assert_eq!((count("fields"), count("agents")), (fields, agents));
            assert_eq!(value["field_count"], field_count);
        };
        check(1, 2, 1, 2);
        check(64, 4, 64, 256);
        check(256, 4, 64, 256);
        check(1024, 1, 64, 64);
    }
}
