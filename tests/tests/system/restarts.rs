//! Tests that the grip survives the daemon: after a kill, an orderly end, a stop or a reload during
//! a grasp, the object stays in the hand. Real processes, signals and time.

use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime, Subscriber};
use shm_schemas::{JointCommand, WorldTruth, service};
use system_tests::{Process, lock_exclusive, wait_for};

/// Time for which the object must stay in the hand after the interruption, simulated ns.
const AFTER_NS: u64 = 1_000_000_000;
/// Height above which the object counts as lifted, m.
const LIFTED_M: f64 = 0.01;

/// A hand that lifts an object.
struct Rig {
    daemon: Process,
    _robot: Process,
    _goal: Process,
    truths: Subscriber<WorldTruth>,
    commands: Subscriber<JointCommand>,
    truth: Box<WorldTruth>,
    bus: FreshBus,
}

fn daemon(bus: &FreshBus) -> Process {
    // Long timeouts: a busy machine must not cause a HOLD.
    let set = |key: &'static str| ["--set", key];
    let patient = [
        set("intake.hold_age_s=0.3"),
        set("intake.reject_age_s=5"),
        set("safety.stall_s=1"),
    ];
    let usual = ["--config", "/dev/null", "--bus", bus.as_str()];
    let arguments = [&usual[..], patient.as_flattened()].concat();
    Process::start("atasd", &arguments)
}

impl Rig {
    fn new((object, at, width): (&str, &str, &str)) -> Self {
        let bus = FreshBus::new("restarts");
        let name = bus.as_str();
        let simulate = ["run", "--object", object, "--bus", name];
        let simulator = Process::start("atas-sim", &simulate);
        let controller = daemon(&bus);
        wait_for("the daemon", || {
            let mut asked = Process::start("atas", &["status", "--bus", name]);
            (asked.wait().code() == Some(0)).then_some(())
        });
        let goal = [
            "grasp", "--at", at, "--width", width, "--hold", "3600", "--bus", name,
        ];
        let observer = Bus::open(&bus, "judge", Realtime::No).expect("a bus");
        Self {
            _robot: simulator,
            daemon: controller,
            _goal: Process::start("atas", &goal),
            truths: observer
                .subscriber(service::WORLD_TRUTH)
                .expect("a subscriber"),
            commands: observer
                .subscriber(service::JOINT_COMMAND)
                .expect("a subscriber"),
            truth: Box::default(),
            bus,
        }
    }

    /// Waits until the ground truth fulfils a condition.
    fn wait_until(&mut self, what: &str, wanted: impl Fn(&WorldTruth) -> bool) {
        let Self { truths, truth, .. } = self;
        wait_for(what, || {
            truths.newest(truth).expect("readable");
            wanted(truth).then_some(())
        });
    }

    fn until_lifted(&mut self, metres: f64) {
        self.wait_until("the object to be lifted", |t| {
            t.objects[0].lifted_m > metres
        });
    }

    /// Returns the grip force limit that the daemon commands now, N.
    fn limit_n(&mut self) -> f64 {
        let commands = &mut self.commands;
        let mut command = JointCommand::default();
        // A queued command may come from a previous daemon.
        commands.newest(&mut command).expect("readable");
        wait_for("a command with a grip limit", || {
            let came = commands.newest(&mut command).expect("readable");
            let limit_n = command.grip_limit_n[1];
            (came && limit_n > 0.0).then_some(limit_n)
        })
    }

    fn atas(&self, word: &str) {
        let mut asked = Process::start("atas", &[word, "--bus", self.bus.as_str()]);
        assert_eq!(asked.wait().code(), Some(0), "atas {word}: {}", asked.log());
    }

    /// Ends the daemon with a signal and starts the next one.
    fn replace(&mut self, signal: Signal) {
        self.daemon.signal(signal);
        self.daemon.wait();
        self.daemon = daemon(&self.bus);
    }

    fn assert_kept(&mut self, what: &str) {
        let until_ns = self.truth.stamp.captured_ns + AFTER_NS;
        self.wait_until(what, |truth| truth.stamp.captured_ns >= until_ns);
        let object = &self.truth.objects[0];
        assert_eq!((object.dropped, object.crushed), (0, 0), "{what}");
        assert!(object.lifted_m > LIFTED_M, "{what}: {} m", object.lifted_m);
    }
}

/// Name and action of an interruption of the daemon.
type Interruption = (&'static str, fn(&mut Rig));

/// Interruptions of the daemon.
const INTERRUPTIONS: [Interruption; 5] = [
    ("killed", |rig| rig.replace(Signal::KILL)),
    // Shared memory was truncated.
    ("ended by SIGBUS", |rig| rig.replace(Signal::BUS)),
    ("ended", |rig| rig.replace(Signal::TERM)),
    ("stopped and recovered", |rig| {
        rig.atas("estop");
        rig.atas("recover");
    }),
    ("reloaded", |rig| rig.daemon.signal(Signal::HUP)),
];

#[test]
fn object_stays_in_hand_through_daemon_interruptions() {
    let _alone = lock_exclusive();
    let mut held = Rig::new(("wood", "0.32,-0.15,0.0345", "50"));
    held.until_lifted(0.035);
    let borne_n = held.limit_n();
    for (what, interrupt) in INTERRUPTIONS {
        interrupt(&mut held);
        held.assert_kept(&format!("{what} while it holds"));
        assert_eq!(held.limit_n(), borne_n, "{what}");
    }
    for (what, interrupt) in INTERRUPTIONS {
        let mut lifted = Rig::new(("sponge", "0.32,-0.15,0.029", "60"));
        lifted.until_lifted(0.012);
        interrupt(&mut lifted);
        lifted.assert_kept(&format!("{what} while it lifts"));
    }
}
