//! Searches: output, determinism and resumption.

use super::*;

const SEARCH: &str = "search --preset N --vary goal_radius_px=50.0..70.0 --candidates 4 --best 1 \
                      --seeds 1 --verdict-seeds 2 --generations 20 --format json";

#[test]
fn search_output_is_documented_and_deterministic() {
    let folder = folder();
    let folder = folder.path();
    let searched = json(folder, &format!("{SEARCH} --out here"));
    let fields = [
        "preset",
        "find",
        "stages",
        "verdict_first_seed",
        "verdict_seeds",
        "best",
        "together",
    ];
    assert_eq!(keys(&searched), BTreeSet::from(fields));
    let best = &searched["best"][0];
    let fields = [
        "file", "folder", "changes", "preset", "tuning", "verdict", "all_hold",
    ];
    assert_eq!(keys(best), BTreeSet::from(fields));
    assert_eq!(best["verdict"]["claims"].as_array().map(Vec::len), Some(5));
    assert_eq!(searched["together"].as_array().map(Vec::len), Some(10));
    let (file, verdict) = (&best["file"], &best["folder"]);
    let file = file.as_str().expect("a path");
    assert_eq!(
        json(folder, &format!("preset {file} --format json")),
        best["preset"]
    );
    let verdict = verdict.as_str().expect("a path");
    assert!(run(folder, &format!("analyse {verdict} --random-tables 1")).contains("8 runs"));

    let again = json(folder, &format!("{SEARCH} --out here --threads 1"));
    assert_eq!(again, searched, "continued");
}

#[test]
fn interrupted_search_gives_the_same_result() {
    let folder = folder();
    let folder = folder.path();
    let mut child = ebts(folder, &format!("{SEARCH} --out here --threads 1"))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("ebts starts");
    let second = folder.join("here/stage-1/candidate-0001/runs.jsonl");
    while !second.exists() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(2));
    }
    interruption::interrupt(child.id());
    let code = child.wait().expect("a child").code();
    assert!(matches!(code, Some(5 | 0)), "{code:?}");
    let resumed = json(folder, &format!("{SEARCH} --out here"));
    std::fs::rename(folder.join("here"), folder.join("cut")).expect("a folder");
    assert_eq!(resumed, json(folder, &format!("{SEARCH} --out here")));
}
