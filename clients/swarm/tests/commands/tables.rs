//! Table files and evaluations of experiments.

use super::*;

#[test]
fn table_is_shown_plotted_replayed_and_edited() {
    let folder = folder();
    let folder = folder.path();
    run(
        folder,
        "evolve --agents 2 --generations 60 --seed 2 --out t.toml",
    );
    let shown = json(folder, "show t.toml --format json");
    assert_eq!(
        (&shown["fitness_repeats"], &shown["edited"]),
        (&Value::from(true), &Value::from(false))
    );
    assert_eq!(shown["tables"][0].as_array().map(Vec::len), Some(32));
    assert!(run(folder, "show t.toml").contains("Go straight"));
    assert!(run(folder, "plot t.toml --goal 3").contains("  250      2"));
    for file in ["t.trajectories.svg", "t.behaviour-3.svg"] {
        assert!(
            std::fs::read_to_string(folder.join(file))
                .expect("a figure")
                .starts_with("<svg")
        );
    }
    run(folder, "replay t.toml");
    let page = std::fs::read_to_string(folder.join("t.html")).expect("a page");
    assert!(
        page.contains("\"trials\":[{") && !page.contains("/*DATA*/"),
        "the page contains the data"
    );
    assert!(!page.contains("http"), "the page is self-contained");

    let text = std::fs::read_to_string(folder.join("t.toml")).expect("a table");
    let edited: String = text
        .lines()
        .map(|line| {
            if line.contains("\"00011 ") {
                "\"00011 11 11\",\n".to_owned()
            } else {
                format!("{line}\n")
            }
        })
        .collect();
    std::fs::write(folder.join("t.toml"), edited).expect("a writable file");
    for command in ["show", "plot", "replay"] {
        assert!(
            refused(folder, &format!("{command} t.toml"), 7).contains("--rehash"),
            "{command}"
        );
    }
    run(folder, "show t.toml --rehash");
    let shown = json(folder, "show t.toml --format json");
    assert_eq!(
        (&shown["fitness_repeats"], &shown["edited"]),
        (&Value::from(true), &Value::from(true))
    );
}

#[test]
fn export_find_compare_and_sweep_work() {
    let folder = folder();
    let folder = folder.path();
    run(
        folder,
        "experiment fig14 --preset LB --seeds 4 --generations 60 --agents 4 --out here",
    );
    let exported = json(folder, "export here --format json");
    assert_eq!(exported["trials"], 32);
    let csv = std::fs::read_to_string(folder.join("here/trials.csv")).expect("trials");
    assert!(
        csv.starts_with("agents,seed,goal,points,delivered,"),
        "{csv}"
    );
    assert_eq!(csv.lines().count(), 33);
    let found = json(folder, "find here --format json");
    let delivered = csv.lines().filter(|line| line.contains(",true,")).count();
    let examples: u64 = found
        .as_array()
        .expect("cases")
        .iter()
        .filter_map(|c| c["trials"].as_u64())
        .sum();
    assert!(examples as usize <= delivered, "{found}");
    let compared = run(folder, "compare here here");
    assert!(compared.contains("| LB, anti-accident, 4 |"), "{compared}");
    assert!(
        compared.contains("not run"),
        "findings need other team sizes: {compared}"
    );

    let swept = json(
        folder,
        "sweep --preset LB --vary goal_radius_px=20,40 --vary friction_per_stall_force=0.9 --agents 2 --seeds 2 \
         --generations 20 --out s --format json",
    );
    assert_eq!(swept.as_array().map(Vec::len), Some(2));
    for combination in swept.as_array().expect("combinations") {
        let place = combination["folder"].as_str().expect("a folder");
        assert!(folder.join(place).join("summary.json").exists(), "{place}");
    }
    run(
        folder,
        "evolve --preset LB3 --fitness compared --generations 5 --out t.toml --history h.csv",
    );
    let history = std::fs::read_to_string(folder.join("h.csv")).expect("a history");
    assert!(
        history.starts_with("generation,best,mean,worst,diversity\n0,"),
        "{history}"
    );
    assert_eq!(history.lines().count(), 7);
    assert_eq!(
        json(folder, "show t.toml --format json")["fitness_rule"],
        "compared"
    );
}
