//! Transfer to unseen trials, and presets with noise and drawn trials.

use super::*;

const DRAWN: &str =
    "base = \"R3\"\ntraining = { draws = 2 }\nnoise = { sensor_flips_per_1024 = 5 }\n";

#[test]
fn transfer_of_drawn_trials_is_reported() {
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("drawn.toml"), DRAWN).expect("a writable file");
    let small = "experiment fig14 --preset drawn.toml --agents 2,4 --seeds 3 --generations 30";
    run(folder, &format!("{small} --out here"));
    run(
        folder,
        &format!("{small} --out there --threads 1 --engine portable"),
    );
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("runs");
    assert_eq!(read("here/runs.csv"), read("there/runs.csv"));
    run(folder, &format!("{small} --out here")); // reads and verifies the runs
    let transferred = json(folder, "transfer here --format json");
    let fields = ["preset", "fitness_rule", "training", "unseen_sets", "teams"];
    assert_eq!(keys(&transferred), BTreeSet::from(fields));
    assert_eq!(transferred["training"]["draws"], 2);
    let teams = transferred["teams"].as_array().expect("a list");
    assert_eq!(teams.len(), 2);
    let fields = [
        "agents", "tables", "training", "preset", "goals", "starts", "both", "kept",
    ];
    assert_eq!(keys(&teams[0]), BTreeSet::from(fields));
    let kept = |team: &Value, end: &str| team["kept"][end].as_f64().expect("a number");
    let one = json(folder, "transfer here/best-2.toml --format json");
    for team in teams.iter().chain([&one["teams"][0]]) {
        let [low, value, high] = ["low", "value", "high"].map(|end| kept(team, end));
        assert!(0.0 < low && low <= value && value <= high, "{team}");
    }
    assert!(run(folder, "show here/best-2.toml").contains("repeats to the bit"));
    run(folder, "replay here/best-2.toml");
    run(folder, "plot here/best-2.toml");
    run(folder, "find here");
}

#[test]
fn interrupted_drawn_run_gives_the_same_table() {
    const EVOLVE: &str =
        "evolve --preset drawn.toml --agents 3 --seed 4 --generations 400 --threads 1";
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("drawn.toml"), DRAWN).expect("a writable file");
    run(folder, &format!("{EVOLVE} --out straight.toml"));
    let mut child = ebts(folder, &format!("{EVOLVE} --out cut.toml"))
        .stderr(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("ebts starts");
    std::thread::sleep(Duration::from_millis(200));
    interruption::interrupt(child.id());
    if child.wait().expect("a child").code() == Some(5) {
        run(folder, "evolve --out cut.toml --resume");
    }
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    assert_eq!(table("cut.toml"), table("straight.toml"));
}
