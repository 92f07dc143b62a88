//! Motion limiter of all coordinates of a [`GraspPose`].

use super::axis::{Axis, Bounds};
use robot_model::{GRASP_SIDES, GraspPose, PerSide};

/// Coordinates: three of the centre, three angles, three per side.
const AXES: usize = FIRST_ANGLE + 3 + 3 * GRASP_SIDES;
/// First angle: yaw, pitch, roots. The azimuth follows from the position.
const FIRST_ANGLE: usize = 3;
/// First side coordinate: openings, tangential offsets, heights.
const FIRST_SIDE: usize = FIRST_ANGLE + 3;

/// Highest speeds and time constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpeedLimits {
    /// Each coordinate of the centre, m/s.
    pub move_m_s: f64,
    /// Each angle, rad/s.
    pub turn_rad_s: f64,
    /// Each grasp side, m/s.
    pub finger_m_s: f64,
    /// Time from rest to the highest speed, s.
    pub speed_up_s: f64,
    /// Time constant of the low-pass, s.
    pub smooth_s: f64,
}

impl SpeedLimits {
    /// Returns the bounds at a share of the highest speed, 0 to 1; the acceleration is not scaled.
    fn bounds(&self, axis: usize, share: f64) -> Bounds {
        let speed = match axis {
            0..FIRST_ANGLE => self.move_m_s,
            FIRST_ANGLE..FIRST_SIDE => self.turn_rad_s,
            _ => self.finger_m_s,
        };
        Bounds {
            speed: speed * share,
            acceleration: speed / self.speed_up_s,
            smooth_s: self.smooth_s,
        }
    }
}

/// Motion limiter of a teleoperated hand.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct MotionLimiter {
    axes: [Axis; AXES],
    azimuth_rad: f64,
}

impl MotionLimiter {
    /// Creates a limiter at rest in a pose.
    #[must_use]
    pub fn new(frame: &GraspPose) -> Self {
        Self {
            axes: coordinates(frame).map(Axis::new),
            azimuth_rad: frame.hand_azimuth_rad,
        }
    }

    /// Takes over finger positions set by other modules.
    pub fn set_fingers(&mut self, frame: &GraspPose) {
        let now = coordinates(frame);
        for (axis, now) in self.axes.iter_mut().zip(now).skip(FIRST_SIDE) {
            *axis = Axis::new(now);
        }
    }

    /// Moves one tick towards a pose, else to rest, at a share of the highest hand and wrist speed,
    /// 0 to 1.
    pub fn step_towards(
        &mut self,
        wanted: Option<&GraspPose>,
        speeds: &SpeedLimits,
        share: f64,
        step_s: f64,
    ) -> GraspPose {
        let targets = wanted.map(coordinates);
        for (index, axis) in self.axes.iter_mut().enumerate() {
            let share = if index < FIRST_SIDE { share } else { 1.0 };
            let target = targets.map(|targets| targets[index]);
            axis.step_towards(target, &speeds.bounds(index, share), step_s);
        }
        if let Some(wanted) = wanted {
            self.azimuth_rad = wanted.hand_azimuth_rad;
        }
        self.pose()
    }

    /// Returns the current pose.
    #[must_use]
    pub fn pose(&self) -> GraspPose {
        let at = |index: usize| self.axes[index].position();
        let of_finger = |kind: usize| {
            PerSide::from_fn(|side| at(FIRST_SIDE + kind * GRASP_SIDES + side.index()))
        };
        GraspPose {
            centre_m: [at(0), at(1), at(2)].into(),
            closing_yaw_rad: at(FIRST_ANGLE),
            hand_azimuth_rad: self.azimuth_rad,
            hand_pitch_rad: at(FIRST_ANGLE + 1),
            root_rad: at(FIRST_ANGLE + 2),
            half_opening_m: of_finger(0),
            tangential_m: of_finger(1),
            up_m: of_finger(2),
        }
    }
}

fn coordinates(frame: &GraspPose) -> [f64; AXES] {
    let mut all = [0.0; AXES];
    all[..FIRST_ANGLE].copy_from_slice(frame.centre_m.as_slice());
    all[FIRST_ANGLE..FIRST_SIDE].copy_from_slice(&[
        frame.closing_yaw_rad,
        frame.hand_pitch_rad,
        frame.root_rad,
    ]);
    let kinds = [frame.half_opening_m, frame.tangential_m, frame.up_m];
    for (slot, value) in all[FIRST_SIDE..]
        .iter_mut()
        .zip(kinds.into_iter().flatten())
    {
        *slot = value;
    }
    all
}
