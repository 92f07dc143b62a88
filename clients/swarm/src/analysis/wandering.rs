//! Where an agent ends up: circling, standing still, caught beside the object; and who pushes.

use field::TRIAL_FRAMES;

use super::trace::Trace;
use crate::condition::Condition;

/// The last two thirds of a trial, in which a deadlock shows (ours).
const SETTLED: std::ops::RangeInclusive<usize> = TRIAL_FRAMES as usize / 3..=TRIAL_FRAMES as usize;
/// One full turn, in steps.
const TURN: i32 = 64;
/// An agent whose path stays inside a square of this side stands still (ours).
const STILL_PX: f32 = 3.0;
/// An agent no further than this from the object is beside it: a quarter of the field's side (ours; in some presets the light
/// reaches everywhere and says nothing).
const BESIDE_PX: f32 = 200.0;
/// An agent that presses against the object in at least this many frames took part in carrying it (ours).
pub(super) const PUSHING_FRAMES: usize = 9;

/// What an agent does in the last two thirds of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wandering {
    /// It turned by at least one full turn, all in all (paper Fig. 15).
    pub circling: bool,
    /// It did not move.
    pub still: bool,
    /// It ends beside the object, within its light.
    pub at_object: bool,
}

impl Wandering {
    /// Whether the agent did not get away: the paper's deadlock (III.c.1).
    #[must_use]
    pub fn trapped(self) -> bool {
        self.circling || self.still || self.at_object
    }
}

/// What one agent does in a trial.
#[must_use]
pub fn wandering(condition: &Condition, trace: &Trace, agent: usize) -> Wandering {
    let path = &trace.frames[SETTLED];
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
            < condition.model.preset().object_light_px.min(BESIDE_PX),
    }
}

/// Frames in which an agent presses against the object.
#[must_use]
pub fn pushing_frames(trace: &Trace, agent: usize) -> usize {
    let frames = trace.frames.iter();
    frames.filter(|frame| frame.touching[agent]).count()
}
