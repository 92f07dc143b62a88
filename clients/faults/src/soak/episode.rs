//! Episode: a task with its object and poses, and random events.

use anyhow::Context;
use atas_core::Settings;
use atas_evaluation::Task;
use robot_model::{HandSide, RobotModel};
use shm_schemas::GoalRequest;
use sim_backend::random::{Random, split_mix};
use sim_backend::{Object, Scene};

use super::event::Event;

/// Ticks of an episode. Design choice: the longest task takes about as long.
pub(super) const EPISODE_TICKS: u64 = 40_000;
/// Largest number of events of an episode. Design choice: several faults meet, and shrinking stays
/// cheap.
const EVENTS_MAX: u64 = 10;
/// Stream of random numbers of an episode.
const STREAM: u64 = 0x50A4;

/// Random course of a task.
#[derive(Clone, Debug)]
pub(super) struct Episode<'a> {
    pub(super) robot: &'a RobotModel,
    /// Index of the robot.
    pub(super) robot_index: usize,
    pub(super) task: Task,
    pub(super) scene: Scene,
    pub(super) goal: GoalRequest,
    pub(super) seed: u64,
    pub(super) settings: Settings,
    /// In the order of their ticks.
    pub(super) events: Vec<Event>,
}

impl<'a> Episode<'a> {
    /// Creates the episode with this number.
    pub(super) fn new(
        robots: &'a [RobotModel],
        seed: u64,
        number: u64,
        settings: Settings,
    ) -> anyhow::Result<Self> {
        let seed = split_mix(split_mix(seed) ^ number);
        let mut random = Random::new(seed, STREAM);
        let mut below = |count: usize| (random.bits() % count.max(1) as u64) as usize;
        let robot_index = below(robots.len());
        let robot = robots.get(robot_index).context("a soak needs a robot")?;
        let tasks: Vec<Task> = Task::ALL
            .into_iter()
            .filter(|task| task.is_supported_by(robot))
            .collect();
        let task = *tasks
            .get(below(tasks.len()))
            .context("the robot supports none of the tasks; choose another --robot")?;
        // Objects that the hand can hold: others may fall without a fault.
        let mut objects: Vec<Object> = match task {
            Task::Grasp | Task::PickPlace => Task::PickPlace.objects()?,
            Task::Screw | Task::Assembly => task.objects()?,
        };
        let object = objects.swap_remove(below(objects.len()));
        let scene = task.scene(robot, object)?.varied(seed);
        let goal = task.goal(&scene, robot.acting_side())?;
        let hand = match robot.acting_side() {
            HandSide::Left => "left",
            HandSide::Right => "right",
        };
        let count = random.bits() % (EVENTS_MAX + 1);
        let mut events: Vec<Event> = (0..count)
            .map(|_| Event::random(&mut random, EPISODE_TICKS, hand, &settings))
            .collect();
        events.sort_by_key(|event| event.tick);
        Ok(Self {
            robot,
            robot_index,
            task,
            scene,
            goal,
            seed,
            settings,
            events,
        })
    }

    /// Returns the episode with only these events.
    pub(super) fn with_events(&self, kept: &[usize]) -> Self {
        let events = kept.iter().filter_map(|&index| self.events.get(index));
        Self {
            events: events.cloned().collect(),
            ..self.clone()
        }
    }
}
