//! Classification of an agent's motion: circling, standing still, staying beside the object; and
//! detection of pushing.

use field::TRIAL_FRAMES;

use super::trace::Trace;
use crate::condition::Condition;

/// Evaluated frames: the last two thirds of a trial, in which deadlocks are visible (design
/// choice).
const EVALUATED_FRAMES: std::ops::RangeInclusive<usize> =
    TRIAL_FRAMES as usize / 3..=TRIAL_FRAMES as usize;
/// One full turn, in heading steps.
const TURN: i32 = 64;
/// Side of the square that limits the path of an agent that stands still (design choice).
const STILL_PX: f32 = 3.0;
/// Largest distance of an agent beside the object: a quarter of the field's side. Design choice: in
/// some presets the light reaches everywhere and cannot serve as limit.
const BESIDE_OBJECT_PX: f32 = 200.0;
/// Frames of contact from which an agent counts as carrying the object (design choice).
pub(super) const PUSHING_FRAMES: usize = 9;

/// Motion of an agent in the last two thirds of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wandering {
    /// Net rotation of at least one full turn (paper Fig. 15).
    pub circling: bool,
    /// No motion.
    pub still: bool,
    /// The agent ends beside the object, within its light.
    pub at_object: bool,
}

impl Wandering {
    /// Returns whether the agent is trapped: the deadlock of the paper (III.c.1).
    #[must_use]
    pub fn trapped(self) -> bool {
        self.circling || self.still || self.at_object
    }
}

/// Classifies the motion of one agent in a trial.
#[must_use]
pub fn wandering(condition: &Condition, trace: &Trace, agent: usize) -> Wandering {
    let path = &trace.frames[EVALUATED_FRAMES];
    let steps = path.windows(2).map(|pair| {
        let turn =
            i32::from(pair[1].agents[agent].heading) - i32::from(pair[0].agents[agent].heading);
        (turn + 3 * TURN / 2).rem_euclid(TURN) - TURN / 2
    });
    let extent = |coordinate: fn(&field::Pose) -> f32| {
        let values = path.iter().map(|frame| coordinate(&frame.agents[agent]));
        let (low, high) = values.fold((f32::MAX, f32::MIN), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        high - low
    };
    let last = &trace.frames[TRIAL_FRAMES as usize];
    let (dx, dy) = (
        last.agents[agent].x_px - last.object.x_px,
        last.agents[agent].y_px - last.object.y_px,
    );
    Wandering {
        circling: steps.sum::<i32>().abs() >= TURN,
        still: extent(|pose| pose.x_px).max(extent(|pose| pose.y_px)) < STILL_PX,
        at_object: (dx * dx + dy * dy).sqrt()
            < condition
                .model
                .preset()
                .object_light_px
                .min(BESIDE_OBJECT_PX),
    }
}

/// Counts the frames in which an agent presses against the object.
#[must_use]
pub fn pushing_frames(trace: &Trace, agent: usize) -> usize {
    let frames = trace.frames.iter();
    frames.filter(|frame| frame.touching[agent]).count()
}
