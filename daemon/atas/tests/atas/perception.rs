//! Perception: contact, dF_t, friction utilisation, bias.

use crate::support::{MS_NS, dome, frame, press, robot, spread};
use atas_core::intake::FrameIntake;
use atas_core::perception::{ContactPercept, Perception};
use atas_core::settings::Settings;
use atas_core::{HandSensorSetup, Tick};
use nalgebra::Vector3;
use robot_model::HandSide;
use shm_schemas::{Hand, HandFrame, Layout};

/// Half angle of a contact over the whole fingertip, degrees.
const WIDE: f64 = 33.0;
/// Half angle of a small contact, degrees.
const NARROW: f64 = 15.0;

/// Perception of synthetic frames through the real intake.
struct Skin {
    intake: FrameIntake,
    perception: Perception,
    settings: Settings,
    sequence: u64,
    now_ns: u64,
    slides: bool,
}

impl Skin {
    fn new() -> Self {
        Self::of(HandSensorSetup::default())
    }

    fn of(wiring: HandSensorSetup) -> Self {
        Self {
            slides: false,
            intake: FrameIntake::new(Hand::LEFT, &wiring),
            perception: Perception::new(&wiring, robot().hand(HandSide::Right)),
            settings: Settings::default(),
            sequence: 0,
            now_ns: 1_000 * MS_NS,
        }
    }

    fn of_layout(layout: &Layout) -> Self {
        Self::of(HandSensorSetup {
            layout: *layout,
            ..HandSensorSetup::default()
        })
    }

    fn unfiltered() -> Self {
        let mut skin = Self::new();
        skin.settings.set("perception.filter_s", 0.0).unwrap();
        skin
    }

    /// Advances by some time with one frame at its end; fingertip 0 has this force per element.
    fn feel(
        &mut self,
        after_ns: u64,
        force_n: impl Fn(Vector3<f64>) -> Vector3<f64>,
    ) -> ContactPercept {
        self.now_ns += after_ns;
        let mut frame = frame(Hand::LEFT, self.sequence, self.now_ns);
        self.sequence += 1;
        press(&mut frame, 0, force_n);
        self.take(&frame);
        self.perception.percept().fingertips[0]
    }

    /// Advances by 1 ms with a frame of a skin with this layout; fingertip 0 has this force per
    /// element.
    fn feel_elements(
        &mut self,
        layout: &Layout,
        felt_n: impl Fn(usize) -> [f32; 3],
    ) -> ContactPercept {
        self.now_ns += MS_NS;
        let mut frame = frame(Hand::LEFT, self.sequence, self.now_ns);
        self.sequence += 1;
        let mask = u64::MAX >> (64 - layout.count);
        (frame.layout_hash, frame.valid_mask) = (layout.hash(), [mask, mask, 0, 0]);
        let elements = frame.force_n[0][..layout.count].iter_mut().enumerate();
        elements.for_each(|(element, force_n)| *force_n = felt_n(element));
        frame.seal();
        self.take(&frame);
        self.perception.percept().fingertips[0]
    }

    fn take(&mut self, frame: &HandFrame) {
        let tick = Tick {
            index: self.sequence,
            now_ns: self.now_ns,
        };
        self.intake.begin();
        self.perception.begin();
        let checked = self
            .intake
            .validate(frame, tick, &self.settings.intake)
            .unwrap();
        self.perception
            .update(&checked, self.slides, &self.settings);
    }

    /// Constant total force on a round contact at the pole, for frames of 1 ms.
    fn hold(&mut self, frames: u64, force_n: Vector3<f64>) -> ContactPercept {
        let share = spread(Vector3::z(), NARROW);
        let mut percept = ContactPercept::default();
        for _ in 0..frames {
            percept = self.feel(MS_NS, |d| force_n * share(d));
        }
        percept
    }
}

/// On flat and cylindrical faces and single elements, uniform shear does not imply slip. After an
/// observed slip its force ratio is the friction.
#[test]
fn flat_face_learns_friction_only_from_slip() {
    for name in ["dome-1", "pad-16", "flat-4x4-4.5", "cylinder-4x4-4.5-12"] {
        let layout = Layout::from_name(name).expect("a known layout");
        let mut skin = Skin::of_layout(&layout);
        let hold = |skin: &mut Skin, tangential_n: f32| {
            let mut percept = ContactPercept::default();
            for _ in 0..400 {
                let share = 1.0 / layout.count as f32;
                let noise_n = ((skin.sequence + 1) % 7) as f32 * 1e-5;
                let element_n = [2.0 * share, tangential_n * share + noise_n, 0.0];
                percept = skin.feel_elements(&layout, |_| element_n);
            }
            percept
        };
        let loaded = hold(&mut skin, 0.8);
        assert!(
            !loaded.shows_incipient_slip && loaded.tangential_n > 0.7,
            "{name}: {loaded:?}"
        );
        assert_eq!((loaded.utilisation, loaded.friction), (0.0, 0.0), "{name}");
        skin.slides = true;
        hold(&mut skin, 0.8);
        skin.slides = false;
        let known = hold(&mut skin, 0.4);
        assert!((known.friction - 0.4).abs() < 0.02, "{name}: {known:?}");
        assert!((known.utilisation - 0.5).abs() < 0.05, "{name}: {known:?}");
    }
}

fn tilted(degrees: f64, towards_rad: f64) -> Vector3<f64> {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Vector3::new(sin * towards_rad.cos(), sin * towards_rad.sin(), cos)
}

/// The fingertip's geometry must not leak into F_t: along the fingertip axis these forces would
/// have F_t = 0.36 F_n.
#[test]
fn normal_force_off_pole_has_no_tangential_part() {
    for towards_rad in [0.0, 0.8, 2.0, 3.9, 5.5] {
        for degrees in [0.0, 10.0, 20.0] {
            let centre = tilted(degrees, towards_rad);
            let share = spread(centre, NARROW);
            let measured = Skin::unfiltered().feel(MS_NS, |d| -centre * (3.0 * share(d)));
            assert!(
                (measured.normal_n - 3.0).abs() < 0.03,
                "{degrees}° {towards_rad} rad: {measured:?}"
            );
            assert!(
                measured.tangential_n < 0.05 * 3.0,
                "{degrees}° {towards_rad} rad: {measured:?}"
            );
            assert!(
                measured.patch_normal.dot(&centre) > 3_f64.to_radians().cos(),
                "{measured:?}"
            );
            assert!(
                (measured.force_tip_n + centre * 3.0).norm() < 1e-5,
                "{measured:?}"
            );
        }
    }
}

#[test]
fn shear_is_reported_as_tangential_force() {
    for centre in [Vector3::z(), tilted(15.0, 1.0)] {
        let share = spread(centre, NARROW);
        let across = centre.cross(&Vector3::x()).normalize();
        let measured = Skin::unfiltered().feel(MS_NS, |d| (across * 0.8 - centre * 2.0) * share(d));
        assert!((measured.normal_n - 2.0).abs() < 0.1, "{measured:?}");
        assert!((measured.tangential_n - 0.8).abs() < 0.1, "{measured:?}");
    }
}

#[test]
fn weak_patch_uses_the_fingertip_axis() {
    let share = spread(tilted(20.0, 0.0), NARROW);
    let measured = Skin::unfiltered().feel(MS_NS, |d| -d * (0.05 * share(d)));
    assert_eq!(measured.patch_normal, Vector3::z());
}

/// 63 % after one time constant of sensor time, at any frame rate.
#[test]
fn low_pass_uses_sensor_time() {
    for (step_ns, frames) in [(MS_NS / 4, 20), (MS_NS, 5)] {
        let mut skin = Skin::new();
        let share = spread(Vector3::z(), NARROW);
        skin.feel(step_ns, |_| Vector3::zeros());
        let mut measured = ContactPercept::default();
        for _ in 0..frames {
            measured = skin.feel(step_ns, |d| -Vector3::z() * share(d));
        }
        assert!(
            (measured.normal_n - 0.62).abs() < 0.03,
            "{step_ns} ns: {}",
            measured.normal_n
        );
    }
}

#[test]
fn contact_has_hysteresis() {
    let mut skin = Skin::unfiltered();
    for (normal_n, in_contact, touches) in [
        (0.0, false, 0),
        (0.05, false, 0),
        (0.07, true, 1),
        (0.04, true, 1),
        (0.07, true, 1),
        (0.035, true, 1),
        (0.02, false, 1),
        (0.05, false, 1),
        (0.065, true, 2),
        (-1.0, false, 2),
    ] {
        let measured = skin.hold(1, Vector3::z() * -normal_n);
        assert_eq!(
            (measured.in_contact, measured.touches),
            (in_contact, touches),
            "at {normal_n} N"
        );
    }
}

#[test]
fn bias_zeroes_the_present_reading() {
    let mut skin = Skin::new();
    let offset_n = Vector3::new(0.2, -0.1, -0.5);
    assert!(skin.hold(100, offset_n).in_contact);
    skin.perception.bias();
    let measured = skin.hold(100, offset_n);
    assert!(
        measured.normal_n.abs() < 1e-3 && measured.tangential_n < 2e-3 && !measured.in_contact,
        "{measured:?}"
    );
    let measured = skin.hold(100, offset_n - Vector3::z());
    assert!((measured.normal_n - 1.0).abs() < 1e-2, "{measured:?}");
}

/// Force on an untouched fingertip, N, that loads it for a time, s: the remaining reading, N.
#[test]
fn zero_follows_drift_but_not_a_touch() {
    for (what, force_n, force_n_s, time_s, remains_n) in [
        ("offset", 0.05, 0.0, 2.0, 0.0..0.002),
        ("slow drift", 0.0, 0.05, 20.0, 0.0..0.02),
        ("touch of a sponge", 0.0, 0.6, 0.1, 0.05..0.06),
        ("touch of a rigid block", 0.0, 10.0, 0.01, 0.09..0.1),
        ("pull", -0.05, 0.0, 2.0, -0.002..0.0),
    ] {
        let mut skin = Skin::unfiltered();
        let ticks = (time_s * 1e3) as u32;
        for tick in 0..ticks {
            let normal_n = force_n + force_n_s * f64::from(tick) * 1e-3;
            skin.hold(1, Vector3::z() * -normal_n);
            skin.perception.track_zero(true, &skin.settings.perception);
        }
        let last_n = force_n + force_n_s * f64::from(ticks) * 1e-3;
        let read_n = skin.hold(1, Vector3::z() * -last_n).normal_n;
        let around = remains_n.start - 1e-9..remains_n.end + 1e-9;
        assert!(around.contains(&read_n), "{what}: {read_n} N");
    }
}

#[test]
fn zero_stays_in_contact_and_at_rate_0() {
    let pressed = Vector3::z() * -0.5;
    for (rate_n_s, moves_freely, read_n) in [(0.1, false, 0.5), (0.1, true, 0.4), (0.0, true, 0.5)]
    {
        let mut skin = Skin::unfiltered();
        skin.settings
            .set("perception.zero_tracking_n_s", rate_n_s)
            .unwrap();
        for _ in 0..1000 {
            skin.hold(1, pressed);
            skin.perception
                .track_zero(moves_freely, &skin.settings.perception);
        }
        let normal_n = skin.hold(1, pressed).normal_n;
        assert!(
            (normal_n - read_n).abs() < 0.005,
            "{rate_n_s} N/s: {normal_n} N"
        );
    }
}

/// Force at 2 N/s: the increment over the 100 ms window is 0.2 N, from a fast and from a slow
/// sensor.
#[test]
fn increment_spans_its_window_at_any_rate() {
    for step_ns in [MS_NS / 4, MS_NS, 10 * MS_NS, 33 * MS_NS] {
        let mut skin = Skin::unfiltered();
        let share = spread(Vector3::z(), NARROW);
        let mut time_s = 0.0;
        let mut measured = ContactPercept::default();
        while time_s < 0.5 {
            time_s += step_ns as f64 * 1e-9;
            measured = skin.feel(step_ns, |d| {
                Vector3::new(2.0 * time_s, 0.0, -3.0) * share(d)
            });
        }
        let within = 0.2 * (1.0 - 1e-9 * step_ns as f64 / 0.1) - 0.01..0.205;
        assert!(
            within.contains(&measured.increment_n),
            "{step_ns} ns: {}",
            measured.increment_n
        );
    }
}

#[test]
fn force_step_shows_for_one_window() {
    let mut skin = Skin::unfiltered();
    let steady = skin.hold(300, Vector3::new(0.5, 0.0, -3.0));
    assert!(steady.increment_n < 1e-3, "{}", steady.increment_n);
    // The direction counts as well as the magnitude.
    let turned = skin.hold(1, Vector3::new(0.0, 0.5, -3.0));
    assert!(
        (turned.increment_n - 0.5 * 2_f64.sqrt()).abs() < 2e-2,
        "{}",
        turned.increment_n
    );
    assert!(skin.hold(90, Vector3::new(0.0, 0.5, -3.0)).increment_n > 0.69);
    assert!(skin.hold(15, Vector3::new(0.0, 0.5, -3.0)).increment_n < 1e-3);
}

/// A tick without a frame changes nothing: differences of held samples would spike at every new
/// frame.
#[test]
fn held_samples_count_once() {
    let mut skin = Skin::unfiltered();
    skin.hold(50, Vector3::new(0.3, 0.0, -1.0));
    let before = *skin.perception.percept();
    assert!(before.step_s > 0.0);
    skin.perception.begin();
    assert_eq!(skin.perception.percept().fingertips, before.fingertips);
    assert_eq!(skin.perception.percept().step_s, 0.0);
}

/// Elements on a common displacement stick up to μ·p: the rim slips first, in the end all slip.
fn sheared(slide: f64) -> impl Fn(Vector3<f64>) -> Vector3<f64> {
    const FRICTION: f64 = 0.5;
    let share = spread(Vector3::z(), WIDE);
    move |d| {
        let normal_n = 4.0 * share(d);
        Vector3::new((FRICTION * normal_n).min(slide), 0.0, -normal_n)
    }
}

#[test]
fn utilisation_rises_to_one_in_gross_slip() {
    let mut skin = Skin::unfiltered();
    for _ in 0..100 {
        skin.feel(MS_NS, |d| {
            -Vector3::z() * (4.0 * spread(Vector3::z(), WIDE)(d))
        });
    }
    let largest = dome().0.normal[..41]
        .iter()
        .map(|d| sheared(1.0)(Vector3::from(*d)).x)
        .fold(0.0, f64::max);
    let mut seen = Vec::new();
    for step in 1..=30 {
        let mut measured = ContactPercept::default();
        for _ in 0..40 {
            measured = skin.feel(MS_NS, sheared(largest * f64::from(step) / 20.0));
        }
        seen.push(measured);
    }
    // Low utilisation half way; from step 20 all elements slip.
    assert!(seen[7].utilisation < 0.9, "{:?}", seen[7]);
    assert!(seen[7].gross_slip_s == 0.0, "{:?}", seen[7]);
    let last = seen.last().unwrap();
    assert!(
        last.utilisation > 0.95 && last.utilisation_now > 0.95,
        "{last:?}"
    );
    assert!(last.gross_slip_s > 0.1, "{last:?}");
    assert!((last.friction - 0.5).abs() < 0.05, "{last:?}");
    assert!(
        seen[9..].is_sorted_by(|a, b| a.utilisation <= b.utilisation + 0.02),
        "{seen:?}"
    );
}

#[test]
fn gross_slip_begins_at_its_parameter() {
    for (slip_gross, slips) in [(0.955, true), (1.2, false)] {
        let mut skin = Skin::unfiltered();
        skin.settings.grasp.slip_gross = slip_gross;
        let mut measured = ContactPercept::default();
        for _ in 0..200 {
            measured = skin.feel(MS_NS, sheared(4.0));
        }
        assert!(measured.utilisation_now > 0.955, "{measured:?}");
        assert_eq!(
            measured.gross_slip_s > 0.1,
            slips,
            "{slip_gross}: {measured:?}"
        );
    }
}

/// After a slip that sticks again at less shear, the patch stays uniformly sheared; only the force
/// ratio shows the stick.
#[test]
fn gross_slip_ends_when_friction_ratio_falls() {
    let slide = |skin: &mut Skin, friction: f64| {
        let share = spread(Vector3::z(), WIDE);
        let mut measured = ContactPercept::default();
        for _ in 0..200 {
            measured = skin.feel(MS_NS, |d| {
                Vector3::new(friction, 0.0, -1.0) * (4.0 * share(d))
            });
        }
        measured
    };
    let mut skin = Skin::unfiltered();
    for (friction, slips) in [
        (0.5, true),
        (0.49, true),
        (0.45, false),
        (0.5, true),
        (0.6, true),
    ] {
        let measured = slide(&mut skin, friction);
        assert!(measured.utilisation_now > 0.955, "{friction}: {measured:?}");
        assert_eq!(
            measured.gross_slip_s > 0.0,
            slips,
            "{friction}: {measured:?}"
        );
    }
}

#[test]
fn release_resets_the_friction() {
    let mut skin = Skin::unfiltered();
    assert!(skin.hold(200, Vector3::new(1.0, 0.0, -2.0)).friction > 0.3);
    let measured = skin.hold(10, Vector3::zeros());
    assert_eq!(
        (
            measured.friction,
            measured.utilisation,
            measured.gross_slip_s
        ),
        (0.0, 0.0, 0.0)
    );
}

#[test]
fn no_contact_gives_no_utilisation() {
    let measured = Skin::new().hold(100, Vector3::zeros());
    assert_eq!(
        (
            measured.utilisation,
            measured.utilisation_now,
            measured.in_contact
        ),
        (0.0, 0.0, false)
    );
}

/// Pressure distribution over a flat face, and the share in contact.
#[test]
fn pressure_distribution_gives_contact_share() {
    let layout = Layout::from_name("flat-4x4-4.5").expect("a layout");
    for (name, weights, expected) in [
        ("even", [1.0, 1.0, 1.0, 1.0], 1.0),
        ("whole face, more at one edge", [1.0, 2.0, 3.0, 4.0], 1.0),
        ("wedge over three rows", [5.0, 3.0, 1.0, 0.0], 0.77),
        ("wedge over two rows", [3.0, 1.0, 0.0, 0.0], 0.53),
        ("one row", [1.0, 0.0, 0.0, 0.0], 0.33),
    ] {
        let mut skin = Skin::of_layout(&layout);
        let row_n = weights.map(|weight: f32| weight / 10.0);
        let mut feel = || skin.feel_elements(&layout, |element| [row_n[element / 4], 0.0, 0.0]);
        let share = (0..100).map(|_| feel().loaded_share).last().unwrap();
        assert!((share - expected).abs() < 0.01, "{name}: {share}");
    }
    let share = Skin::new()
        .hold(100, Vector3::new(0.0, 0.0, -1.0))
        .loaded_share;
    assert_eq!(
        share, 1.0,
        "a dome's compression model includes its contact area"
    );
}

/// Elements that fail under load leave the share of the force that they carried.
#[test]
fn masked_share_is_that_of_the_failed_elements() {
    let layout = Layout::from_name("flat-4x4-4.5").expect("a layout");
    let mut skin = Skin::of_layout(&layout);
    let mut share = |failed: &[usize]| {
        let felt_n = |element: usize| {
            let normal_n = match element {
                _ if failed.contains(&element) => f32::NAN,
                5 => 0.4,
                6 => 0.2,
                9 => 0.1,
                10 => 0.3,
                _ => 0.0,
            };
            [normal_n, 0.0, 0.0]
        };
        let shares = (0..500).map(|_| skin.feel_elements(&layout, felt_n).masked_share);
        shares.last().unwrap()
    };
    for (failed, expected) in [
        (&[][..], 0.0),
        (&[0], 0.0),
        (&[0, 9], 0.1),
        (&[0, 6, 9], 0.25),
        (&[9], 0.25),
        (&[], 0.0),
        (&[6], 0.2),
        (&[], 0.0),
        (&[5], 0.25),
    ] {
        let share = share(failed);
        assert!((share - expected).abs() < 0.005, "{failed:?}: {share}");
    }
}
