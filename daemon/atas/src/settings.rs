//! Table of all tunable parameters: name, default, allowed range, meaning.
//!
//! The table generates the structs, defaults, range checks, the example configuration and the
//! output of `atas param list`. Units are SI and end each name. Fixed constants are in
//! [`crate::limits`].

/// One tunable parameter.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Name, `section.key`.
    pub name: &'static str,
    /// Meaning, and the effect of values that are too small and too large.
    pub doc: &'static str,
    /// Default value.
    pub default: f64,
    /// Lowest allowed value.
    pub lower: f64,
    /// Highest allowed value.
    pub upper: f64,
    /// Reads the value.
    pub get: fn(&Settings) -> f64,
    /// Writes the value unchecked; use [`Settings::set`].
    pub(crate) set: fn(&mut Settings, f64),
}

/// Reason why a value was rejected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingError {
    /// No parameter has this name.
    Unknown,
    /// The value is not finite or out of range.
    OutOfRange {
        /// Parameter name.
        name: &'static str,
        /// Rejected value.
        value: f64,
        /// Lowest allowed value.
        lower: f64,
        /// Highest allowed value.
        upper: f64,
    },
    /// Two values contradict each other.
    Contradiction {
        /// Name and value of the parameter that must not be greater.
        lower: (&'static str, f64),
        /// Name and value of the parameter that must not be less.
        upper: (&'static str, f64),
    },
}

/// Pairs of parameters of which the first must not exceed the second: hysteresis thresholds,
/// bounds, and values on which a later threshold depends.
pub const ORDERED_PAIRS: &[(&str, &str)] = &[
    ("intake.hold_age_s", "intake.reject_age_s"),
    ("perception.touch_off_n", "perception.touch_on_n"),
    ("grasp.carry_min_n", "grasp.f1_min_n"),
    ("grasp.f1_min_n", "grasp.f1_max_n"),
    ("grasp.f2_min_n", "grasp.f2_max_n"),
    ("grasp.f2_max_n", "safety.grip_ceiling_n"),
    ("grasp.slip_off", "grasp.slip_on"),
    ("grasp.relax_below", "grasp.slip_on"),
];

/// Former and present names of renamed parameters. A configuration with a former name is rejected
/// with the present one; recordings made under the former names stay readable.
pub const RENAMED: &[(&str, &str)] = &[
    ("grasp.keep_n", "grasp.carry_min_n"),
    ("grasp.load_test_travel_m", "grasp.verification_travel_m"),
    ("grasp.load_test_press", "grasp.verification_press"),
    ("follow.move_m_s", "teleop.move_m_s"),
    ("follow.carry_m_s", "teleop.carry_m_s"),
    ("follow.turn_rad_s", "teleop.turn_rad_s"),
    ("follow.finger_m_s", "teleop.finger_m_s"),
    ("follow.speed_up_s", "teleop.speed_up_s"),
    ("follow.smooth_s", "teleop.smooth_s"),
    ("safety.disagree_n", "safety.force_mismatch_n"),
    ("safety.disagree_share", "safety.force_mismatch_share"),
];

impl core::fmt::Display for SettingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unknown => {
                f.write_str("unknown parameter; list all names with `atas param list`")
            }
            Self::OutOfRange {
                name,
                value,
                lower,
                upper,
            } => {
                write!(
                    f,
                    "{name} is {value}, needs a number from {lower} to {upper}"
                )
            }
            Self::Contradiction { lower, upper } => {
                write!(
                    f,
                    "{} is {}, needs at most {}, which is {}; change the other parameter first",
                    lower.0, lower.1, upper.0, upper.1
                )
            }
        }
    }
}

macro_rules! settings {
    ($($(#[doc = $sdoc:literal])* $section:ident: $Section:ident {
        $($(#[doc = $doc:literal])* $key:ident = $default:literal in $lower:literal..$upper:literal;)*
    })*) => {
        $(
            $(#[doc = $sdoc])*
            #[derive(Clone, Copy, Debug, PartialEq)]
            #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
            #[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
            pub struct $Section {
                $($(#[doc = $doc])* pub $key: f64,)*
            }

            impl Default for $Section {
                fn default() -> Self {
                    Self { $($key: $default,)* }
                }
            }
        )*

        /// All tunable parameters of the controller.
        #[derive(Clone, Copy, Debug, PartialEq, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
        pub struct Settings {
            $($(#[doc = $sdoc])* pub $section: $Section,)*
        }

        /// All tunable parameters, in the order of the configuration file.
        pub const PARAMETERS: &[Parameter] = &[
            $($(Parameter {
                name: concat!(stringify!($section), ".", stringify!($key)),
                doc: concat!($($doc),*),
                default: $default,
                lower: $lower,
                upper: $upper,
                get: |s| s.$section.$key,
                set: |s, value| s.$section.$key = value,
            },)*)*
        ];
    };
}

settings! {
    /// Validation of tactile frames and joint states (design choices, bounds from the fault
    /// catalogue).
    intake: Intake {
        /// Age of the newest frame or joint state above which the robot holds, s. Too small: holds
        /// on every scheduling hiccup. Too large: the grip acts on outdated data.
        hold_age_s = 0.005 in 0.001..0.5;
        /// Age above which a frame or joint state is rejected, s. Too small: rejects late but
        /// usable data. Too large: accepts outdated data.
        reject_age_s = 0.1 in 0.005..10.0;
        /// Largest accepted lead of a time stamp over the tick, s. Too small: rejects data of a
        /// slightly fast clock. Too large: accepts data with wrong time stamps.
        future_s = 0.001 in 0.0..0.1;
        /// Number of consecutive lost frames that are tolerated. Too small: holds on every short
        /// gap. Too large: filters and slip detection continue across long gaps.
        gap_frames = 5.0 in 0.0..1000.0;
        /// Number of consecutive identical frames that count as a frozen sensor; 0 disables the
        /// check. Too small: holds on a quiet sensor of coarse resolution. Too large: a frozen
        /// sensor is detected late.
        frozen_frames = 40.0 in 0.0..100000.0;
        /// Share of invalid elements in a fingertip above which the robot holds, 0 to 1. Too small:
        /// holds on a few broken elements. Too large: forces are estimated from too few elements.
        invalid_share = 0.1 in 0.0..1.0;
        /// Largest valid force of one element along one axis, N; an element above it is ignored.
        /// Too small: ignores real forces. Too large: uses faulty readings.
        element_force_n = 50.0 in 0.01..100000.0;
        /// Number of consecutive valid frames after which a restarted sensor is accepted. Too
        /// small: accepts a sensor that still starts up. Too large: holds longer than necessary.
        resync_frames = 20.0 in 1.0..1000.0;
    }
    /// Estimation of contact, force and motion from element forces (design choices from
    /// prototypes).
    perception: Perception {
        /// Time constant of the low-pass on every element, s. Too small: noisy forces. Too large:
        /// delayed forces, late slip reaction.
        filter_s = 0.005 in 0.0..1.0;
        /// Normal force above which contact begins, N. Too small: noise counts as contact. Too
        /// large: contact is detected late, after a harder impact.
        touch_on_n = 0.06 in 0.001..10000.0;
        /// Normal force below which contact ends, N. Too small: contact persists after release. Too
        /// large: contact toggles at light touch.
        touch_off_n = 0.03 in 0.0..10000.0;
        /// Largest rate at which the zero of an untouched fingertip follows its reading, N/s; 0
        /// keeps the zero. Too small: sensor drift counts as touch. Too large: hides a slow touch.
        zero_tracking_n_s = 0.1 in 0.0..1.0;
        /// Window W of the tangential force increment dF_t, s. Too small: misses slow load changes.
        /// Too large: reports load changes after they end.
        increment_window_s = 0.1 in 0.005..1.0;
        /// Averaging window of the contact motion estimate, s. Too small: noise counts as motion.
        /// Too large: a slip ends before it is detected.
        motion_window_s = 0.15 in 0.02..2.0;
        /// Threshold of the change between two windows that counts as motion, in multiples of the
        /// sensor noise; calibrate per sensor. Too small: noise counts as motion. Too large: slow
        /// slip is missed.
        motion_at = 2.5 in 1.0..1000.0;
        /// Weakest element in the friction estimate, N. Too small: noise on weak elements distorts
        /// the estimate. Too large: ignores the rim of the contact patch, where slip begins.
        element_floor_n = 0.012 in 0.001..1.0;
        /// Time constant of the friction utilisation, s. Too small: noise activates Module 2. Too
        /// large: late slip reaction.
        friction_filter_s = 0.02 in 0.001..1.0;
        /// Compression of one fingertip at 1 N, m; calibrate on a rigid block. 0 uses the skin
        /// model in the robot file. Too small: objects appear too soft. Too large: objects appear
        /// too stiff.
        tip_compression_m = 0.0 in 0.0..0.01;
        /// Exponent of that compression over force: 1 for a linear spring, 0.5 for a dome;
        /// calibrate both together. Ignored if the compression is 0. Too small or too large: wrong
        /// stiffness at forces other than 1 N.
        tip_exponent = 0.48 in 0.2..1.0;
    }
    /// Modules 1, 2 and 3: the grasp (paper II.b (1); values are design choices unless stated).
    grasp: Grasp {
        /// Closing speed of each side during the approach, m/s (paper: 2 mm/s). Too small: slow
        /// grasp. Too large: hard impact at first contact.
        approach_m_s = 0.002 in 0.0001..0.02;
        /// Duration of the stiffness probe, s (paper: 100 ms). Too small: noisy stiffness estimate.
        /// Too large: compresses the object further before F_2 is known.
        probe_s = 0.1 in 0.02..1.0;
        /// Closing speed of each side while Module 2 is active, m/s. Too small: grip force grows
        /// slower than the slip. Too large: excess grip force.
        enhance_m_s = 0.002 in 0.0001..0.02;
        /// Compression of the object at F_2, m: F_2 = compression × stiffness. Too small: refuses
        /// objects that need more force. Too large: deforms soft objects.
        compression_m = 0.0005 in 0.00001..0.01;
        /// Lower bound of F_2, N. Too small: soft objects cannot be held. Too large: crushes soft
        /// objects.
        f2_min_n = 0.7 in 0.05..100.0;
        /// Upper bound of F_2, N: largest intended grip force of the hand. Too small: refuses heavy
        /// objects. Too large: may damage objects or fingers.
        f2_max_n = 8.0 in 0.1..100.0;
        /// Factor of F_2 in F_1 = share · F_2 + base. Too small: loose grip before the lift. Too
        /// large: grip harder than necessary.
        f1_share = 0.1 in 0.0..1.0;
        /// Constant part of F_1, N. Too small: loose grip on soft objects. Too large: grip harder
        /// than necessary.
        f1_base_n = 0.2 in 0.0..10.0;
        /// Lower bound of F_1, N. Too small: contact is too weak for slip detection. Too large:
        /// deforms soft objects.
        f1_min_n = 0.35 in 0.01..10.0;
        /// Upper bound of F_1, N. Too small: loose grip on stiff objects. Too large: grip harder
        /// than necessary.
        f1_max_n = 1.0 in 0.05..50.0;
        /// Minimum grip force on a carried object, N; grip relaxation stops there. Too small: the
        /// fingertips no longer sense the object. Too large: light objects are gripped harder than
        /// necessary.
        carry_min_n = 0.12 in 0.01..10.0;
        /// Off-centre distance of the object in the grip above which the hand opens and regrasps,
        /// m. Too small: regrasps because of measurement errors. Too large: keeps off-centre grips;
        /// the upper bound disables regrasping.
        regrasp_m = 0.003 in 0.0005..0.02;
        /// Yaw error of the object's faces against the closing axis above which the hand regrasps,
        /// rad. Too small: regrasps because of measurement errors. Too large: keeps misaligned
        /// grips; the upper bound disables regrasping.
        regrasp_rad = 0.1 in 0.02..1.0;
        /// Lever of the weight about the grip above which a hand that fails to lift regrasps nearer
        /// to the centre of mass, m. Too small: needless regrasps. Too large: the object tilts; the
        /// upper bound disables it.
        regrasp_lever_m = 0.001 in 0.0002..0.05;
        /// Threshold dr of the tangential force increment dF_t, N (named in the paper without a
        /// value). Too small: noise activates Module 2. Too large: reacts late to growing load.
        dr_n = 0.06 in 0.005..10.0;
        /// Friction utilisation S above which Module 2 activates. Too small: grips harder than
        /// necessary. Too large: reacts after slip has begun.
        slip_on = 0.92 in 0.2..1.0;
        /// Friction utilisation S below which Module 2 deactivates. Too small: stays active and
        /// over-grips. Too large: switches on and off.
        slip_off = 0.86 in 0.1..1.0;
        /// Momentary friction utilisation that counts as gross slip. Too small: partial slip counts
        /// as gross slip. Too large: gross slip is missed.
        slip_gross = 0.955 in 0.5..1.2;
        /// Duration for which gross slip must last, s. Too small: reacts to noise. Too large: the
        /// object slides further before the reaction.
        slip_gross_s = 0.01 in 0.0..1.0;
        /// Friction utilisation above which a growing load (dF_t > dr) activates Module 2. Too
        /// small: every load change increases the grip. Too large: growing load has no effect
        /// before slip.
        slip_loading = 0.8 in 0.1..1.2;
        /// Minimum time for which Module 2 stays active after its last trigger, s. Too small: the
        /// object slips between triggers. Too large: over-grips.
        slip_latch_s = 0.02 in 0.0..1.0;
        /// Factor on the hand's speed while Module 2 is active and Module 3 is not. Too small: the
        /// hand almost stops on every reaction. Too large: the load grows faster than the grip.
        slip_carry_scale = 0.1 in 0.0..1.0;
        /// Friction utilisation below which a steady grip relaxes. Too small: keeps excess grip
        /// force. Too large: relaxes to the edge of slip.
        relax_below = 0.91 in 0.1..1.0;
        /// Opening speed of each side while an excessive grip relaxes, m/s. Too small: keeps excess
        /// grip force for long. Too large: relaxes into slip.
        relax_m_s = 0.001 in 0.0..0.02;
        /// Opening speed of Module 3 above its release force, m/s. Too small: relieves excess force
        /// slowly. Too large: overshoots and loosens the grip.
        relieve_m_s = 0.002 in 0.0..0.02;
        /// Multiple of F_2 above which Module 3 opens. Too small: opens on force noise. Too large:
        /// the object is pressed well above F_2.
        relieve_at = 1.02 in 1.0..2.0;
        /// Lift distance before the pull-back of lift verification, m; half of it after a failed
        /// attempt. Too small: the load is not yet on the hand. Too large: a slipping object is
        /// detected late.
        verification_travel_m = 0.002 in 0.0008..0.1;
        /// Factor by which the grip force increases after an attempt without a suspended object.
        /// Too small: many attempts. Too large: over-grips.
        verification_press = 1.2 in 1.01..3.0;
        /// Momentary friction utilisation at F_2 above which the object counts as too heavy. Too
        /// small: refuses objects that hold. Too large: objects that slide out are not refused.
        too_heavy_gross = 0.975 in 0.5..1.2;
        /// Duration for which that must last, s. Too small: refuses on short disturbances. Too
        /// large: the object slides further before the refusal.
        too_heavy_s = 0.4 in 0.05..5.0;
    }
    /// Modules 0' and 4: placing (paper II.b (3); design choices from prototypes).
    place: Place {
        /// Mean transport speed, m/s. Too small: slow transport. Too large: inertia adds load on
        /// the grip.
        convey_m_s = 0.05 in 0.005..0.3;
        /// Speed of setting down, m/s. Too small: slow placing. Too large: the object hits its
        /// support before Module 4 reacts.
        lower_m_s = 0.01 in 0.001..0.05;
        /// Search depth for the support below its expected height, m. Too small: fails if the
        /// support is lower. Too large: pushes further down if Module 4 misses the support.
        search_m = 0.015 in 0.0..0.05;
        /// Time from the start of the descent during which Module 4 is inactive, s, so that the
        /// load settles. Too small: the start of motion counts as support. Too large: misses an
        /// early support.
        settle_s = 0.15 in 0.0..2.0;
        /// Rise of the vertical force that counts as support, N. Too small: releases in the air.
        /// Too large: presses the object onto its support.
        rise_n = 0.12 in 0.02..10.0;
        /// Rise as a share of the held weight that counts as support; the larger of both applies.
        /// Too small: releases heavy objects in the air. Too large: presses heavy objects onto
        /// their support.
        rise_share = 0.06 in 0.0..1.0;
        /// Sensor time for which the rise must last, s; at least two frames. Too small: releases on
        /// a noise peak. Too large: presses the object onto its support.
        rise_s = 0.0025 in 0.0..0.1;
    }
    /// Modules 0 and 4: screwing (paper II.b (2); design choices from prototypes unless stated).
    screw: Screw {
        /// Half of the long side of the square trajectory, m. Too small: many strokes per turn. Too
        /// large: the fingertips leave the contour of a small cap.
        travel_m = 0.007 in 0.001..0.012;
        /// Short side of the square trajectory, m: outward travel of each side before the return.
        /// Too small: the fingertips drag the cap back. Too large: slow strokes.
        clearance_m = 0.003 in 0.001..0.02;
        /// Inward speed, m/s. Too small: slow strokes. Too large: hard impact on the cap.
        in_m_s = 0.01 in 0.001..0.05;
        /// Turning speed, m/s. Too small: slow screwing. Too large: the grip follows the contour
        /// too late.
        turn_m_s = 0.008 in 0.001..0.05;
        /// Outward speed, m/s. Too small: slow strokes. Too large: jerks at the release.
        out_m_s = 0.02 in 0.001..0.05;
        /// Return speed, m/s. Too small: slow strokes. Too large: high accelerations.
        return_m_s = 0.03 in 0.001..0.1;
        /// Time for which the weaker side must exceed F_1 before a turn begins, s. Too small: turns
        /// with a loose grip. Too large: slow strokes.
        grip_s = 0.02 in 0.0..1.0;
        /// Centring speed of the hand on the cap per force difference between the sides, m/s per N.
        /// Too small: stays off-centre. Too large: oscillates.
        centring_m_s_n = 0.0005 in 0.0..0.01;
        /// Multiple of dF_max at which Module 4 ends the screwing (paper: 1.4). Too small: stops
        /// before the cap is tight. Too large: over-tightens or slips on.
        finish_ratio = 1.4 in 1.05..5.0;
        /// Time constant of Module 4's torque, s. Too small: ends on noise. Too large:
        /// detects a tight cap late.
        finish_filter_s = 0.004 in 0.0..0.5;
    }
    /// Speeds and distances of hand motion (design choices).
    motion: Motion {
        /// Mean speed of free motion, m/s. Too small: slow tasks. Too large: tracking errors and
        /// hard collisions.
        reach_m_s = 0.12 in 0.01..0.5;
        /// Mean rotation speed of free motion, rad/s. Too small: slow tasks. Too large: tracking
        /// errors.
        turn_rad_s = 0.8 in 0.05..3.0;
        /// Mean lifting speed, m/s. Too small: slow lift. Too large: the load grows faster than
        /// Module 2 can increase the grip.
        lift_m_s = 0.01 in 0.001..0.1;
        /// Gap between fingertip and expected surface at the start of the approach, m, per side.
        /// Too small: collides with a displaced object during the descent. Too large: slow
        /// approach.
        clearance_m = 0.005 in 0.001..0.03;
        /// Opening speed at release, m/s, per side. Too small: slow release. Too large: pushes a
        /// sticking object over.
        open_m_s = 0.03 in 0.001..0.07;
        /// Height above the grasp from which the hand descends, m. Too small: collides with the
        /// object on the way. Too large: detours.
        descend_m = 0.06 in 0.0..0.2;
        /// Closing depth beyond the expected surface at which the approach fails, m, per side. Too
        /// small: fails on objects narrower than expected. Too large: closes far on an absent
        /// object.
        search_m = 0.012 in 0.001..0.03;
    }
    /// Teleoperation: limits on following a client's stream of targets (design choices). Maximum
    /// acceleration is speed / `speed_up_s`, maximum jerk about twice that / `smooth_s`.
    teleop: Teleop {
        /// Highest speed along each axis with an empty hand, m/s. Too small: the hand lags behind
        /// its targets. Too large: hard collisions.
        move_m_s = 0.15 in 0.005..0.5;
        /// Highest speed along each axis with an object in the hand, m/s. Too small: the hand lags
        /// behind its targets. Too large: inertia makes the object slip.
        carry_m_s = 0.06 in 0.001..0.5;
        /// Highest rotation speed, rad/s. Too small: the hand lags behind its targets. Too large:
        /// tracking errors, and objects slip.
        turn_rad_s = 0.8 in 0.05..3.0;
        /// Highest speed of each side towards a commanded width, m/s. Too small: slow opening and
        /// closing. Too large: presses before contact detection stops it.
        finger_m_s = 0.02 in 0.001..0.07;
        /// Acceleration time from rest to the highest speed, s. Too small: jerky motion. Too large:
        /// sluggish motion.
        speed_up_s = 0.25 in 0.02..2.0;
        /// Time constant of the low-pass that limits the jerk, s. Too small: jerky motion. Too
        /// large: lag behind the targets.
        smooth_s = 0.04 in 0.005..0.5;
    }
    /// Limits of the safety gate (design choices, bounds from the fault catalogue).
    safety: Safety {
        /// Grip ceiling: normal force of one side above which it may only open, N. Too small:
        /// prevents firm grips. Too large: may damage objects or fingers.
        grip_ceiling_n = 15.0 in 0.1..500.0;
        /// Multiple of F_2 above which a side may only open. Too small: blocks normal force control
        /// at F_2. Too large: does not protect the object.
        grip_ceiling_f2 = 1.5 in 1.0..5.0;
        /// Following error that is always allowed, rad. Too small: stops on normal servo offset
        /// under load. Too large: a blocked joint is detected late.
        following_floor_rad = 0.08 in 0.001..1.0;
        /// Additional following error per joint speed, s. Too small: stops during fast motion. Too
        /// large: a blocked joint is detected late.
        following_per_speed_s = 0.03 in 0.0..1.0;
        /// Constant part of the tolerated difference between tactile and joint-estimated force, N;
        /// beyond the tolerance the hand holds. Too small: holds on inaccurate servo torques. Too
        /// large: misses a faulty skin.
        force_mismatch_n = 0.3 in 0.01..10000.0;
        /// Force-proportional part of that tolerance. Too small: holds at high forces. Too large: a
        /// faulty skin is not detected at high forces.
        force_mismatch_share = 0.3 in 0.01..10000.0;
        /// Time for which the following error must exceed its limit before SAFE_STOP, s. Too small:
        /// stops on short disturbances. Too large: builds up force against an obstacle.
        following_s = 0.01 in 0.001..1.0;
        /// Validity of a command, s; at least 1.5 tick periods. Too small: a late tick stops the
        /// robot. Too large: the robot stops later after a crash of the daemon.
        valid_s = 0.005 in 0.001..0.1;
        /// Time in HOLD after which a paused goal fails, s. Too small: short faults end goals. Too
        /// large: clients wait long for a failed goal.
        pause_s = 0.5 in 0.0..60.0;
        /// Time without a tick after which the robot holds first, s. Too small: holds on every
        /// hiccup of a shared computer (8 ms measured). Too large: continues although the scene may
        /// have changed.
        stall_s = 0.02 in 0.003..1.0;
    }
}

impl Settings {
    /// Sets one parameter by name; leaves all unchanged on error.
    ///
    /// # Errors
    /// [`SettingError`] if the name is unknown, the value is out of range, or it contradicts
    /// another parameter.
    ///
    /// ```
    /// use atas_core::Settings;
    ///
    /// let mut settings = Settings::default();
    /// assert!(settings.set("grasp.dr_n", 0.08).is_ok());
    /// assert_eq!(settings.grasp.dr_n, 0.08);
    /// assert!(settings.set("grasp.dr_n", 99.0).is_err(), "out of range");
    /// assert!(settings.set("grasp.dr", 0.08).is_err(), "unknown name");
    /// ```
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), SettingError> {
        let parameter = find(name).ok_or(SettingError::Unknown)?;
        parameter.check(value)?;
        let mut changed = *self;
        (parameter.set)(&mut changed, value);
        changed.check_order()?;
        *self = changed;
        Ok(())
    }

    /// Checks all ranges and the relations in [`ORDERED_PAIRS`].
    ///
    /// # Errors
    /// The first [`SettingError`] found.
    pub fn check(&self) -> Result<(), SettingError> {
        PARAMETERS.iter().try_for_each(|p| p.check((p.get)(self)))?;
        self.check_order()
    }

    fn check_order(&self) -> Result<(), SettingError> {
        for (lower, upper) in ORDERED_PAIRS {
            let (lower, upper) = (self.named(lower)?, self.named(upper)?);
            if lower.1 > upper.1 {
                return Err(SettingError::Contradiction { lower, upper });
            }
        }
        Ok(())
    }

    fn named(&self, name: &str) -> Result<(&'static str, f64), SettingError> {
        let parameter = find(name).ok_or(SettingError::Unknown)?;
        Ok((parameter.name, (parameter.get)(self)))
    }
}

/// Returns the present name of a renamed parameter or section.
#[must_use]
pub fn present_name(former: &str) -> Option<&'static str> {
    let section = |name: &'static str| name.split_once('.').map_or(name, |(section, _)| section);
    RENAMED.iter().find_map(|&(old, new)| {
        let moved = section(old) == former && section(new) != former;
        (old == former)
            .then_some(new)
            .or_else(|| moved.then(|| section(new)))
    })
}

/// Returns the name that a parameter had before it was renamed, or its name.
pub(crate) fn former_name(name: &'static str) -> &'static str {
    let renamed = RENAMED.iter().find(|(_, new)| *new == name);
    renamed.map_or(name, |(old, _)| *old)
}

/// Returns the parameter with this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|p| p.name == name)
}

impl Parameter {
    /// Returns whether the parameter is a safety limit, which must not change while the robot may
    /// move.
    #[must_use]
    pub fn is_safety(&self) -> bool {
        self.name.starts_with("safety.")
    }

    /// Checks a value for this parameter.
    ///
    /// # Errors
    /// [`SettingError::OutOfRange`].
    pub fn check(&self, value: f64) -> Result<(), SettingError> {
        // NaN fails both comparisons and is rejected.
        if value >= self.lower && value <= self.upper {
            return Ok(());
        }
        Err(SettingError::OutOfRange {
            name: self.name,
            value,
            lower: self.lower,
            upper: self.upper,
        })
    }
}
