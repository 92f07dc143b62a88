//! The joints of the robot that the daemon moves: their order in every payload, and what each may do.
//!
//! The only place here that knows a robot; the servo map says which servo moves which of them.

use robot_model::RobotModel;

/// One joint.
#[derive(Clone, Debug, PartialEq)]
pub struct Joint {
    /// Its name in the URDF and in the servo map.
    pub name: String,
    /// Lower position limit, rad.
    pub lower_rad: f64,
    /// Upper position limit, rad.
    pub upper_rad: f64,
    /// Top speed, rad/s.
    pub speed_max_rad_s: f64,
}

/// The joints of a robot in the order of [`JointState`](shm_schemas::JointState): one that ships, or that of a robot file, as
/// the daemon is told.
///
/// # Errors
/// If there is no such robot, or its files are not understood.
pub fn of(robot: &str) -> Result<Vec<Joint>, String> {
    Ok(RobotModel::find(robot)
        .map_err(|error| error.to_string())?
        .joints()
        .map(|joint| Joint {
            name: joint.name.to_string(),
            lower_rad: joint.lower_rad,
            upper_rad: joint.upper_rad,
            speed_max_rad_s: joint.velocity_max_rad_s,
        })
        .collect())
}
