//! Shrinks a failed episode to the fewest events and ticks that break the same rule.

use atas_judge::Violation;

use super::episode::Episode;
use super::play::play;

/// Shortest failure that was found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Shrunk {
    /// Indices of the remaining events.
    pub(super) events: Vec<usize>,
    pub(super) ticks: u64,
    pub(super) violation: Violation,
}

/// Shrinks a failure of an episode with these events.
pub(super) fn shrink(
    episode: &Episode<'_>,
    (violation, ticks): (Violation, u64),
    events: Vec<usize>,
) -> anyhow::Result<Shrunk> {
    let kind = violation.kind;
    let failed = Shrunk {
        events,
        ticks,
        violation,
    };
    let play = |events: &[usize]| {
        let played = play(&episode.with_events(events), ticks, true)?;
        let first = played.first.filter(|(violation, _)| violation.kind == kind);
        Ok(first.map(|(violation, ticks)| Shrunk {
            events: events.to_vec(),
            ticks,
            violation,
        }))
    };
    remove_events(failed, play)
}

/// Removes events as long as the play fails, first in groups, then one by one.
fn remove_events(
    failed: Shrunk,
    mut play: impl FnMut(&[usize]) -> anyhow::Result<Option<Shrunk>>,
) -> anyhow::Result<Shrunk> {
    let mut best = failed;
    let mut group = best.events.len();
    while group > 0 {
        let mut start = 0;
        while start < best.events.len() {
            let end = (start + group).min(best.events.len());
            let rest = [&best.events[..start], &best.events[end..]].concat();
            match play(&rest)? {
                // The next group has moved to this place.
                Some(shorter) => best = shorter,
                None => start = end,
            }
        }
        group /= 2;
    }
    Ok(best)
}

#[cfg(test)]
mod tests {
    use atas_judge::ViolationKind;

    use super::*;

    fn failed(events: &[usize]) -> Shrunk {
        Shrunk {
            events: events.to_vec(),
            ticks: 100 * events.len() as u64,
            violation: Violation {
                tick: 7,
                kind: ViolationKind::Jerk,
                text: "too much".to_owned(),
            },
        }
    }

    #[test]
    fn only_required_events_remain() {
        let check = |required: &[usize], count: usize| {
            let all: Vec<usize> = (0..count).collect();
            let play = |events: &[usize]| {
                let fails = required.iter().all(|event| events.contains(event));
                Ok(fails.then(|| failed(events)))
            };
            let shrunk = remove_events(failed(&all), play).expect("no error");
            assert_eq!(shrunk, failed(required), "of {count}");
        };
        check(&[2, 5], 8);
        check(&[0], 1);
        check(&[], 3);
        check(&[0, 4, 9], 10);
    }
}
