//! Combined percept of one grasp side (the literature's virtual finger).
//!
//! Forces are summed, friction quantities averaged by normal force. The side slips when all its
//! touching fingertips slip, and is in contact when one of them is. Other quantities come from the
//! fingertip with the largest force. A single fingertip is returned unchanged.

use super::fingertip::ContactPercept;

/// Combines the fingertips of one side.
pub(super) fn combine<'a>(
    fingers: impl Iterator<Item = &'a ContactPercept> + Clone,
) -> ContactPercept {
    let Some(strongest) = strongest(fingers.clone()) else {
        return ContactPercept::default();
    };
    if fingers.clone().count() == 1 {
        return *strongest;
    }
    let sum = |of: fn(&ContactPercept) -> f64| fingers.clone().map(of).sum::<f64>();
    let pressing = |finger: &&ContactPercept| finger.in_contact && finger.normal_n > 0.0;
    let pressing = fingers.clone().filter(pressing);
    let pressed_n: f64 = pressing.clone().map(|finger| finger.normal_n).sum();
    let shared = |of: fn(&ContactPercept) -> f64| {
        let weighted: f64 = pressing.clone().map(|it| it.normal_n * of(it)).sum();
        if pressed_n > 0.0 {
            weighted / pressed_n
        } else {
            of(strongest)
        }
    };
    let least = |of: fn(&ContactPercept) -> f64| {
        let values = pressing.clone().map(of);
        values.reduce(|least, value| if value < least { value } else { least })
    };
    ContactPercept {
        normal_n: sum(|finger| finger.normal_n),
        tangential_n: sum(|finger| finger.tangential_n),
        increment_n: sum(|finger| finger.increment_n),
        utilisation: shared(|finger| finger.utilisation),
        utilisation_now: shared(|finger| finger.utilisation_now),
        friction: shared(|finger| finger.friction),
        loaded_share: shared(|finger| finger.loaded_share),
        masked_share: shared(|finger| finger.masked_share),
        loaded_fingertips: loaded_fingertips(fingers.clone()),
        moment_n_m: sum(|finger| finger.moment_n_m),
        gross_slip_s: least(|finger| finger.gross_slip_s).unwrap_or(0.0),
        in_contact: fingers.clone().any(|finger| finger.in_contact),
        touches: fingers.map(|finger| finger.touches).max().unwrap_or(0),
        ..*strongest
    }
}

/// Returns the effective number of pressing fingertips: n for equal forces, 1 for one or none.
fn loaded_fingertips<'a>(fingers: impl Iterator<Item = &'a ContactPercept>) -> f64 {
    let (mut sum_n, mut squares_n2) = (0.0, 0.0);
    for finger in fingers {
        let normal_n = if finger.normal_n > 0.0 {
            finger.normal_n
        } else {
            0.0
        };
        sum_n += normal_n;
        squares_n2 += normal_n * normal_n;
    }
    if squares_n2 > 0.0 {
        sum_n * sum_n / squares_n2
    } else {
        1.0
    }
}

fn strongest<'a>(fingers: impl Iterator<Item = &'a ContactPercept>) -> Option<&'a ContactPercept> {
    fingers.reduce(|most, finger| {
        if finger.normal_n > most.normal_n {
            finger
        } else {
            most
        }
    })
}
