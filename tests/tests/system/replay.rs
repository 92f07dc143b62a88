//! Tests of recorded frames: `atas-sensor replay` to another daemon, and evaluation against labels.

use serde_json::Value;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{Status, service};
use system_tests::{Process, binary, lock_exclusive, wait_for};

use crate::recorded;

/// Configuration of a daemon without joints; the default sensor layout.
const CONFIG: &str = "
[robot]
joints_required = false
[hands.left]
required = false
# A busy machine may suspend the daemon between clock and intake; new frames then look like future ones.
[intake]
future_s = 0.1
";

#[test]
fn daemon_receives_replayed_grasp_without_loss() {
    let _alone = lock_exclusive();
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let file = path("run.mcap");
    assert_eq!(recorded::grasp("wood", &file), Some(0));
    let config = path("feels.toml");
    std::fs::write(&config, CONFIG).expect("writable");
    let bus = FreshBus::new("played");
    let name = bus.as_str();
    let _daemon = Process::start("atasd", &["--bus", name, "--config", &config]);
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let mut statuses = observer
        .subscriber::<Status>(service::STATUS)
        .expect("a subscriber");
    let mut status = Status::default();
    let mut look = || {
        let is_new = statuses.newest(&mut status).expect("readable");
        is_new.then_some(status)
    };
    wait_for("the daemon", &mut look);
    let replay = ["replay", &file, "--hand", "right", "--bus", name];
    let mut replay = Process::start("atas-sensor", &replay);
    assert_eq!(replay.wait().code(), Some(0), "{}", replay.log());
    let played = replay.log();
    let frames = played.split(" frames played, 0 lost").next();
    let frames = frames.and_then(|text| text.rsplit(' ').next()?.parse().ok());
    let frames: u64 = frames.unwrap_or_else(|| panic!("{played}"));
    assert!(frames > 5000, "{played}");
    let hand = wait_for("every frame", || {
        let hand = look()?.hands[1];
        (hand.frames + hand.lost >= frames).then_some(hand)
    });
    assert_eq!((hand.frames, hand.lost), (frames, 0), "{played}");
    assert_eq!((hand.corrupt, hand.foreign, hand.mistimed), (0, 0, 0));
    assert!(
        hand.touches[..2].iter().all(|touches| *touches >= 1),
        "{:?}",
        hand.touches
    );
}

#[test]
fn recorded_grasp_is_evaluated_by_labels() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    let file = path("run.mcap");
    assert_eq!(recorded::grasp("wood", &file), Some(0));
    // The object is untouched before the second span's end; the lift loads the fingertips.
    let spans = "from_s,to_s,label,hand\n0,2,stable,right\n2,4,stable,right\n4.7,8,moving,right\n";
    std::fs::write(path("run.csv"), spans).expect("writable");
    let output = std::process::Command::new(binary("atas"))
        .args([
            "eval",
            "recording",
            &file,
            "--labels",
            "label",
            "--format",
            "json",
        ])
        .args(["--negative", "stable"])
        .output()
        .expect("it starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let verdict: Value = serde_json::from_str(&text).unwrap_or_default();
    // Three spans, two fingertips.
    assert_eq!(
        (&verdict["judged"], &verdict["n"]),
        (&"slip".into(), &6.into()),
        "{output:?}"
    );
    assert_eq!(verdict["balanced_accuracy"], 1.0, "{verdict}");
}
