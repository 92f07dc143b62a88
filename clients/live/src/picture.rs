//! Picture: data that a page draws at one tick.

use serde::Serialize;
use shm_schemas::capacity::HANDS;
use shm_schemas::{HandFrame, HandReport, JointState, TickReport};

/// One tick. NaN becomes `null`.
#[derive(Debug, Serialize)]
pub(crate) struct Picture {
    pub(crate) tick: u64,
    /// Time in the sensors' clock, s.
    pub(crate) t_s: f64,
    pub(crate) mode: &'static str,
    /// Active goal, 0 if none.
    pub(crate) goal_id: u64,
    /// Left, right.
    pub(crate) hands: [HandPicture; HANDS],
    /// Joint positions, rad or m; empty if unknown.
    pub(crate) q: Vec<f32>,
}

#[derive(Debug, Serialize)]
pub(crate) struct HandPicture {
    f1_n: f32,
    f2_n: f32,
    stiffness_n_m: f32,
    /// Bit mask of active modules by number.
    modules: u32,
    /// Age of the newest frame, ms; `null` before the first.
    age_ms: Option<f32>,
    /// Fingertips with sensors.
    fingers: Vec<FingerPicture>,
}

#[derive(Debug, Serialize)]
pub(crate) struct FingerPicture {
    normal_n: f32,
    tangential_n: f32,
    tangential_increment_n: f32,
    utilisation: f32,
    friction: f32,
    closing_m_s: f32,
    /// Forces `[f_n, f_t1, f_t2]` per element, N; `null` for an invalid element, empty without a
    /// frame.
    elements: Vec<Option<[f32; 3]>>,
}

impl Picture {
    /// Makes a picture from a report and the newest frames and joints, for given numbers of
    /// fingertips and elements.
    pub(crate) fn from_report(
        report: &TickReport,
        frames: [Option<&HandFrame>; HANDS],
        joints: Option<&JointState>,
        fingers: [usize; HANDS],
        elements: [usize; HANDS],
    ) -> Self {
        let hand = |hand: usize| {
            let counts = [fingers[hand], elements[hand]];
            hand_picture(&report.hands[hand], frames[hand], counts)
        };
        let positions = joints.map_or(&[][..], |joints| {
            let count = (joints.joint_count as usize).min(joints.position.len());
            &joints.position[..count]
        });
        Self {
            tick: report.tick,
            t_s: report.stamp.captured_ns as f64 * 1e-9,
            mode: report.mode.name(),
            goal_id: report.goal_id,
            hands: std::array::from_fn(hand),
            q: positions.iter().map(|q| rounded(*q as f32)).collect(),
        }
    }
}

fn hand_picture(
    report: &HandReport,
    frame: Option<&HandFrame>,
    [fingers, elements]: [usize; 2],
) -> HandPicture {
    let measured = report.fingers.iter().take(fingers).enumerate();
    HandPicture {
        f1_n: rounded(report.f1_n),
        f2_n: rounded(report.f2_n),
        stiffness_n_m: report.stiffness_n_m.round(),
        modules: report.modules_active,
        age_ms: (report.frame_age_ns != u64::MAX)
            .then(|| rounded((report.frame_age_ns as f64 * 1e-6) as f32)),
        fingers: measured
            .map(|(finger, measured)| FingerPicture {
                normal_n: rounded(measured.normal_n),
                tangential_n: rounded(measured.tangential_n),
                tangential_increment_n: rounded(measured.tangential_increment_n),
                utilisation: rounded(measured.utilisation),
                friction: rounded(measured.friction),
                closing_m_s: measured.closing_m_s,
                elements: frame
                    .map_or_else(Vec::new, |frame| element_forces(frame, finger, elements)),
            })
            .collect(),
    }
}

fn element_forces(frame: &HandFrame, finger: usize, count: usize) -> Vec<Option<[f32; 3]>> {
    let forces = frame.force_n[finger].iter().take(count).enumerate();
    let is_valid = |element: usize| frame.valid_mask[finger] >> element & 1 == 1;
    forces
        .map(|(element, force_n)| is_valid(element).then(|| force_n.map(rounded)))
        .collect()
}

/// Rounds to 1e-4: below display resolution, and short as text.
fn rounded(value: f32) -> f32 {
    (value * 1e4).round() / 1e4
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unknown_values_are_omitted_and_nan_is_null() {
        let mut report = TickReport::default();
        report.hands[1].fingers[0].friction = f32::NAN;
        report.hands[1].fingers[0].normal_n = 1.234_56;
        report.hands[0].frame_age_ns = u64::MAX;
        let mut frame = HandFrame::default();
        frame.valid_mask[0] = 0b101;
        frame.force_n[0][2] = [0.5, -0.25, 1e-9];
        let picture = Picture::from_report(&report, [None, Some(&frame)], None, [2, 3], [41, 3]);
        let text = serde_json::to_string(&picture).expect("JSON");
        let check = |part: &str| assert!(text.contains(part), "{part} in {text}");
        check(r#""q":[]"#);
        check(r#""age_ms":null"#);
        check(r#""normal_n":1.2346"#);
        check(r#""friction":null"#);
        check(r#""elements":[[0.0,0.0,0.0],null,[0.5,-0.25,0.0]]"#);
        assert_eq!(
            text.matches(r#""elements":[]"#).count(),
            2,
            "no elements without a frame"
        );
        let fingers = picture.hands.each_ref().map(|hand| hand.fingers.len());
        assert_eq!(fingers, [2, 3], "all fingertips are included");
    }
}
