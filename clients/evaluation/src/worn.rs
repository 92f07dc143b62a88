//! Fingertips that are felt through something: another skin, another calibration.

use atas_core::Settings;
use shm_schemas::HandFrame;

/// What a trial is run with in place of what its plan has.
pub struct Worn {
    /// The controller's settings.
    pub settings: Settings,
    /// What changes every frame on its way from the fingertips to the controller; it must seal it again.
    pub skin: Box<dyn FnMut(&mut HandFrame)>,
}

impl Worn {
    /// Nothing: the frames as they are.
    pub(crate) fn bare(settings: Settings) -> Self {
        Self {
            settings,
            skin: Box::new(|_| {}),
        }
    }
}
