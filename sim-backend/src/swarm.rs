//! The swarm's fields as their host runs them: sensors out, wheel commands in, frame by frame and trial by trial.
//!
//! A host publishes what [`Swarm::sense`] writes, waits as it likes, and calls [`Swarm::advance`] with the answer, or with
//! nothing: robots that are not told what to do in a frame stand still in it. [`Swarm::show`] tells onlookers, and changes
//! nothing. Several fields may lie side by side; they share frames and trials and nothing else, and their robots come one
//! field after the other.
//!
//! Deliberately absent: the bus, the clock, and whatever decides what the robots do.

mod show;

use field::{FitnessRule, Layout, MAX_AGENTS, Model, Outcome, TeamSize, TrialRun, Wheels, solved};
use serde::{Deserialize, Serialize};
use shm_schemas::capacity::{self, AGENTS};
use shm_schemas::{AgentSensors, TrialTruth, WheelCommands};

/// Goals of one evaluation (paper III.b.3).
pub const GOALS: u8 = capacity::GOALS as u8;
// Every obstacle of a field is told.
const _: () = assert!(field::MAX_OBSTACLES == capacity::OBSTACLES);
/// Steps of a heading between two goals: the field has 64 directions.
const GOAL_STEPS: u8 = 8;

/// What shall be hosted.
#[derive(Clone, Debug)]
pub struct SwarmSettings {
    /// The field.
    pub model: Model,
    /// Robots on each field.
    pub team: TeamSize,
    /// Fields side by side. Field 0 has the training goals; field f has its goals f directions (of 64) further on, so that
    /// seven of eight fields have goals that no table was evolved with.
    pub fields: usize,
    /// The goal of every trial, 1 to 8.
    pub goals: Vec<u8>,
}

/// Settings that cannot be hosted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SwarmError {
    /// Too many robots for one payload, or none.
    #[error(
        "could not host {fields} fields of {team} robots because that is {}, needs 1 to {AGENTS} robots in all; choose another --fields",
        fields.saturating_mul(*team)
    )]
    Robots {
        /// Fields asked for.
        fields: usize,
        /// Robots on each.
        team: usize,
    },
    /// A goal that does not exist.
    #[error(
        "could not host goal {0} because it does not exist, needs 1 to {GOALS}; choose another --goal"
    )]
    Goal(u8),
}

/// What one trial came to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// Counts trials, from 0.
    pub trial: usize,
    /// The goal, 1 to 8, as field 0 had it.
    pub goal: u8,
    /// Frames in which the robots stood still because no answer came in time.
    pub missed_frames: u32,
    /// Frames in which they stood still because the answer was malformed.
    pub refused_frames: u32,
    /// Tables that were looked up, in this order: the first eight bytes of their hashes, hexadecimal.
    pub tables: Vec<String>,
    /// Points per field.
    pub points: Vec<f32>,
    /// Outcome per field.
    pub outcomes: Vec<Outcome>,
}

impl TrialReport {
    /// Fields whose object was carried to its goal.
    #[must_use]
    pub fn solved(&self) -> usize {
        self.points.iter().filter(|points| solved(**points)).count()
    }
}

/// What a host tells the robots in one frame.
#[derive(Clone, Copy, Debug)]
pub enum Answer<'a> {
    /// An answer to this frame.
    Commands(&'a WheelCommands),
    /// None came in time.
    Missing,
}

/// The fields of one session.
#[derive(Debug)]
pub struct Swarm {
    settings: SwarmSettings,
    rule: FitnessRule,
    field_hash: u64,
    /// The trial that the fields show: under way, or over until the next one's first frame is sensed.
    trial: usize,
    /// Trials that are over.
    ended: usize,
    runs: Vec<TrialRun>,
    /// Per field what its robots sense in this frame.
    rows: Vec<[u8; MAX_AGENTS]>,
    /// The newest trials that are over, that of index t in place t modulo 8.
    past: [TrialTruth; capacity::GOALS],
    missed_frames: u32,
    refused_frames: u32,
    /// Hashes seen in this trial; bounded, so that no writer can make it grow.
    hashes: Vec<u64>,
}

/// Hashes that one trial remembers. Ours: a person swaps tables now and then, not hundreds of times in 270 frames.
const HASHES: usize = 32;

impl Swarm {
    /// Fields before the first frame of the first trial.
    ///
    /// # Errors
    /// What of the settings cannot be hosted.
    pub fn new(settings: SwarmSettings) -> Result<Self, SwarmError> {
        let (fields, team) = (settings.fields, settings.team.get());
        if !(1..=AGENTS / team).contains(&fields) {
            return Err(SwarmError::Robots { fields, team });
        }
        if let Some(goal) = settings
            .goals
            .iter()
            .find(|goal| !(1..=GOALS).contains(*goal))
        {
            return Err(SwarmError::Goal(*goal));
        }
        let mut swarm = Self {
            rule: FitnessRule::usual(settings.model.preset()),
            field_hash: settings.model.preset().fingerprint(),
            settings,
            trial: 0,
            ended: 0,
            runs: Vec::with_capacity(fields),
            rows: vec![[0; MAX_AGENTS]; fields],
            past: Default::default(),
            missed_frames: 0,
            refused_frames: 0,
            hashes: Vec::with_capacity(HASHES),
        };
        swarm.begin_trial(0);
        Ok(swarm)
    }

    /// Whether all trials are over.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.ended >= self.settings.goals.len()
    }

    /// Writes what every robot senses now, without the stamp; after the last frame of a trial, in the first of the next one.
    pub fn sense(&mut self, sensors: &mut AgentSensors) {
        if self.trial < self.ended && !self.is_over() {
            self.begin_trial(self.ended);
        }
        let team = self.settings.team.get();
        sensors.frame = self.frame().into();
        sensors.trial = self.trial as u32;
        sensors.agent_count = (team * self.runs.len()) as u32;
        sensors.field_hash = self.field_hash;
        let runs = self.runs.iter_mut().zip(&mut self.rows);
        for (told, (run, rows)) in sensors.row.chunks_exact_mut(team).zip(runs) {
            *rows = run.sense();
            for (told, row) in told.iter_mut().zip(rows) {
                *told = (*row).into();
            }
        }
    }

    /// One frame. Returns what the trial came to if this was its last one; only then it allocates.
    pub fn advance(&mut self, answer: Answer<'_>) -> Option<TrialReport> {
        let commands = match answer {
            Answer::Commands(commands) if self.understands(commands) => {
                self.note(commands.table_hash);
                Some(commands)
            }
            Answer::Commands(_) => {
                self.refused_frames += 1;
                None
            }
            Answer::Missing => {
                self.missed_frames += 1;
                None
            }
        };
        self.drive(commands);
        let over = self.trial == self.ended && self.runs.first().is_some_and(TrialRun::is_over);
        over.then(|| self.end_trial())
    }

    fn points(&self, outcome: &Outcome) -> f32 {
        let SwarmSettings { model, team, .. } = &self.settings;
        self.rule.points(model.preset(), *team, outcome)
    }

    /// Drives every robot by its motor bits, or none.
    fn drive(&mut self, commands: Option<&WheelCommands>) {
        let team = self.settings.team.get();
        for (field, run) in self.runs.iter_mut().enumerate() {
            let mut wheels = [Wheels::STOP; MAX_AGENTS];
            if let Some(commands) = commands {
                let outputs = &commands.output[field * team..][..team];
                for (wheels, output) in wheels.iter_mut().zip(outputs) {
                    *wheels = Wheels::from_motor_bits(*output);
                }
            }
            run.advance(&wheels);
        }
    }

    /// Whether commands are about these robots, and all of them motor bits.
    fn understands(&self, commands: &WheelCommands) -> bool {
        let robots = self.settings.team.get() * self.runs.len();
        commands.agent_count as usize == robots
            && commands.output[..robots].iter().all(|output| *output < 16)
    }

    fn note(&mut self, hash: u64) {
        if self.hashes.last() != Some(&hash) && self.hashes.len() < HASHES {
            self.hashes.push(hash);
        }
    }

    fn frame(&self) -> u32 {
        self.runs.first().map_or(0, TrialRun::frame)
    }

    fn begin_trial(&mut self, trial: usize) {
        self.trial = trial;
        self.runs.clear();
        let SwarmSettings {
            model,
            team,
            fields,
            goals,
        } = &self.settings;
        if let Some(goal) = goals.get(trial) {
            let first = (goal - 1) * GOAL_STEPS;
            let layout = |field: usize| layout_towards(model, (usize::from(first) + field) % 64);
            self.runs
                .extend((0..*fields).map(|field| TrialRun::new(model, *team, &layout(field))));
        }
    }

    fn end_trial(&mut self) -> TrialReport {
        let outcomes: Vec<Outcome> = self.runs.iter().map(TrialRun::outcome).collect();
        let points: Vec<f32> = outcomes
            .iter()
            .map(|outcome| self.points(outcome))
            .collect();
        let report = TrialReport {
            trial: self.trial,
            goal: self.settings.goals[self.trial],
            missed_frames: std::mem::take(&mut self.missed_frames),
            refused_frames: std::mem::take(&mut self.refused_frames),
            tables: self
                .hashes
                .drain(..)
                .map(|hash| format!("{hash:016x}"))
                .collect(),
            points,
            outcomes,
        };
        self.ended += 1;
        for (rows, run) in self.rows.iter_mut().zip(&self.runs) {
            *rows = run.world().sense();
        }
        self.past[self.trial % self.past.len()] = trial_truth(&report);
        report
    }
}

/// What an onlooker is told of a trial that is over.
fn trial_truth(report: &TrialReport) -> TrialTruth {
    TrialTruth {
        trial: report.trial as u32,
        goal: report.goal.into(),
        distance_px: report.outcomes[0].evaluated.goal_px,
        reached_frame: report.outcomes[0].reached_frame,
        points: report.points[0],
        solved_fields: report.solved() as u32,
        missed_frames: report.missed_frames,
        refused_frames: report.refused_frames,
    }
}

fn layout_towards(model: &Model, direction: usize) -> Layout {
    model.training_layout(model.goal_towards(direction as u8))
}
