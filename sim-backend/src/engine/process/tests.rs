//! Engines that hang or end.

use super::*;
use crate::scene::Scene;
use robot_model::RobotModel;

const SHORT: Limits = Limits {
    begin_s: 0.3,
    tick_s: 0.3,
    end_s: 0.3,
};

/// Starts a shell script as engine, with short limits.
fn engine(script: &str) -> (tempfile::TempDir, EngineProcess) {
    let folder = tempfile::tempdir().expect("temporary folder");
    let path = folder.path().join("engine.sh");
    std::fs::write(&path, script).expect("writable folder");
    let command = format!("sh {}", path.display());
    let command = command.parse().expect("valid command");
    let mut engine = EngineProcess::start(&command).expect("sh starts");
    engine.limits = SHORT;
    (folder, engine)
}

fn is_running(engine: &EngineProcess) -> bool {
    let id = rustix::process::Pid::from_child(&engine.child);
    rustix::process::test_kill_process(id).is_ok()
}

#[test]
fn hanging_engine_is_ended_with_an_error() {
    // Without an answer; and while its input is full: the message exceeds a pipe.
    for bytes in [10, 1 << 20] {
        let (_folder, mut engine) = engine("exec sleep 60");
        engine.message = vec![0; bytes];
        let begin = Instant::now();
        let failed = engine.exchange(BEGIN, engine.limits.begin_s);
        assert_eq!(failed, Err(EngineError::Timeout { seconds: 0.3 }));
        assert!(engine.is_lost());
        drop(engine);
        assert!(begin.elapsed() < Duration::from_secs(20));
    }
}

#[test]
fn hanging_tick_is_ended_with_an_error() {
    let ready = "printf '\\003\\000\\000\\000\\000\\000\\000\\000'; exec sleep 60";
    let (_folder, mut engine) = engine(ready);
    engine.limits.begin_s = 20.0;
    engine.message = vec![0; 10];
    assert_eq!(engine.exchange(BEGIN, 20.0), Ok(READY));
    let robot = RobotModel::two_hand_arm().expect("built-in robot");
    let scene = Scene::default();
    let (input, mut state) = (
        TickInput::new(&robot, &scene),
        PhysicsState::new(&robot, &scene),
    );
    let failed = engine.advance(&input, &mut state);
    assert_eq!(failed, Err(EngineError::Timeout { seconds: 0.3 }));
}

#[test]
fn engine_that_ignores_its_input_is_killed() {
    let (_folder, engine) = engine("exec sleep 60");
    assert!(is_running(&engine));
    let id = rustix::process::Pid::from_child(&engine.child);
    let begin = Instant::now();
    drop(engine);
    assert!(begin.elapsed() < Duration::from_secs(20));
    assert!(rustix::process::test_kill_process(id).is_err());
}

#[test]
fn engine_that_ends_is_not_waited_for() {
    let (_folder, mut engine) = engine("cat >/dev/null");
    engine.limits.end_s = 60.0;
    let begin = Instant::now();
    drop(engine);
    assert!(begin.elapsed() < Duration::from_secs(20));
}
