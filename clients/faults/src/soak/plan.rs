//! Plan and report of a soak.

use std::sync::atomic::AtomicBool;
use std::time::Instant;

use atas_core::Settings;
use atas_evaluation::run_indexed;
use robot_model::{ModelError, RobotFiles, RobotModel};
use serde::Serialize;

use super::episode::{EPISODE_TICKS, Episode};
use super::play::play;
use super::shrink::shrink;

/// Random tasks for a number of ticks.
#[derive(Clone, Debug)]
pub struct SoakPlan {
    /// Ticks in total, or of the only episode.
    pub ticks: u64,
    /// Seed of all episodes.
    pub seed: u64,
    /// Only this episode.
    pub episode: Option<u64>,
    /// Only these events of it.
    pub events: Option<Vec<usize>>,
    /// Robots; each episode draws one.
    pub robots: Vec<RobotFiles>,
    /// Further options of the command that repeats a failure, with a space before each.
    pub options: String,
    /// Controller settings.
    pub settings: Settings,
    /// Threads; 0: one per core.
    pub threads: usize,
}

/// Result of a soak.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SoakReport {
    /// Ticks that were run and judged.
    pub ticks: u64,
    /// Violations.
    pub violations: u64,
    /// Ticks per second of wall time, on all threads, without shrinking.
    pub ticks_per_s: f64,
    /// Seed.
    pub seed: u64,
    /// Episodes.
    pub episodes: u64,
    /// Episodes with a violation, in the order of their numbers.
    pub failures: Vec<SoakFailure>,
}

/// Shrunk failure of an episode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct SoakFailure {
    /// Command that repeats it.
    pub command: String,
    /// Rule with value and limit.
    pub violation: String,
}

impl SoakPlan {
    /// Returns the number of episodes.
    #[must_use]
    pub fn episodes(&self) -> u64 {
        match self.episode {
            Some(_) => 1,
            None => self.ticks.div_ceil(EPISODE_TICKS),
        }
    }

    /// Runs all episodes; calls `done` after each one, from any thread; `None` if stopped.
    ///
    /// # Errors
    /// A robot or a world cannot be created.
    pub fn run(
        &self,
        stop: &AtomicBool,
        done: impl Fn() + Sync,
    ) -> anyhow::Result<Option<SoakReport>> {
        let robots: Result<Vec<RobotModel>, ModelError> =
            self.robots.iter().map(RobotFiles::load).collect();
        let robots = robots?;
        let begin = Instant::now();
        let played = run_indexed(self.episodes(), self.threads, stop, |index| {
            let number = self.episode.unwrap_or(index);
            let played = play(&self.chosen(&robots, number)?, self.ticks_of(index), false)?;
            done();
            Ok((number, played))
        })?;
        let elapsed_s = begin.elapsed().as_secs_f64();
        let Some(played) = played else {
            return Ok(None);
        };
        let failed = played.iter().filter_map(|(number, played)| {
            let first = played.first.clone()?;
            Some(self.failure(&robots, *number, first))
        });
        let ticks = played.iter().map(|(_, played)| played.ticks).sum();
        Ok(Some(SoakReport {
            ticks,
            violations: played.iter().map(|(_, played)| played.violations).sum(),
            ticks_per_s: ticks as f64 / elapsed_s.max(f64::EPSILON),
            seed: self.seed,
            episodes: self.episodes(),
            failures: failed.collect::<anyhow::Result<_>>()?,
        }))
    }

    /// Returns an episode with the chosen events.
    fn chosen<'a>(&self, robots: &'a [RobotModel], number: u64) -> anyhow::Result<Episode<'a>> {
        let episode = Episode::new(robots, self.seed, number, self.settings)?;
        Ok(match &self.events {
            None => episode,
            Some(kept) => episode.with_events(kept),
        })
    }

    fn ticks_of(&self, index: u64) -> u64 {
        match self.episode {
            Some(_) => self.ticks,
            None => EPISODE_TICKS.min(self.ticks - index * EPISODE_TICKS),
        }
    }

    fn failure(
        &self,
        robots: &[RobotModel],
        number: u64,
        first: (atas_judge::Violation, u64),
    ) -> anyhow::Result<SoakFailure> {
        let episode = Episode::new(robots, self.seed, number, self.settings)?;
        let all = || (0..episode.events.len()).collect();
        let events = self.events.clone().unwrap_or_else(all);
        let shrunk = shrink(&episode, first, events)?;
        let events: Vec<String> = shrunk.events.iter().map(usize::to_string).collect();
        let (seed, events, ticks) = (self.seed, events.join(","), shrunk.ticks);
        let chosen: Vec<_> = shrunk
            .events
            .iter()
            .filter_map(|&index| episode.events.get(index))
            .map(|event| format!("{:?} at tick {}", event.kind, event.tick))
            .collect();
        Ok(SoakFailure {
            command: format!(
                "atas soak{} --seed {seed} --episode {number} --events {events} --ticks {ticks}",
                self.options
            ),
            violation: format!(
                "{} ({} {} with {}; {})",
                shrunk.violation,
                self.robots[episode.robot_index].name,
                episode.task.name(),
                episode.scene.objects[0].object.name,
                chosen.join(", ")
            ),
        })
    }
}
