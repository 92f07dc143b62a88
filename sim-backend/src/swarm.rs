//! Swarm fields of methodology 2 for their host: sensor frames out, wheel commands in.
//!
//! A host publishes the frame of [`Swarm::sense`], waits, and calls [`Swarm::advance`] with the
//! commands, or without. Robots without commands stand still for that frame. [`Swarm::show`] writes
//! the state for observers and changes nothing. Several fields share frames and trials only; their
//! robots are numbered field by field.
//!
//! Not included: bus, clock, robot control.

mod show;

use field::{FitnessRule, Layout, MAX_AGENTS, Model, Outcome, TeamSize, TrialRun, Wheels, solved};
use serde::{Deserialize, Serialize};
use shm_schemas::capacity::{self, AGENTS};
use shm_schemas::{AgentSensors, TrialTruth, WheelCommands};

/// Goals of one evaluation (paper III.b.3).
pub const GOALS: u8 = capacity::GOALS as u8;
// Payloads hold every obstacle of a field.
const _: () = assert!(field::MAX_OBSTACLES == capacity::OBSTACLES);
/// Direction steps between two goals: the field has 64 directions.
const GOAL_STEPS: u8 = 8;

/// Settings of a swarm session.
#[derive(Clone, Debug)]
pub struct SwarmSettings {
    /// Field model.
    pub model: Model,
    /// Robots per field.
    pub team: TeamSize,
    /// Number of fields. Field 0 has the training goals; field f rotates its goals by f of 64
    /// directions. Goals of seven of eight fields were therefore not used in evolution.
    pub fields: usize,
    /// Goal of every trial, 1 to 8.
    pub goals: Vec<u8>,
}

/// Reason why settings are rejected.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SwarmError {
    /// More robots than one payload holds, or none.
    #[error(
        "cannot host {fields} fields of {team} robots: {} robots in all, needs 1 to {AGENTS}; \
         choose another --fields",
        fields.saturating_mul(*team)
    )]
    Robots {
        /// Requested fields.
        fields: usize,
        /// Robots per field.
        team: usize,
    },
    /// Unknown goal.
    #[error("cannot host goal {0}: needs 1 to {GOALS}; choose another --goal")]
    Goal(u8),
}

/// Result of one trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrialReport {
    /// Trial index, from 0.
    pub trial: usize,
    /// Goal of field 0, 1 to 8.
    pub goal: u8,
    /// Frames without commands in time; the robots stood still.
    pub missed_frames: u32,
    /// Frames with malformed commands; the robots stood still.
    pub refused_frames: u32,
    /// Behaviour tables used, in order: first eight bytes of their hashes, hexadecimal.
    pub tables: Vec<String>,
    /// Points per field.
    pub points: Vec<f32>,
    /// Outcome per field.
    pub outcomes: Vec<Outcome>,
}

impl TrialReport {
    /// Returns the number of fields whose object reached its goal.
    #[must_use]
    pub fn solved(&self) -> usize {
        self.points.iter().filter(|points| solved(**points)).count()
    }
}

/// Commands to the robots for one frame.
#[derive(Clone, Copy, Debug)]
pub enum FrameCommands<'a> {
    /// Commands for this frame.
    Commands(&'a WheelCommands),
    /// No commands in time.
    Missing,
}

/// Fields of one session.
#[derive(Debug)]
pub struct Swarm {
    settings: SwarmSettings,
    rule: FitnessRule,
    field_hash: u64,
    /// Current trial; after its end it stays current until the next trial's first frame is sensed.
    trial: usize,
    ended: usize,
    runs: Vec<TrialRun>,
    /// Sensor bits of the robots in this frame, per field.
    rows: Vec<[u8; MAX_AGENTS]>,
    /// Latest completed trials; trial t is at index t modulo 8.
    past: [TrialTruth; capacity::GOALS],
    missed_frames: u32,
    refused_frames: u32,
    /// Hashes of this trial; bounded, so that a writer cannot exhaust memory.
    hashes: Vec<u64>,
}

/// Largest number of hashes per trial. Design choice: a user exchanges tables a few times in 270
/// frames.
const HASHES: usize = 32;

impl Swarm {
    /// Returns the fields before the first frame of the first trial.
    ///
    /// # Errors
    /// [`SwarmError`] for invalid settings.
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
            rule: FitnessRule::default_for(settings.model.preset()),
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

    /// Returns whether all trials are complete.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.ended >= self.settings.goals.len()
    }

    /// Writes the sensor bits of all robots, without the stamp. After a trial's last frame this
    /// starts the next trial.
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
        for (reported, (run, rows)) in sensors.row.chunks_exact_mut(team).zip(runs) {
            *rows = run.sense();
            for (reported, row) in reported.iter_mut().zip(rows) {
                *reported = (*row).into();
            }
        }
    }

    /// Simulates one frame. Returns the report after a trial's last frame; allocates only then.
    pub fn advance(&mut self, answer: FrameCommands<'_>) -> Option<TrialReport> {
        let commands = match answer {
            FrameCommands::Commands(commands) if self.accepts(commands) => {
                self.record_hash(commands.table_hash);
                Some(commands)
            }
            FrameCommands::Commands(_) => {
                self.refused_frames += 1;
                None
            }
            FrameCommands::Missing => {
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

    /// Returns whether commands fit these robots and contain motor bits only.
    fn accepts(&self, commands: &WheelCommands) -> bool {
        let robots = self.settings.team.get() * self.runs.len();
        commands.agent_count as usize == robots
            && commands.output[..robots].iter().all(|output| *output < 16)
    }

    fn record_hash(&mut self, hash: u64) {
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
