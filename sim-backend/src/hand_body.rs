//! True dimensions, servos and skins of a hand: the model with the deviations that a seed draws.

use robot_model::{HandModel, HandVector};

use crate::pad::{MissingElementPositions, Pad};
use crate::random::Random;
use crate::scene::{Errors, stream};

/// Hand as it is, not as the controller models it.
#[derive(Clone, Debug)]
pub(crate) struct HandBody {
    pub(crate) model: HandModel,
    /// True servo stiffness over that of the model, per joint.
    pub(crate) servo_factor: HandVector,
    /// Skin of each fingertip.
    pub(crate) pads: Vec<Pad>,
}

impl HandBody {
    /// Draws the deviations from the model within `errors`.
    ///
    /// # Errors
    /// The skin has no element positions.
    pub(crate) fn draw(
        model: &HandModel,
        errors: &Errors,
        seed: u64,
    ) -> Result<Self, MissingElementPositions> {
        let side = model.side().index() as u64;
        let mut random = Random::new(seed, stream::HAND_ERRORS + side);
        let mut draw = || random.between(-1.0, 1.0);
        let (joints, fingers) = (model.joints().len(), model.fingertip_count());
        let servo_factor = HandVector::from_fn(joints, |_| 1.0 + errors.servo_stiffness * draw());
        let mut drawn_m =
            |count| -> Vec<f64> { (0..count).map(|_| errors.link_m * draw()).collect() };
        let (links_m, tips_m) = (drawn_m(model.frame_count()), drawn_m(fingers));
        let layout = model.skin().layout;
        let pads = model
            .tip_radius_m()
            .iter()
            .map(|radius_m| {
                let pad = Pad::from_layout(layout, *radius_m)?;
                Ok(pad.with_stiffness_factor(1.0 + errors.tip_stiffness * draw()))
            })
            .collect::<Result<_, MissingElementPositions>>()?;
        Ok(Self {
            model: model.with_longer_links(&links_m, &tips_m),
            servo_factor,
            pads,
        })
    }
}
