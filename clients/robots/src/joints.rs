//! Joints of the daemon's robot: order and limits.
//!
//! The only module here that reads the robot model. The servo map assigns a servo to each joint.

use robot_model::RobotModel;

/// One joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name in the URDF and in the servo map.
    pub name: String,
    /// Lower position limit, rad or m.
    pub lower: f64,
    /// Upper position limit, rad or m.
    pub upper: f64,
    /// Position in the reference posture of the robot file, rad or m.
    pub rest_rad: f64,
    /// Maximum speed, rad/s or m/s.
    pub speed_max_rad_s: f64,
}

/// Returns the joints of a built-in robot or of a robot file, in the order of
/// [`JointState`](shm_schemas::JointState).
///
/// # Errors
/// If the robot does not exist or its files are invalid.
pub fn load(robot: &str) -> Result<Vec<Joint>, String> {
    let robot = RobotModel::find(robot).map_err(|error| error.to_string())?;
    let rest_rad = robot
        .sides()
        .flat_map(|side| robot.hand(side).reference().iter().copied());
    Ok(robot
        .joints()
        .zip(rest_rad)
        .map(|(joint, rest_rad)| Joint {
            name: joint.name.to_string(),
            lower: joint.lower,
            upper: joint.upper,
            rest_rad,
            speed_max_rad_s: joint.velocity_max,
        })
        .collect())
}
