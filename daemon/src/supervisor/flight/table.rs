//! Tick reports as comma-separated table, one line per tick, with units in the column names.

use std::fmt::Write as _;

use shm_schemas::{FingerReport, HandReport, ModuleEvent, TickReport};

/// Number of fingertips per hand in the table: the paper's hand has two.
const FINGERTIPS_SHOWN: usize = 2;

/// A first line with `#` and the cause, the column names, and a line per tick.
pub(super) fn render(fault: &ModuleEvent, reports: &[TickReport]) -> String {
    let mut text = format!(
        "# atasd {}, tick {}, {}: {}\n",
        env!("CARGO_PKG_VERSION"),
        fault.tick,
        fault.mode,
        fault.reason
    );
    text.push_str(&names());
    for report in reports {
        text.push('\n');
        line(&mut text, report);
    }
    text.push('\n');
    text
}

fn names() -> String {
    let mut names = String::from(
        "tick,captured_ns,mode,goal_id,missed_ticks,wake_late_ns,sensor_to_command_ns,joint_sequence,command_crc32",
    );
    for stage in TickReport::STAGE_NAMES {
        push(&mut names, format_args!("{stage}_ns"));
    }
    for hand in ["left", "right"] {
        for name in [
            "frame_sequence",
            "frame_age_ns",
            "frames",
            "modules_active",
            "step",
            "f1_n",
            "f2_n",
            "stiffness_n_m",
            "centre_x_m",
            "centre_y_m",
            "centre_z_m",
        ] {
            push(&mut names, format_args!("{hand}_{name}"));
        }
        for finger in 0..FINGERTIPS_SHOWN {
            for name in [
                "normal_n",
                "tangential_n",
                "tangential_increment_n",
                "utilisation",
                "utilisation_now",
                "friction",
                "closing_m_s",
                "in_contact",
            ] {
                push(&mut names, format_args!("{hand}_{finger}_{name}"));
            }
        }
    }
    names
}

fn line(text: &mut String, report: &TickReport) {
    // Writing to a string cannot fail.
    let _ = write!(
        text,
        "{},{},{},{},{},{},{},{},{:08x}",
        report.tick,
        report.stamp.captured_ns,
        report.mode,
        report.goal_id,
        report.missed_ticks,
        report.wake_late_ns,
        report.sensor_to_command_ns,
        report.joint_sequence,
        report.command_crc32
    );
    for stage_ns in report.stage_ns {
        push(text, format_args!("{stage_ns}"));
    }
    report.hands.iter().for_each(|hand| push_hand(text, hand));
}

fn push_hand(text: &mut String, hand: &HandReport) {
    let [x_m, y_m, z_m] = hand.centre_m;
    push(
        text,
        format_args!(
            "{},{},{},{},{},{},{},{},{x_m},{y_m},{z_m}",
            hand.frame_sequence,
            hand.frame_age_ns,
            hand.frames,
            hand.modules_active,
            hand.step,
            hand.f1_n,
            hand.f2_n,
            hand.stiffness_n_m
        ),
    );
    hand.fingers[..FINGERTIPS_SHOWN]
        .iter()
        .for_each(|finger| push_finger(text, finger));
}

fn push_finger(text: &mut String, finger: &FingerReport) {
    push(
        text,
        format_args!(
            "{},{},{},{},{},{},{},{}",
            finger.normal_n,
            finger.tangential_n,
            finger.tangential_increment_n,
            finger.utilisation,
            finger.utilisation_now,
            finger.friction,
            finger.closing_m_s,
            finger.in_contact
        ),
    );
}

fn push(text: &mut String, values: std::fmt::Arguments<'_>) {
    // Writing to a string cannot fail.
    let _ = write!(text, ",{values}");
}
