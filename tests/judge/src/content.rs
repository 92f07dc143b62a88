//! Content of a command: every value is finite.

use shm_schemas::JointCommand;

use crate::findings::{Findings, ViolationKind};

/// Reports every value that is not finite; returns true if there is none.
pub(crate) fn is_finite(command: &JointCommand, findings: &mut Findings) -> bool {
    let fields: [(&str, &[f64]); 3] = [
        ("position", &command.position),
        ("velocity", &command.velocity),
        ("grip_limit_n", &command.grip_limit_n),
    ];
    let mut finite = true;
    for (field, values) in fields {
        for (index, value) in values.iter().enumerate() {
            if !value.is_finite() {
                finite = false;
                findings.report(
                    ViolationKind::NotFinite,
                    format_args!("`{field}[{index}]` is {value}"),
                );
            }
        }
    }
    finite
}
