//! Feeds recorded readings of fingertips to the production intake and perception.

use atas_core::intake::FrameIntake;
use atas_core::perception::{Percept, Perception};
use atas_core::settings::Settings;
use atas_core::{HandSensorSetup, Tick};
use robot_model::{HandModel, HandSide};
use shm_schemas::capacity::{ELEMENTS, FINGERS};
use shm_schemas::{Hand, HandFrame, Layout, Stamp};

/// Time of the first frame, ns; any value above 0.
const BEGIN_NS: u64 = 1_000_000_000;
/// Writer epoch of the recorded sensor.
const EPOCH: u64 = 1;
/// Largest accepted frame rate of a recording, Hz: limit of the intake.
pub(super) const RATE_MAX_HZ: f64 = 10_000.0;

pub(super) struct Skin {
    intake: FrameIntake,
    perception: Perception,
    settings: Settings,
    frame: HandFrame,
    elements: usize,
    sequence: u64,
    now_ns: u64,
}

/// Reading of one fingertip: `[f_n, f_t1, f_t2]` per element, N; `None` where the recording has no
/// value.
pub(super) type Reading = Vec<Option<[f64; 3]>>;

impl Skin {
    pub(super) fn new(fingers: usize, elements: usize, rate_hz: f64, settings: Settings) -> Self {
        let elements = elements.clamp(1, ELEMENTS);
        let name = if elements == 1 {
            "dome-1".to_owned()
        } else {
            format!("pad-{elements}")
        };
        let layout = Layout::from_name(&name).unwrap_or_else(Layout::dome_41);
        let wiring = HandSensorSetup {
            layout,
            fingers: fingers.clamp(1, FINGERS),
            required: false,
            rate_hz,
        };
        let frame = HandFrame {
            layout_hash: wiring.layout.hash(),
            hand: Hand::LEFT,
            finger_count: wiring.fingers as u32,
            ..HandFrame::default()
        };
        Self {
            intake: FrameIntake::new(Hand::LEFT, &wiring),
            perception: Perception::new(&wiring, &HandModel::absent(HandSide::Left)),
            settings,
            frame,
            elements,
            sequence: 0,
            now_ns: BEGIN_NS,
        }
    }

    pub(super) fn process(&mut self, step_s: f64, fingers: &[Reading]) -> &Percept {
        // Time stamps must increase; gaps are shortened to 1 s.
        let step_ns = (step_s.clamp(1.0 / RATE_MAX_HZ, 1.0) * 1e9) as u64;
        self.now_ns += step_ns;
        self.frame.stamp = Stamp {
            sequence: self.sequence,
            captured_ns: self.now_ns,
            writer_epoch: EPOCH,
        };
        self.sequence += 1;
        for (finger, reading) in fingers.iter().enumerate().take(FINGERS) {
            self.write(finger, reading);
        }
        self.frame.seal();
        let tick = Tick {
            index: self.sequence,
            now_ns: self.now_ns,
        };
        self.intake.begin();
        self.perception.begin();
        if let Some(checked) = self
            .intake
            .validate(&self.frame, tick, &self.settings.intake)
        {
            self.perception.update(&checked, false, &self.settings);
        }
        self.perception.percept()
    }

    pub(super) fn bias(&mut self) {
        self.perception.bias();
    }

    fn write(&mut self, finger: usize, reading: &Reading) {
        let mut mask = 0;
        for element in 0..self.elements {
            let force_n = reading.get(element).copied().flatten();
            if let Some(force_n) = force_n {
                self.frame.force_n[finger][element] = force_n.map(|axis| axis as f32);
                mask |= 1 << element;
            }
        }
        self.frame.valid_mask[finger] = mask;
    }
}
