//! Interruption, full disk and concurrent processes: finished runs are never lost.

use super::*;

#[test]
fn interrupted_experiment_gives_the_same_files() {
    const LONGER: &str = "experiment fig14 --preset N --seeds 12 --generations 150 --threads 1";
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{LONGER} --out straight"));
    let mut child = ebts(folder, &format!("{LONGER} --out cut"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ebts starts");
    let runs = folder.join("cut/runs.jsonl");
    while std::fs::metadata(&runs).map_or(0, |file| file.len()) == 0
        && child.try_wait().expect("a child").is_none()
    {
        std::thread::sleep(Duration::from_millis(5));
    }
    interrupt(child.id());
    let code = child.wait().expect("a child").code();
    assert!(matches!(code, Some(5 | 0)), "{code:?}");
    // A power cut can leave an incomplete line.
    let mut torn = std::fs::read(&runs).expect("runs");
    torn.extend_from_slice(b"{\"agents\":4,\"se");
    std::fs::write(&runs, torn).expect("a writable file");
    run(folder, &format!("{LONGER} --out cut"));
    assert_eq!(results(folder, "cut"), results(folder, "straight"));
    assert!(
        !folder.join("cut/under-way").exists(),
        "no unfinished run is left"
    );
}

/// A generation of this population takes many seconds: it is interrupted, and the state before it
/// is saved.
#[test]
fn generation_of_huge_population_is_interruptible() {
    let folder = folder();
    let mut child = ebts(
        folder.path(),
        "evolve --population 10000 --islands 100 --agents 4 --engine scalar --threads 1 --out huge.toml",
    )
    .stderr(Stdio::null())
    .spawn()
    .expect("ebts starts");
    std::thread::sleep(Duration::from_millis(500));
    interrupt(child.id());
    assert_eq!(child.wait().expect("a child").code(), Some(5));
    let left = std::fs::read_dir(folder.path()).expect("a folder").count();
    assert_eq!(left, 0, "nothing was evaluated, so nothing is saved");
}

#[test]
fn interrupted_run_gives_the_same_table() {
    const EVOLVE: &str = "evolve --preset N --agents 4 --seed 11 --generations 3000 --islands 2";
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{EVOLVE} --out straight.toml"));
    let mut child = ebts(folder, &format!("{EVOLVE} --out cut.toml"))
        .stderr(Stdio::null())
        .spawn()
        .expect("ebts starts");
    std::thread::sleep(Duration::from_millis(150));
    interrupt(child.id());
    if child.wait().expect("a child").code() == Some(5) {
        assert!(!folder.join("cut.toml").exists(), "no table before the end");
        refused(folder, &format!("{EVOLVE} --out cut.toml"), 7);
        run(folder, "evolve --out cut.toml --resume");
    }
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    assert_eq!(table("cut.toml"), table("straight.toml"));
    assert!(!folder.join("cut.toml.checkpoint").exists());
    assert!(refused(folder, &format!("{EVOLVE} --out cut.toml"), 7).contains("exists already"));
}

/// A damaged checkpoint is reported and kept, and its run restarts: in an experiment and in a
/// search, which has no progress bar for runs.
#[test]
fn damaged_checkpoint_is_reported_and_kept() {
    const SEARCH: &str = "search --preset N --vary goal_radius_px=50,60 --candidates 2 --best 1 \
                          --seeds 1 --verdict-seeds 1 --generations 5";
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out straight"));
    for (command, under_way, seed) in [
        (SMALL, "cut/under-way", 1),
        (
            SEARCH,
            "cut-too/stage-1/candidate-0000/under-way",
            1_000_001,
        ),
    ] {
        let (out, _) = under_way.split_once('/').expect("a folder");
        let checkpoint = format!("{under_way}/4-{seed}.checkpoint");
        std::fs::create_dir_all(folder.join(under_way)).expect("a folder");
        std::fs::write(folder.join(&checkpoint), "half of i").expect("a writable file");
        let message = output(folder, &format!("{command} --out {out}"));
        assert!(message.status.success(), "{message:?}");
        let message = String::from_utf8_lossy(&message.stderr);
        let expected =
            format!("4 agents, seed {seed}: restarted because {checkpoint} is damaged (");
        assert!(message.contains(&expected), "{message}");
        let kept = std::fs::read_to_string(folder.join(format!("{checkpoint}.damaged")));
        assert_eq!(kept.expect("the file is kept"), "half of i");
        assert!(
            message.contains(&format!("{checkpoint}.damaged")),
            "{message}"
        );
    }
    assert_eq!(results(folder, "cut"), results(folder, "straight"));

    std::fs::write(folder.join("mine.toml.checkpoint"), "half of i").expect("a writable file");
    let message = refused(folder, "evolve --out mine.toml --resume", 7);
    assert!(
        message.contains("mine.toml.checkpoint: it is damaged"),
        "{message}"
    );
    run(folder, "evolve --out mine.toml --overwrite --generations 3");
}

pub(super) fn interrupt(process: u32) {
    let status = Command::new("kill")
        .args(["-INT", &process.to_string()])
        .status();
    assert!(status.is_ok(), "the kill program runs");
}

/// A file size limit simulates a full disk: writing fails half-way.
#[test]
fn full_disk_keeps_finished_runs() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out straight"));
    let limited = format!(
        "trap '' XFSZ; ulimit -f 2; exec {} {SMALL} --threads 1 --out full",
        env!("CARGO_BIN_EXE_ebts")
    );
    let output = Command::new("bash")
        .current_dir(folder)
        .args(["-c", &limited])
        .output()
        .expect("bash starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("free disk space, then run the same command again"),
        "{message}"
    );
    let kept = std::fs::read_to_string(folder.join("full/runs.jsonl")).expect("runs");
    assert!(
        kept.ends_with('\n') && kept.lines().count() >= 1,
        "complete lines: {kept:?}"
    );
    run(folder, &format!("{SMALL} --out full"));
    let after = std::fs::read_to_string(folder.join("full/runs.jsonl")).expect("runs");
    assert!(after.starts_with(&kept), "finished runs stay");
    assert_eq!(results(folder, "full"), results(folder, "straight"));
}

#[test]
fn folder_rejects_other_experiment_and_second_process() {
    let folder = folder();
    let folder = folder.path();
    run(folder, &format!("{SMALL} --out here"));
    let message = refused(
        folder,
        "experiment fig14 --preset N --seeds 3 --generations 41 --out here",
        7,
    );
    assert!(
        message.contains("its generations is 40, needs 41"),
        "{message}"
    );
    let lock = std::fs::File::open(folder.join("here/.lock")).expect("the lock file");
    lock.try_lock().expect("a free lock");
    assert!(
        refused(folder, &format!("{SMALL} --out here"), 8).contains("another ebts process uses it")
    );
    drop(lock);
    run(folder, &format!("{SMALL} --out here"));
    std::fs::write(folder.join("here/runs.jsonl"), "not a run\n").expect("a writable file");
    assert!(refused(folder, &format!("{SMALL} --out here"), 7).contains("line 1 is damaged"));
}
