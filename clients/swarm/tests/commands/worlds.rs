//! Walls, posts and custom fitness weights: from a preset file to tables, figures and errors.

use super::*;

const MAZE: &str = r#"
base = "N"
name = "maze"
walls = [{ from_px = [-150, 130], to_px = [150, 130] }, { from_px = [-150, -130], to_px = [150.5, -130] }]
posts = [{ at_px = [130, 60], radius_px = 15 }]
drawn_posts = { count = 3, radius_px = 20, seed = 1 }
fitness = { delivered = 60, each_companion = -5, accuracy = 1, efficiency = 2 }
"#;
const RULE: &str = "weighted (60 delivered + -5 each_companion + 1 accuracy + 2 efficiency)";

#[test]
fn maze_with_custom_weights_is_evolved_and_shown() {
    let folder = folder();
    let folder = folder.path();
    std::fs::write(folder.join("maze.toml"), MAZE).expect("a writable file");
    let whole = run(folder, "preset maze.toml");
    std::fs::write(folder.join("whole.toml"), &whole).expect("a writable file");
    assert_eq!(run(folder, "preset whole.toml"), whole);

    let evolve = "evolve --preset maze.toml --agents 3 --generations 40";
    let message = run(folder, &format!("{evolve} --out here.toml"));
    assert!(message.contains(RULE), "{message}");
    run(
        folder,
        &format!("{evolve} --out there.toml --threads 1 --engine scalar"),
    );
    let read = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a file");
    assert_eq!(read("here.toml"), read("there.toml"));

    let message = run(folder, "show here.toml");
    assert!(
        message.contains(RULE) && message.contains("repeats to the bit"),
        "{message}"
    );
    run(folder, "transfer here.toml");
    run(folder, "plot here.toml");
    run(folder, "replay here.toml");
    let page = read("here.html");
    assert!(
        page.contains(r#""to_px":[150.5,-130.0]"#),
        "no wall in the page"
    );
    assert_eq!(page.matches("\"at_px\":[").count(), 4, "posts in the page");
    let other = run(
        folder,
        "evolve --preset maze.toml --fitness compared --generations 2 --out other.toml",
    );
    assert!(other.contains("by the rule compared"), "{other}");
}

#[test]
fn invalid_field_error_lists_all_faults() {
    let folder = folder();
    let folder = folder.path();
    let rows: [(&str, &[&str]); 5] = [
        (
            "walls = [{ from_px = [-250, 200], to_px = [-150, 200] }, { from_px = [nan, 0], to_px = [0, 900] }]\n\
             posts = [{ at_px = [250, 0], radius_px = 20 }]",
            &[
                "wall 1 to the start of agent 1 was 0, needs",
                "from_px of wall 2 was NaN, needs",
                "to_px of wall 2 was 900, needs",
                "post 1 to goal 1 was -20, needs",
                "correct those values",
            ],
        ),
        (
            "fitness = { delivered = 2000 }",
            &["fitness.delivered was 2000", "correct that value"],
        ),
        ("fitness = {}", &["a weight above 0"]),
        ("fitness = { luck = 1 }", &["unknown field `luck`"]),
        (
            "walls = [{ from_px = [0], to_px = [0, 100] }]",
            &["invalid length"],
        ),
    ];
    for (keys, expected) in rows {
        std::fs::write(folder.join("bad.toml"), format!("base = \"N\"\n{keys}\n")).expect("a file");
        let message = refused(folder, "preset bad.toml", 7);
        for expected in expected {
            assert!(
                message.contains(expected),
                "{message:?} does not contain {expected:?}"
            );
        }
    }
}
