//! Sensor variant of a trial: changed tactile frames and settings.

use atas_core::Settings;
use shm_schemas::HandFrame;

/// Settings and frame filter that replace those of the plan.
pub struct Worn {
    /// Controller settings.
    pub settings: Settings,
    /// Modifies each tactile frame between fingertips and controller; must re-seal the frame.
    pub skin: Box<dyn FnMut(&mut HandFrame)>,
}

impl Worn {
    pub(crate) fn bare(settings: Settings) -> Self {
        Self {
            settings,
            skin: Box::new(|_| {}),
        }
    }
}
