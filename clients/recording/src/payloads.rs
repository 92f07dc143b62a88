//! What is recorded: the bus's payloads as their plain bytes, each on a channel whose schema describes the layout.

use shm_schemas::{
    FingerReport, GoalRequest, GraspTarget, HandFrame, HandReport, HandWiringRecord, JointCommand,
    JointState, ModuleEvent, OrderRecord, Payload, Percentiles, Reason, RunHeader, SensorStatus,
    SettingsRecord, Stamp, Status, StepRecord, TableRecord, TaskRecord, TickInputs, TickReport,
    TrackRecord, service,
};

/// Encoding of messages and schemas: the bytes of a `#[repr(C)]` payload, described as text.
pub(crate) const POD: &str = "atas-pod";

/// A payload that is recorded.
pub trait Recorded: Payload {
    /// Channel in the file: the name of the service.
    const TOPIC: &'static str;
    /// Its timestamp.
    fn stamp(&self) -> &Stamp;
    /// Name, offset and size of every field, of the payload itself and of those in it.
    fn schema() -> String;
}

macro_rules! recorded {
    ($($payload:ident at $topic:expr, with $($part:ident)*;)*) => {$(
        impl Recorded for $payload {
            const TOPIC: &'static str = $topic;

            fn stamp(&self) -> &Stamp {
                &self.stamp
            }

            fn schema() -> String {
                let parts = [
                    describe::<Self>(Self::FIELDS),
                    $(describe::<$part>($part::FIELDS),)*
                    describe::<Stamp>(Stamp::FIELDS),
                ];
                format!("# little-endian, no padding; field: offset, size in bytes\n{}", parts.concat())
            }
        }
    )*};
}

recorded! {
    RunHeader at service::RUN_HEADER, with HandWiringRecord SettingsRecord;
    TickInputs at service::TICK_INPUTS, with HandFrame JointState GraspTarget OrderRecord Reason GoalRequest TaskRecord TrackRecord StepRecord TableRecord SettingsRecord JointCommand;
    TickReport at service::TICK_REPORT, with HandReport FingerReport;
    ModuleEvent at service::MODULE_EVENT, with Reason;
    Status at service::STATUS, with Percentiles Reason;
    SensorStatus at service::SENSOR_STATUS, with;
}

fn describe<T: Payload>(fields: &[(&str, usize, usize)]) -> String {
    let mut text = format!("{}: {}\n", T::TYPE_NAME, size_of::<T>());
    for (name, offset, size) in fields {
        text += &format!("  {name}: {offset}, {size}\n");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn schemas_describe_every_byte_of_a_payload() {
        let schema = TickInputs::schema();
        let begin = format!(
            "{}: {}\n  stamp: 0, 24\n",
            TickInputs::TYPE_NAME,
            size_of::<TickInputs>()
        );
        assert!(schema.contains(&begin), "{schema}");
        let part = format!("\n{}: ", HandFrame::TYPE_NAME);
        assert!(schema.contains(&part), "{schema}");
        let sizes: usize = TickInputs::FIELDS.iter().map(|(_, _, size)| size).sum();
        assert_eq!(sizes, size_of::<TickInputs>());
    }
}
