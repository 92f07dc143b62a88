//! Messages and services of standard packages.

use super::{Byte, messages, services};

messages! {
    /// Time, wall clock.
    Time as "builtin_interfaces/msg/Time" {
        /// Seconds since 1970.
        sec: i32,
        /// Nanoseconds of the second.
        nanosec: u32,
    }
    /// Stamp and frame.
    Header as "std_msgs/msg/Header" {
        /// Time of measurement.
        stamp: Time,
        /// Frame of the data.
        frame_id: String,
    }
    /// Text.
    Text as "std_msgs/msg/String" {
        /// Text.
        data: String,
    }
    /// Numbers of one dimension of an array.
    ArrayDimension as "std_msgs/msg/MultiArrayDimension" {
        /// Name of the dimension.
        label: String,
        /// Number of elements.
        size: u32,
        /// Elements between two of this dimension.
        stride: u32,
    }
    /// Dimensions of an array.
    ArrayLayout as "std_msgs/msg/MultiArrayLayout" {
        /// Dimensions.
        dim: Vec<ArrayDimension>,
        /// Elements before the first.
        data_offset: u32,
    }
    /// Array of numbers: commands of a forward-command controller.
    Float64Array as "std_msgs/msg/Float64MultiArray" {
        /// Dimensions.
        layout: ArrayLayout,
        /// Numbers.
        data: Vec<f64>,
    }
    /// Joints by name.
    JointState as "sensor_msgs/msg/JointState" {
        /// Time of measurement.
        header: Header,
        /// Names.
        name: Vec<String>,
        /// Positions, rad or m.
        position: Vec<f64>,
        /// Velocities, rad/s or m/s.
        velocity: Vec<f64>,
        /// Efforts, N·m or N.
        effort: Vec<f64>,
    }
    /// Field of the points of a cloud.
    PointField as "sensor_msgs/msg/PointField" {
        /// Name.
        name: String,
        /// Offset in the point, bytes.
        offset: u32,
        /// Code of the number type.
        datatype: u8,
        /// Number of elements.
        count: u32,
    }
    /// Points with fields.
    PointCloud as "sensor_msgs/msg/PointCloud2" {
        /// Time and frame.
        header: Header,
        /// Rows.
        height: u32,
        /// Points per row.
        width: u32,
        /// Fields of a point.
        fields: Vec<PointField>,
        /// Byte order.
        is_bigendian: bool,
        /// Size of a point, bytes.
        point_step: u32,
        /// Size of a row, bytes.
        row_step: u32,
        /// Points.
        data: Vec<u8>,
        /// True if all points are valid.
        is_dense: bool,
    }
    /// Vector.
    Vector3 as "geometry_msgs/msg/Vector3" {
        /// Component along x.
        x: f64,
        /// Component along y.
        y: f64,
        /// Component along z.
        z: f64,
    }
    /// Point.
    Point as "geometry_msgs/msg/Point" {
        /// Coordinate x, m.
        x: f64,
        /// Coordinate y, m.
        y: f64,
        /// Coordinate z, m.
        z: f64,
    }
    /// Rotation.
    Quaternion as "geometry_msgs/msg/Quaternion" {
        /// Component x.
        x: f64,
        /// Component y.
        y: f64,
        /// Component z.
        z: f64,
        /// Component w.
        w: f64,
    }
    /// Pose of a frame in its parent.
    Transform as "geometry_msgs/msg/Transform" {
        /// Origin, m.
        translation: Vector3,
        /// Orientation.
        rotation: Quaternion,
    }
    /// Pose of a child frame.
    TransformStamped as "geometry_msgs/msg/TransformStamped" {
        /// Time and parent frame.
        header: Header,
        /// Child frame.
        child_frame_id: String,
        /// Pose of the child in the parent.
        transform: Transform,
    }
    /// Poses of frames.
    Transforms as "tf2_msgs/msg/TFMessage" {
        /// Poses.
        transforms: Vec<TransformStamped>,
    }
    /// Force and torque.
    Wrench as "geometry_msgs/msg/Wrench" {
        /// Force, N.
        force: Vector3,
        /// Torque, N·m.
        torque: Vector3,
    }
    /// Force and torque in a frame.
    WrenchStamped as "geometry_msgs/msg/WrenchStamped" {
        /// Time and frame.
        header: Header,
        /// Force and torque.
        wrench: Wrench,
    }
    /// Key and value.
    KeyValue as "diagnostic_msgs/msg/KeyValue" {
        /// Key.
        key: String,
        /// Value.
        value: String,
    }
    /// Condition of one component.
    DiagnosticStatus as "diagnostic_msgs/msg/DiagnosticStatus" {
        /// 0 good, 1 warning, 2 error, 3 stale.
        level: Byte,
        /// Component.
        name: String,
        /// Condition as text.
        message: String,
        /// Hardware.
        hardware_id: String,
        /// Values.
        values: Vec<KeyValue>,
    }
    /// Conditions of components.
    DiagnosticArray as "diagnostic_msgs/msg/DiagnosticArray" {
        /// Time.
        header: Header,
        /// Conditions.
        status: Vec<DiagnosticStatus>,
    }
    /// Log record.
    Log as "rcl_interfaces/msg/Log" {
        /// Time.
        stamp: Time,
        /// 10 debug, 20 info, 30 warning, 40 error, 50 fatal.
        level: u8,
        /// Logger.
        name: String,
        /// Text.
        msg: String,
        /// File of the source.
        file: String,
        /// Function of the source.
        function: String,
        /// Line of the source.
        line: u32,
    }
    /// Duration.
    Duration as "builtin_interfaces/msg/Duration" {
        /// Seconds.
        sec: i32,
        /// Nanoseconds of the second.
        nanosec: u32,
    }
    /// Point of a joint trajectory.
    TrajectoryPoint as "trajectory_msgs/msg/JointTrajectoryPoint" {
        /// Positions, rad or m.
        positions: Vec<f64>,
        /// Velocities, rad/s or m/s.
        velocities: Vec<f64>,
        /// Accelerations, rad/s² or m/s².
        accelerations: Vec<f64>,
        /// Efforts, N·m or N.
        effort: Vec<f64>,
        /// Time after the start of the trajectory.
        time_from_start: Duration,
    }
    /// Joint trajectory.
    JointTrajectory as "trajectory_msgs/msg/JointTrajectory" {
        /// Time of the start; zero means now.
        header: Header,
        /// Joints.
        joint_names: Vec<String>,
        /// Points.
        points: Vec<TrajectoryPoint>,
    }
    /// Identifier of a goal.
    Uuid as "unique_identifier_msgs/msg/UUID" {
        /// Identifier.
        uuid: [u8; 16],
    }
    /// Identifier of a goal and its time.
    GoalInfo as "action_msgs/msg/GoalInfo" {
        /// Identifier.
        goal_id: Uuid,
        /// Time of acceptance.
        stamp: Time,
    }
    /// State of a goal.
    GoalStatus as "action_msgs/msg/GoalStatus" {
        /// Goal.
        goal_info: GoalInfo,
        /// State, see [`super::action::status`].
        status: i8,
    }
    /// States of goals.
    GoalStatusArray as "action_msgs/msg/GoalStatusArray" {
        /// States.
        status_list: Vec<GoalStatus>,
    }
    /// Request to cancel goals.
    CancelGoalRequest as "action_msgs/srv/CancelGoal_Request" {
        /// Identifier, or zero, and time, or zero.
        goal_info: GoalInfo,
    }
    /// Answer to a cancellation.
    CancelGoalResponse as "action_msgs/srv/CancelGoal_Response" {
        /// Result, see [`super::action::cancel`].
        return_code: i8,
        /// Goals that are being cancelled.
        goals_canceling: Vec<GoalInfo>,
    }
    /// Origin of a service event.
    ServiceEventInfo as "service_msgs/msg/ServiceEventInfo" {
        /// Kind of the event.
        event_type: u8,
        /// Time.
        stamp: Time,
        /// Identifier of the client.
        client_gid: [u8; 16],
        /// Number of the request.
        sequence_number: i64,
    }
    /// Request without fields.
    TriggerRequest as "std_srvs/srv/Trigger_Request" {
        /// Placeholder of ROS 2 for an empty structure.
        structure_needs_at_least_one_member: u8,
    }
    /// Answer of a service that only acts.
    TriggerResponse as "std_srvs/srv/Trigger_Response" {
        /// True if done.
        success: bool,
        /// Result or cause as text.
        message: String,
    }
}

services! {
    /// Service that only acts.
    Trigger as "std_srvs/srv/Trigger": TriggerRequest => TriggerResponse;
    /// Cancellation of goals.
    CancelGoal as "action_msgs/srv/CancelGoal": CancelGoalRequest => CancelGoalResponse;
}
