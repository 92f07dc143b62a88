//! Joints of the daemon's robot: order and limits.
//!
//! The only module here that reads the robot model. The servo map assigns a servo to each joint.

use robot_model::RobotModel;

/// One joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Name in the URDF and in the servo map.
    pub name: String,
    /// Lower position limit, rad.
    pub lower_rad: f64,
    /// Upper position limit, rad.
    pub upper_rad: f64,
    /// Position in the reference posture of the robot file, rad.
    pub rest_rad: f64,
    /// Maximum speed, rad/s.
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
        .flat_map(|side| robot.hand(side).reference_rad().iter().copied());
    Ok(robot
        .joints()
        .zip(rest_rad)
        .map(|(joint, rest_rad)| Joint {
            name: joint.name.to_string(),
            lower_rad: joint.lower_rad,
            upper_rad: joint.upper_rad,
            rest_rad,
            speed_max_rad_s: joint.velocity_max_rad_s,
        })
        .collect())
}
