//! Kinematics of a robot file, for clients that know joint positions: leader arms, data sets.

use atas_core::teleop::TeleopWorkspace;
use numpy::{AllowTypeChange, PyArrayLike1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use robot_model::{HandModel, HandVector, RobotModel, TWO_HAND_ARM};

use crate::names::side_of;
use crate::rows::numbers;

/// Forward kinematics of a robot: a built-in name, or the path of a robot file.
#[pyclass(module = "atas", frozen)]
pub(crate) struct Kinematics {
    robot: RobotModel,
    name: String,
}

#[pymethods]
impl Kinematics {
    #[new]
    #[pyo3(signature = (robot = None))]
    fn new(robot: Option<&str>) -> PyResult<Self> {
        let default = TWO_HAND_ARM.name;
        let name = robot.unwrap_or(&default);
        let robot = RobotModel::find(name).map_err(|why| PyValueError::new_err(why.to_string()))?;
        Ok(Self {
            robot,
            name: name.to_owned(),
        })
    }

    /// Names of all joints, left hand first: the order of joint vectors.
    #[getter]
    fn joint_names(&self) -> Vec<&str> {
        self.robot
            .joints()
            .map(|joint| joint.name.as_str())
            .collect()
    }

    /// Indices of the first joint of a hand and of the first one behind it.
    fn joint_range(&self, hand: &str) -> PyResult<(usize, usize)> {
        let range = self.robot.joint_range(self.present(hand)?.side());
        Ok((range.start, range.end))
    }

    /// Number of fingertips of a hand.
    fn fingertips(&self, hand: &str) -> PyResult<usize> {
        Ok(self.present(hand)?.fingertip_count())
    }

    /// Pinch pose of a hand for the positions of all joints (rad or m): the point between the grasp
    /// sides (m), the direction of the closing axis (rad) and the distance between the sides (m).
    /// `Teleop.send` accepts these values.
    fn pinch_pose(
        &self,
        position: PyArrayLike1<'_, f64, AllowTypeChange>,
        hand: &str,
    ) -> PyResult<([f64; 3], f64, f64)> {
        let hand = self.present(hand)?;
        let positions = numbers(&position);
        let needed = self.robot.joint_count();
        if positions.len() != needed {
            return Err(PyValueError::new_err(format!(
                "joint positions rejected: {} numbers, the robot {} needs {needed}",
                positions.len(),
                self.name
            )));
        }
        let own = HandVector::from_slice(&positions[self.robot.joint_range(hand.side())]);
        if let Some(joint) = own.iter().position(|value| !value.is_finite()) {
            return Err(PyValueError::new_err(format!(
                "joint positions rejected: {} of joint {} is not finite; needs finite numbers",
                own[joint],
                hand.joints()[joint].name.as_str()
            )));
        }
        let pose = hand.pinch_pose(&hand.forward(&own));
        Ok((pose.centre_m.into(), pose.closing_yaw_rad, pose.opening_m))
    }

    /// Bounds of teleoperation targets of a hand, m: `x`, `y`, `z` and `opening`, each (least,
    /// most). The daemon rejects targets outside.
    fn teleop_bounds<'py>(&self, py: Python<'py>, hand: &str) -> PyResult<Bound<'py, PyDict>> {
        let side = self.present(hand)?.side();
        let bounds = TeleopWorkspace::new(&self.robot, side).ok_or_else(|| {
            PyValueError::new_err(format!(
                "no bounds of teleoperation: the robot file of {} has no workspace for the {} \
                 hand; add [workspace] to it",
                self.name, hand
            ))
        })?;
        let named = PyDict::new(py);
        for (name, [least_m, most_m]) in ["x", "y", "z"].into_iter().zip(bounds.centre_m) {
            named.set_item(name, (least_m, most_m))?;
        }
        let [least_m, most_m] = bounds.opening_m;
        named.set_item("opening", (least_m, most_m))?;
        Ok(named)
    }

    fn __repr__(&self) -> String {
        format!(
            "Kinematics({:?}): {} joints",
            self.name,
            self.robot.joint_count()
        )
    }
}

impl Kinematics {
    /// Returns a hand that the robot has.
    fn present(&self, hand: &str) -> PyResult<&HandModel> {
        let side = side_of(&self.robot, &self.name, Some(hand))?;
        Ok(self.robot.hand(side))
    }
}
