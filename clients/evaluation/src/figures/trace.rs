//! Trace of one offline trial, tick by tick, as data of a figure.

use robot_model::{GraspSides, HandSide, HandVector, PerSide, RobotModel};
use std::ops::Range;

use anyhow::Context;
use atas_client::GoalProgress;
use atas_core::{Outputs, Settings};
use nalgebra::Vector3;
use shm_schemas::{EventKind, GoalRequest, HandReport, ObjectTruth, WorldTruth};
use sim_backend::{Object, Scene, World};

use crate::offline::OfflineRun;
use crate::trial_seed;
use crate::{SIDE, Task};

pub(super) struct Trace {
    pub(super) scene: Scene,
    pub(super) goal: GoalRequest,
    pub(super) settings: Settings,
    pub(super) progress: GoalProgress,
    pub(super) truth: WorldTruth,
    pub(super) ticks: Vec<Tick>,
    pub(super) dome_radius_m: f64,
    /// Grasp sides of the acting hand.
    pub(super) sides: GraspSides,
    /// Names of the steps entered, and the current step of each hand.
    names: Vec<String>,
    current_steps: [Option<usize>; 2],
}

#[derive(Clone, Debug)]
pub(super) struct Tick {
    pub(super) now_ns: u64,
    /// Time since the goal began, s.
    pub(super) t_s: f64,
    pub(super) hands: [Hand; 2],
    pub(super) object: ObjectTruth,
}

#[derive(Clone, Debug)]
pub(super) struct Hand {
    pub(super) report: HandReport,
    /// True normal force per grasp side, N.
    pub(super) pressed_n: PerSide<f64>,
    /// Commanded centre of each side's fingertips, base frame, m.
    pub(super) tips_m: PerSide<Vector3<f64>>,
    /// Index of the step's name; `None` before the first step.
    step: Option<usize>,
}

impl Trace {
    pub(super) fn run(task: Task, object: &Object, seed: u64) -> anyhow::Result<Self> {
        let robot =
            RobotModel::two_hand_arm().context("could not load the built-in robot model")?;
        let seed = trial_seed(&object.name, seed);
        let scene = task.scene(&robot, object.clone())?.varied(seed);
        let goal = task.goal(&scene, SIDE)?;
        let settings = Settings::default();
        let mut run = OfflineRun::new(&robot, &scene, seed, settings)?;
        let mut trace = Self {
            scene,
            goal,
            settings,
            progress: GoalProgress::default(),
            truth: WorldTruth::default(),
            ticks: Vec::new(),
            dome_radius_m: robot.hand(SIDE).tip_radius_m()[0],
            sides: robot.hand(SIDE).grasp_sides(),
            names: Vec::new(),
            current_steps: [None; 2],
        };
        let begin_ns = run.world().now_ns();
        let trial = run.run(&goal, task.limit_s(), |outputs, world| {
            trace.add(&robot, outputs, world, begin_ns);
        });
        if let Some(fault) = run.world().fault() {
            return Err(fault).context("could not run the task");
        }
        trace.truth = trial.truth;
        anyhow::ensure!(
            !trace.ticks.is_empty(),
            "could not draw the task: the goal was refused: {}",
            trial.end.reason
        );
        Ok(trace)
    }

    fn add(&mut self, robot: &RobotModel, outputs: &Outputs, world: &World, begin_ns: u64) {
        outputs
            .goal_update
            .iter()
            .for_each(|u| self.progress.add(u));
        self.enter_steps(outputs);
        let now = self.current_steps;
        let truth = world.truth();
        let hand = |side: HandSide| {
            let index = side.index();
            let report = outputs.report.hands[index];
            let own = &outputs.command.position[robot.joint_range(side)];
            let hand = robot.hand(side);
            let pose = hand.forward(&HandVector::from_slice(own));
            Hand {
                report,
                pressed_n: hand.grasp_sides().sums(|tip| truth.normal_n[index][tip]),
                tips_m: PerSide::from_fn(|side| pose.side_m(side)),
                step: now[index],
            }
        };
        self.ticks.push(Tick {
            now_ns: world.now_ns(),
            t_s: (world.now_ns() - begin_ns) as f64 * 1e-9,
            hands: HandSide::BOTH.map(hand),
            object: truth.objects[0],
        });
    }

    /// Updates the current steps from events, which include recovery steps.
    fn enter_steps(&mut self, outputs: &Outputs) {
        let entered = outputs
            .events
            .as_slice()
            .iter()
            .filter(|e| e.kind == EventKind::STEP);
        for event in entered {
            let name = event.text.as_str();
            let known = self.names.iter().position(|known| known == name);
            let index = known.unwrap_or_else(|| {
                self.names.push(name.to_owned());
                self.names.len() - 1
            });
            for (hand, now) in shm_schemas::Hand::BOTH.iter().zip(&mut self.current_steps) {
                if *hand == event.hand {
                    *now = Some(index);
                }
            }
        }
    }

    pub(super) fn end_s(&self) -> f64 {
        self.ticks.last().map_or(0.0, |tick| tick.t_s)
    }

    pub(super) fn acting(tick: &Tick) -> &Hand {
        &tick.hands[SIDE.index()]
    }

    pub(super) fn at_s(&self, ns: u64) -> f64 {
        let first = &self.ticks[0];
        first.t_s + (ns as f64 - first.now_ns as f64) * 1e-9
    }

    /// Returns the first time range of a step, s; `None` if the hand never entered it.
    pub(super) fn step_s(&self, side: HandSide, name: &str) -> Option<Range<f64>> {
        let steps = self.steps(side).into_iter();
        steps.into_iter().find(|(n, _)| n == name).map(|(_, s)| s)
    }

    pub(super) fn steps(&self, side: HandSide) -> Vec<(String, Range<f64>)> {
        let mut steps: Vec<(usize, Range<f64>)> = Vec::new();
        for tick in &self.ticks {
            let Some(step) = tick.hands[side.index()].step else {
                continue;
            };
            match steps.last_mut() {
                Some((last, time_s)) if *last == step => time_s.end = tick.t_s,
                before => {
                    if let Some((_, time_s)) = before {
                        time_s.end = tick.t_s;
                    }
                    steps.push((step, tick.t_s..tick.t_s));
                }
            }
        }
        let named = steps.into_iter();
        named
            .map(|(step, time_s)| (self.names[step].clone(), time_s))
            .collect()
    }

    pub(super) fn spans(&self, holds: impl Fn(&Tick) -> bool) -> Vec<Range<f64>> {
        let mut spans: Vec<Range<f64>> = Vec::new();
        let mut before = false;
        for tick in &self.ticks {
            let now = holds(tick);
            match (before, now, spans.last_mut()) {
                (true, _, Some(span)) => span.end = tick.t_s,
                (false, true, _) => spans.push(tick.t_s..tick.t_s),
                _ => {}
            }
            before = now;
        }
        spans
    }

    pub(super) fn series(
        &self,
        time_s: &Range<f64>,
        points: usize,
        value: impl Fn(&Tick) -> f64,
    ) -> Vec<(f64, f64)> {
        let within: Vec<&Tick> = self
            .ticks
            .iter()
            .filter(|tick| time_s.contains(&tick.t_s))
            .collect();
        let every = within.len().div_ceil(points.max(1)).max(1);
        let values = within.iter().step_by(every).map(|t| (t.t_s, value(t)));
        values.filter(|(_, value)| value.is_finite()).collect()
    }
}
