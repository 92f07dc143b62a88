//! The judge: all checks of one tick.

use shm_schemas::capacity::JOINTS;
use shm_schemas::{JointCommand, WorldTruth};

use crate::allowance::Allowance;
use crate::bounds::{BoundsError, JointBounds};
use crate::content;
use crate::findings::{Findings, Violation, ViolationKind};
use crate::grip::{GripCheck, GripError};
use crate::modes::ModeCheck;
use crate::motion::MotionCheck;
use crate::objects::ObjectCheck;
use crate::promise::{Promise, Promises};
use crate::stamps::{Relation, StampCheck};

/// Independent judge of a controller.
///
/// It may begin at any command. Differences are checked as soon as the positions before are known.
#[derive(Clone, Debug)]
pub struct Judge {
    stamps: StampCheck,
    modes: ModeCheck,
    motion: MotionCheck,
    promises: Promises,
    objects: ObjectCheck,
    grip: GripCheck,
    truth: WorldTruth,
    findings: Findings,
}

impl Judge {
    /// Creates a judge of a controller with this tick period, in the order of the command's joints.
    /// A command may be valid for at most `validity_max_ns`.
    ///
    /// # Errors
    /// [`BoundsError`] if a limit is not finite or inconsistent, or a duration is zero.
    pub fn new(
        bounds: Vec<JointBounds>,
        tick_ns: u64,
        validity_max_ns: u64,
    ) -> Result<Self, BoundsError> {
        if !(1..=JOINTS).contains(&bounds.len()) {
            return Err(BoundsError::JointCount {
                count: bounds.len(),
            });
        }
        bounds.iter().try_for_each(JointBounds::check)?;
        let durations = [
            ("tick_ns", tick_ns, "tick period"),
            ("validity_max_ns", validity_max_ns, "longest validity"),
        ];
        for (field, duration_ns, meaning) in durations {
            if duration_ns == 0 {
                return Err(BoundsError::Duration { field, meaning });
            }
        }
        Ok(Self {
            stamps: StampCheck::new(tick_ns, validity_max_ns),
            modes: ModeCheck::default(),
            motion: MotionCheck::new(bounds, tick_ns as f64 / 1e9),
            promises: Promises::default(),
            objects: ObjectCheck::default(),
            grip: GripCheck::default(),
            truth: WorldTruth::default(),
            findings: Findings::default(),
        })
    }

    /// Accepts a deviation that the test expects.
    #[must_use]
    pub fn allowing(mut self, allowance: Allowance) -> Self {
        self.stamps.allow(allowance);
        self.objects.allow(allowance);
        self
    }

    /// Checks the command of one tick, and the world after it.
    pub fn observe(&mut self, command: &JointCommand, truth: &WorldTruth) {
        self.findings.begin(command.tick);
        let is_intact = command.is_intact();
        if is_intact {
            self.check_command(command);
        } else {
            self.findings.report(
                ViolationKind::Checksum,
                format_args!("the checksum does not match the content"),
            );
            self.stamps.forget();
            self.motion.forget();
        }
        let mode = is_intact.then_some(command.mode);
        self.promises.check(mode, &mut self.findings);
        self.objects.check(truth, &mut self.findings);
        self.grip.check(truth, &mut self.findings);
        self.truth = *truth;
    }

    /// Permits one new writer: the daemon process was replaced. Its sequence begins at 0, its mode
    /// at INIT, and its motion at the positions last in force, at rest.
    pub fn restarted(&mut self) {
        self.stamps.restarted();
    }

    /// Accepts the next command without the ones before it: the observer was not scheduled for so
    /// long that it lost commands. Times, limits of motion and grip are judged again from there.
    pub fn observer_paused(&mut self) {
        self.stamps.observer_paused();
    }

    /// Permits one discontinuity: the robot restarted, or moved without command. The controller
    /// may command no joints until it has measured them, and begins there at rest.
    pub fn robot_moved(&mut self) {
        self.motion.robot_moved();
    }

    /// Permits one transition from SAFE_STOP to HOLD.
    pub fn recover_requested(&mut self) {
        self.modes.recover_requested();
    }

    /// Adds a promise that begins with the next command.
    pub fn promise(&mut self, promise: Promise) {
        self.promises.add(promise);
    }

    /// Returns the ticks until the last [`Promise::reach`] was fulfilled, also if late; `None`
    /// until then. A new promise of this kind resets it.
    #[must_use]
    pub fn reached_after(&self) -> Option<u64> {
        self.promises.reached_after()
    }

    /// Requires from now on that the hand keeps this object. Slip and turn count from now.
    ///
    /// # Errors
    /// [`GripError`] if the last ground truth has no such object in a hand above its rest height.
    pub fn expect_grip_kept(&mut self, object: usize) -> Result<(), GripError> {
        self.grip.expect(object, &self.truth)
    }

    /// Ends [`Judge::expect_grip_kept`].
    pub fn release_grip(&mut self) {
        self.grip.release();
    }

    /// Ends the observation: a promised mode that has not appeared is a violation, also before its
    /// time limit.
    pub fn finish(&mut self) {
        self.promises.finish(&mut self.findings);
    }

    /// Returns the first violations of each kind, at most [`crate::KEPT_PER_KIND`], in order of
    /// time.
    #[must_use]
    pub fn violations(&self) -> &[Violation] {
        self.findings.kept()
    }

    /// Returns the number of all violations.
    #[must_use]
    pub fn violation_count(&self) -> u64 {
        self.findings.count()
    }

    /// Returns the number of all violations of one kind.
    #[must_use]
    pub fn count_of(&self, kind: ViolationKind) -> u64 {
        self.findings.count_of(kind)
    }

    fn check_command(&mut self, command: &JointCommand) {
        let is_finite = content::is_finite(command, &mut self.findings);
        let relation = self.stamps.check(command, &mut self.findings);
        match relation {
            Relation::Next => {}
            Relation::Expired => self.motion.halt(),
            Relation::Lost => self.motion.forget(),
            Relation::NewWriterAfterLoss => {
                self.motion.forget();
                self.motion.new_writer();
            }
            Relation::NewWriter => self.motion.new_writer(),
        }
        let is_new_writer = matches!(relation, Relation::NewWriter | Relation::NewWriterAfterLoss);
        self.modes
            .check(command.mode, is_new_writer, &mut self.findings);
        if is_finite {
            self.motion.check(command, &mut self.findings);
        } else {
            self.motion.forget();
        }
    }
}
