//! ROS 2 messages of an exported recording: definitions and serialisation.

use robot_model::Placement;

use super::cdr::Cdr;

/// ROS 2 message type: name, definition and nested types.
#[derive(Debug)]
pub struct MessageType {
    /// Name, for example `std_msgs/msg/Float64`.
    pub name: &'static str,
    definition: &'static str,
    parts: &'static [(&'static str, &'static str)],
}

const TIME: (&str, &str) = ("builtin_interfaces/Time", "int32 sec\nuint32 nanosec");
const STAMPED: (&str, &str) = (
    "std_msgs/Header",
    "builtin_interfaces/Time stamp\nstring frame_id",
);
const VECTOR: (&str, &str) = ("geometry_msgs/Vector3", "float64 x\nfloat64 y\nfloat64 z");

pub(super) const JOINT_STATE: MessageType = MessageType {
    name: "sensor_msgs/msg/JointState",
    definition: "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    parts: &[STAMPED, TIME],
};
pub(super) const TRANSFORMS: MessageType = MessageType {
    name: "tf2_msgs/msg/TFMessage",
    definition: "geometry_msgs/TransformStamped[] transforms",
    parts: &[
        (
            "geometry_msgs/TransformStamped",
            "std_msgs/Header header\nstring child_frame_id\ngeometry_msgs/Transform transform",
        ),
        (
            "geometry_msgs/Transform",
            "geometry_msgs/Vector3 translation\ngeometry_msgs/Quaternion rotation",
        ),
        (
            "geometry_msgs/Quaternion",
            "float64 x\nfloat64 y\nfloat64 z\nfloat64 w",
        ),
        VECTOR,
        STAMPED,
        TIME,
    ],
};
pub(super) const CLOUD: MessageType = MessageType {
    name: "sensor_msgs/msg/PointCloud2",
    definition: "std_msgs/Header header\nuint32 height\nuint32 width\nsensor_msgs/PointField[] fields\nbool is_bigendian\n\
                 uint32 point_step\nuint32 row_step\nuint8[] data\nbool is_dense",
    parts: &[
        (
            "sensor_msgs/PointField",
            "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\nuint8 UINT32=6\nuint8 FLOAT32=7\n\
             uint8 FLOAT64=8\nstring name\nuint32 offset\nuint8 datatype\nuint32 count",
        ),
        STAMPED,
        TIME,
    ],
};
pub(super) const WRENCH: MessageType = MessageType {
    name: "geometry_msgs/msg/WrenchStamped",
    definition: "std_msgs/Header header\ngeometry_msgs/Wrench wrench",
    parts: &[
        (
            "geometry_msgs/Wrench",
            "geometry_msgs/Vector3 force\ngeometry_msgs/Vector3 torque",
        ),
        VECTOR,
        STAMPED,
        TIME,
    ],
};
pub(super) const SCALAR: MessageType = MessageType {
    name: "std_msgs/msg/Float64",
    definition: "float64 data",
    parts: &[],
};
pub(super) const TEXT: MessageType = MessageType {
    name: "std_msgs/msg/String",
    definition: "string data",
    parts: &[],
};
pub(super) const LOG: MessageType = MessageType {
    name: "rcl_interfaces/msg/Log",
    definition: "byte DEBUG=10\nbyte INFO=20\nbyte WARN=30\nbyte ERROR=40\nbyte FATAL=50\nbuiltin_interfaces/Time stamp\n\
                 uint8 level\nstring name\nstring msg\nstring file\nstring function\nuint32 line",
    parts: &[TIME],
};

impl MessageType {
    /// Language of the definition, as named by MCAP.
    pub const LANGUAGE: &'static str = "ros2msg";
    /// Encoding of the messages.
    pub const ENCODING: &'static str = "cdr";

    /// Returns the definition with those of nested types.
    #[must_use]
    pub fn schema(&self) -> String {
        let parts = self
            .parts
            .iter()
            .map(|(name, definition)| format!("\n{}\nMSG: {name}\n{definition}", "=".repeat(80)));
        [self.definition.to_owned()]
            .into_iter()
            .chain(parts)
            .collect()
    }
}

/// Severity of a [`LOG`].
#[derive(Clone, Copy)]
pub(super) enum Level {
    Info = 20,
    Warning = 30,
    Error = 40,
}

/// Fields of a fingertip's point cloud, 4-byte floats.
const FIELDS: [&str; 7] = ["x", "y", "z", "fx", "fy", "fz", "force"];
const FLOAT32: u8 = 7;
const FLOAT_BYTES: usize = 4;

impl Cdr {
    fn time(&mut self, unix_ns: u64) -> &mut Self {
        self.u32((unix_ns / 1_000_000_000) as u32)
            .u32((unix_ns % 1_000_000_000) as u32)
    }

    fn stamped(&mut self, unix_ns: u64, frame: &str) -> &mut Self {
        self.begin().time(unix_ns).text(frame)
    }

    pub(super) fn joints(&mut self, unix_ns: u64, names: &[String], values: [&[f64]; 3]) {
        self.stamped(unix_ns, "").length(names.len());
        names.iter().for_each(|name| {
            self.text(name);
        });
        for values in values {
            self.length(values.len()).f64s(values);
        }
    }

    /// Writes the pose of each child in its parent.
    pub(super) fn transforms<'a>(
        &mut self,
        unix_ns: u64,
        placed: impl ExactSizeIterator<Item = (&'a str, &'a str, Placement)>,
    ) {
        self.begin().length(placed.len());
        for (parent, child, at) in placed {
            self.time(unix_ns).text(parent).text(child);
            self.f64s(&at.translation_m).f64s(&at.rotation_xyzw);
        }
    }

    pub(super) fn wrench(&mut self, unix_ns: u64, frame: &str, force: [f64; 3], torque: [f64; 3]) {
        self.stamped(unix_ns, frame).f64s(&force).f64s(&torque);
    }

    pub(super) fn scalar(&mut self, value: f64) {
        self.begin().f64(value);
    }

    pub(super) fn log(&mut self, unix_ns: u64, level: Level, name: &str, sentence: &str) {
        self.begin()
            .time(unix_ns)
            .u8(level as u8)
            .text(name)
            .text(sentence);
        self.text("").text("").u32(0);
    }

    /// Writes the elements of a fingertip with their forces, tip frame.
    pub(super) fn cloud(&mut self, unix_ns: u64, frame: &str, points: &[[f32; 7]]) {
        let step = FIELDS.len() * FLOAT_BYTES;
        self.stamped(unix_ns, frame);
        self.u32(1).length(points.len()).length(FIELDS.len());
        for (index, name) in FIELDS.iter().enumerate() {
            self.text(name)
                .length(index * FLOAT_BYTES)
                .u8(FLOAT32)
                .u32(1);
        }
        let data: Vec<u8> = points
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        self.u8(0)
            .length(step)
            .length(step * points.len())
            .blob(&data)
            .u8(1);
    }
}
