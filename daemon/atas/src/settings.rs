//! Every number that a user may tune, in one table: name, default, allowed range, meaning.
//!
//! The same table makes the structs, their defaults, the range checks and the list that `atas param list` shows.
//! SI units, stated last in each name. Numbers that a user must not tune are in [`crate::limits`].

/// One tunable number.
#[derive(Clone, Copy)]
pub struct Parameter {
    /// Name, `section.key`.
    pub name: &'static str,
    /// Meaning.
    pub doc: &'static str,
    /// Value if nothing is configured.
    pub default: f64,
    /// Lowest value allowed.
    pub lower: f64,
    /// Highest value allowed.
    pub upper: f64,
    /// Reads the value.
    pub get: fn(&Settings) -> f64,
    /// Writes the value without checking it; use [`Settings::set`].
    pub(crate) set: fn(&mut Settings, f64),
}

/// Why a value was refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SettingError {
    /// No parameter has this name.
    Unknown,
    /// The value is not a finite number within the range.
    OutOfRange {
        /// The parameter.
        name: &'static str,
        /// The value.
        value: f64,
        /// Lowest value allowed.
        lower: f64,
        /// Highest value allowed.
        upper: f64,
    },
    /// Two values contradict each other.
    Contradiction {
        /// The parameter that must not be greater, and its value.
        lower: (&'static str, f64),
        /// The parameter that must not be less, and its value.
        upper: (&'static str, f64),
    },
}

/// Parameters of which the first must not be greater than the second: thresholds with hysteresis, bounds, and what a later
/// threshold takes for granted.
pub const ORDERED: &[(&str, &str)] = &[
    ("intake.hold_age_s", "intake.reject_age_s"),
    ("perception.touch_off_n", "perception.touch_on_n"),
    ("grasp.keep_n", "grasp.f1_min_n"),
    ("grasp.f1_min_n", "grasp.f1_max_n"),
    ("grasp.f2_min_n", "grasp.f2_max_n"),
    ("grasp.f2_max_n", "safety.grip_ceiling_n"),
    ("grasp.slip_off", "grasp.slip_on"),
    ("grasp.relax_below", "grasp.slip_on"),
];

impl core::fmt::Display for SettingError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Unknown => {
                f.write_str("no parameter has this name; `atas param list` shows them all")
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
                    "{} is {} and {} is {}, needs the first to be at most the second; change the other one first",
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

        /// Every tunable number of the controller.
        #[derive(Clone, Copy, Debug, PartialEq, Default)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
        pub struct Settings {
            $($(#[doc = $sdoc])* pub $section: $Section,)*
        }

        /// Every tunable number, in the order of the configuration file.
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
    /// Which frames and joint states are believed (ours, bounds from the fault catalogue).
    intake: Intake {
        /// Age of the newest frame or joint state above which the robot holds, s. Too small: holds on every scheduling hiccup. Too large: grips blindly.
        hold_age_s = 0.005 in 0.001..0.5;
        /// Age above which a frame is refused outright, s.
        reject_age_s = 0.1 in 0.005..10.0;
        /// How far ahead of the tick a stamp may lie, s.
        future_s = 0.001 in 0.0..0.1;
        /// Lost frames in a row that are tolerated.
        gap_frames = 5.0 in 0.0..1000.0;
        /// Identical frames in a row after which the sensor counts as frozen; 0 switches the check off.
        frozen_frames = 40.0 in 0.0..100000.0;
        /// Share of invalid elements above which the robot holds.
        invalid_share = 0.1 in 0.0..1.0;
        /// Largest believable force of one element along one axis, N.
        element_force_n = 50.0 in 0.01..100000.0;
        /// Good frames in a row after which a restarted sensor is believed again.
        resync_frames = 20.0 in 1.0..1000.0;
    }
    /// From element forces to what a fingertip feels (tactile design: ours, from prototypes).
    perception: Perception {
        /// Time constant of the low-pass on every element, s.
        filter_s = 0.005 in 0.0..1.0;
        /// Normal force that counts as a touch, N.
        touch_on_n = 0.06 in 0.001..10000.0;
        /// Normal force below which a touch has ended, N.
        touch_off_n = 0.03 in 0.0..10000.0;
        /// Window W of the tangential force increment dF_t, s.
        increment_window_s = 0.1 in 0.005..1.0;
        /// Window over which the readings are averaged before their motion is told, s. Too small: noise. Too large: a slip is over before it is noticed.
        motion_window_s = 0.15 in 0.02..2.0;
        /// Motion between two windows that counts as motion, in multiples of the sensor's own noise: a calibration.
        motion_at = 2.5 in 1.0..1000.0;
        /// Weakest element that takes part in the friction estimate, N.
        element_floor_n = 0.012 in 0.001..1.0;
        /// Time constant of the friction reading, s.
        friction_filter_s = 0.02 in 0.001..1.0;
        /// Compression of one fingertip at 1 N, m: a calibration, pressed on a rigid block. 0: what the robot file says of the skin.
        tip_compression_m = 0.0 in 0.0..0.01;
        /// Exponent of that compression over force: a calibration, 1 for a linear spring, 0.5 for a dome. Without meaning where it is 0.
        tip_exponent = 0.48 in 0.2..1.0;
    }
    /// Modules 1, 2 and 3: the grasp (paper II.b (1); values ours unless stated).
    grasp: Grasp {
        /// Closing speed of each finger on approach, m/s (paper: 2 mm/s).
        approach_m_s = 0.002 in 0.0001..0.02;
        /// Duration of the stiffness probe, s (paper: 100 ms).
        probe_s = 0.1 in 0.02..1.0;
        /// Closing speed of each finger while Module 2 is active, m/s.
        enhance_m_s = 0.002 in 0.0001..0.02;
        /// Compression of the object that F_2 allows, m.
        compression_m = 0.0005 in 0.00001..0.01;
        /// Lower bound of F_2, N.
        f2_min_n = 0.7 in 0.05..100.0;
        /// Upper bound of F_2, N: what the fingers may ever press.
        f2_max_n = 8.0 in 0.1..100.0;
        /// Share of F_2 in F_1.
        f1_share = 0.1 in 0.0..1.0;
        /// Constant part of F_1, N.
        f1_base_n = 0.2 in 0.0..10.0;
        /// Lower bound of F_1, N.
        f1_min_n = 0.35 in 0.01..10.0;
        /// Upper bound of F_1, N.
        f1_max_n = 1.0 in 0.05..50.0;
        /// Least force that a carried object is gripped with, N: what the fingertips need to feel it.
        keep_n = 0.12 in 0.01..10.0;
        /// How far from the middle of the grip an object may be felt to stand before the hand opens and grasps it anew there, m. Upper bound: never.
        regrasp_m = 0.003 in 0.0005..0.02;
        /// How far an object's faces may be felt to be turned against the closing axis before it does, rad. Upper bound: never.
        regrasp_rad = 0.1 in 0.02..1.0;
        /// Lever of an object's weight about the grip from which on a hand that cannot lift it so grasps it anew nearer to its centre of mass, m. Upper bound: never.
        regrasp_lever_m = 0.001 in 0.0002..0.05;
        /// Threshold dr of the tangential force increment, N (the paper names it and gives no value).
        dr_n = 0.06 in 0.005..10.0;
        /// Friction utilisation S at which Module 2 becomes active.
        slip_on = 0.92 in 0.2..1.0;
        /// Friction utilisation S at which it becomes inactive.
        slip_off = 0.86 in 0.1..1.0;
        /// Momentary utilisation that means gross slip.
        slip_gross = 0.955 in 0.5..1.2;
        /// How long gross slip must last, s.
        slip_gross_s = 0.01 in 0.0..1.0;
        /// Utilisation above which a growing load (dF_t > dr) activates Module 2.
        slip_loading = 0.8 in 0.1..1.2;
        /// How long Module 2 stays active after its last cause, s.
        slip_latch_s = 0.02 in 0.0..1.0;
        /// Factor on the hand's speed while Module 2 is active and Module 3 is not.
        slip_carry_scale = 0.1 in 0.0..1.0;
        /// Friction utilisation below which a steady grip is relaxed.
        relax_below = 0.91 in 0.1..1.0;
        /// Opening speed of each finger while relaxing an unloaded grip, m/s.
        relax_m_s = 0.001 in 0.0..0.02;
        /// Opening speed of Module 3 above its release force, m/s.
        relieve_m_s = 0.001 in 0.0..0.02;
        /// Multiple of F_2 above which Module 3 opens.
        relieve_at = 1.15 in 1.0..2.0;
        /// Travel of a lift after which the hand tugs back to see whether the object hangs, m; half of it before it tries again.
        load_test_travel_m = 0.002 in 0.0008..0.1;
        /// Multiple of its force to which the hand presses an object that still stands.
        load_test_press = 1.2 in 1.01..3.0;
        /// Momentary utilisation that means sliding out of the hand at F_2.
        too_heavy_gross = 0.975 in 0.5..1.2;
        /// How long it must last, s.
        too_heavy_s = 0.4 in 0.05..5.0;
    }
    /// Modules 0' and 4: placing (paper II.b (3); values ours, from prototypes).
    place: Place {
        /// Mean speed of conveying, m/s.
        convey_m_s = 0.05 in 0.005..0.3;
        /// Speed of setting down, m/s. Too fast: the object hits its support before Module 4 answers.
        lower_m_s = 0.01 in 0.001..0.05;
        /// How far below its expected height the support may lie, m.
        search_m = 0.015 in 0.0..0.05;
        /// Time from the start of the descent in which the load settles and Module 4 does not listen, s.
        settle_s = 0.15 in 0.0..2.0;
        /// Rise of the vertical force that means support, N. Too small: lets go in the air.
        rise_n = 0.12 in 0.02..10.0;
        /// The same as a share of the held weight, if that is more.
        rise_share = 0.06 in 0.0..1.0;
        /// Sensor time for which the rise must last, s; one frame of a sensor slower than that.
        rise_s = 0.0025 in 0.0..0.1;
    }
    /// Modules 0 and 4: screwing (paper II.b (2); values ours, from prototypes, unless stated).
    screw: Screw {
        /// Half of the square trajectory's long side, m.
        travel_m = 0.007 in 0.001..0.012;
        /// The square trajectory's short side: how far each finger moves out to return, m.
        clearance_m = 0.003 in 0.001..0.02;
        /// Speed of moving in, m/s.
        in_m_s = 0.01 in 0.001..0.05;
        /// Speed of turning, m/s. Too fast: the grip follows the contour too late.
        turn_m_s = 0.008 in 0.001..0.05;
        /// Speed of moving out, m/s.
        out_m_s = 0.02 in 0.001..0.05;
        /// Speed of returning, m/s.
        return_m_s = 0.03 in 0.001..0.1;
        /// How long the weakest finger must press more than F_1 before a turn begins, s.
        grip_s = 0.02 in 0.0..1.0;
        /// Speed at which the fingers centre themselves on the cap, m/s per newton of difference.
        centring_m_s_n = 0.0005 in 0.0..0.01;
        /// Multiple of dF_max at which Module 4 ends the screwing (paper: 1.4).
        finish_ratio = 1.4 in 1.05..5.0;
        /// Time constant of Module 4's tangential force, s.
        finish_filter_s = 0.01 in 0.0..0.5;
    }
    /// How the hand moves (ours).
    motion: Motion {
        /// Mean speed of free moves, m/s.
        reach_m_s = 0.12 in 0.01..0.5;
        /// Mean turning speed of free moves, rad/s.
        turn_rad_s = 0.8 in 0.05..3.0;
        /// Mean speed of lifting, m/s.
        lift_m_s = 0.01 in 0.001..0.1;
        /// Gap between fingertip and expected surface when the approach begins, m, per finger.
        clearance_m = 0.005 in 0.001..0.03;
        /// Opening speed when letting go, m/s, per finger.
        open_m_s = 0.03 in 0.001..0.07;
        /// Height above the grasp from which the hand comes down, m.
        descend_m = 0.06 in 0.0..0.2;
        /// Deepest closing beyond the expected surface before the approach gives up, m, per finger.
        search_m = 0.012 in 0.001..0.03;
    }
    /// How a hand follows a client's stream of targets (ours). The highest acceleration is the speed over `speed_up_s`, the highest jerk twice that over `smooth_s`.
    follow: Follow {
        /// Highest speed along each axis, m/s.
        move_m_s = 0.15 in 0.005..0.5;
        /// The same with something in the hand, m/s.
        carry_m_s = 0.06 in 0.001..0.5;
        /// Highest turning speed, rad/s.
        turn_rad_s = 0.8 in 0.05..3.0;
        /// Highest speed of each finger on its way to a width, m/s. Too fast: it presses before touch can stop it.
        finger_m_s = 0.02 in 0.001..0.07;
        /// Time from rest to the highest speed, s.
        speed_up_s = 0.25 in 0.02..2.0;
        /// Time constant of the low-pass that bounds the jerk, s.
        smooth_s = 0.04 in 0.005..0.5;
    }
    /// The last gate (ours, bounds from the fault catalogue).
    safety: Safety {
        /// Normal force of one finger that is never exceeded on purpose, N.
        grip_ceiling_n = 15.0 in 0.1..500.0;
        /// Multiple of F_2 above which a finger may only open.
        grip_ceiling_f2 = 1.5 in 1.0..5.0;
        /// Following error that is always allowed, rad.
        following_floor_rad = 0.08 in 0.001..1.0;
        /// Following error allowed per joint speed, s.
        following_per_speed_s = 0.03 in 0.0..1.0;
        /// Force by which what a skin says and what its joints bear may differ, N; beyond it, and a share of the force, the hand holds. Larger for servos that tell their torques badly.
        disagree_n = 0.3 in 0.01..10000.0;
        /// Share of the force by which they may differ besides.
        disagree_share = 0.3 in 0.01..10000.0;
        /// How long the following error must be too large until SAFE_STOP, s.
        following_s = 0.01 in 0.001..1.0;
        /// How long a command stays valid, s; at least 1.5 periods of the tick.
        valid_s = 0.005 in 0.001..0.1;
        /// How long a goal may pause in HOLD before it fails, s.
        pause_s = 0.5 in 0.0..60.0;
        /// Time without a tick after which the robot holds first, s. Too small: holds on every hiccup of a shared machine (8 ms measured). Too large: goes on with a world that has changed.
        stall_s = 0.02 in 0.003..1.0;
    }
}

impl Settings {
    /// Sets one parameter by name.
    ///
    /// # Errors
    /// [`SettingError`] when the name is unknown, the value is not a number within the range or contradicts another
    /// parameter's; nothing changes then.
    pub fn set(&mut self, name: &str, value: f64) -> Result<(), SettingError> {
        let parameter = find(name).ok_or(SettingError::Unknown)?;
        parameter.check(value)?;
        let mut changed = *self;
        (parameter.set)(&mut changed, value);
        changed.check_order()?;
        *self = changed;
        Ok(())
    }

    /// Checks every value against its range, and those that belong together against each other.
    ///
    /// # Errors
    /// The first [`SettingError`] found.
    pub fn check(&self) -> Result<(), SettingError> {
        PARAMETERS.iter().try_for_each(|p| p.check((p.get)(self)))?;
        self.check_order()
    }

    fn check_order(&self) -> Result<(), SettingError> {
        for (lower, upper) in ORDERED {
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

/// The parameter with this name.
#[must_use]
pub fn find(name: &str) -> Option<&'static Parameter> {
    PARAMETERS.iter().find(|p| p.name == name)
}

impl Parameter {
    /// Whether it bounds what the robot may do: nobody changes it while the robot may move.
    #[must_use]
    pub fn is_safety(&self) -> bool {
        self.name.starts_with("safety.")
    }

    /// Checks a value for this parameter.
    ///
    /// # Errors
    /// [`SettingError::OutOfRange`].
    pub fn check(&self, value: f64) -> Result<(), SettingError> {
        // NaN compares false with everything, so it is refused here as well.
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
