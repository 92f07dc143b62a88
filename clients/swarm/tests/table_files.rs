//! Table files: intact files round-trip, damaged files are rejected.

use std::ops::ControlFlow;

use ebts::condition::{Condition, Setup, Sharing};
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::run::{Run, evolve};
use ebts::sensors::SensorOrder;
use ebts::table_file::{Hash, TableFile};
use field::{Engine, FitnessRule, Preset};

fn table_file(sharing: Sharing) -> TableFile {
    let setup = Setup {
        agents: 2,
        sharing,
        sensors: SensorOrder::default(),
        fitness_rule: FitnessRule::AntiAccident.into(),
        preset: Preset::R3,
    };
    let condition: Condition = setup.build().expect("a valid setup");
    let run = Run::new(
        &condition,
        Settings::default(),
        IslandSettings::default(),
        7,
    )
    .expect("valid settings");
    let mut runs = [run];
    assert!(
        evolve(&condition, Engine::fastest(), &mut runs, 30, |_| {
            ControlFlow::Continue(())
        })
        .is_continue()
    );
    let record = runs[0].record(&condition).expect("an evolved run");
    let file = TableFile::from_record(&condition, &record, 30).expect("a record of this condition");
    TableFile {
        code_version: "0.1.0".to_owned(),
        ..file
    }
}

#[test]
fn file_round_trips_without_comments_and_reordered() {
    for sharing in [Sharing::Shared, Sharing::PerAgent] {
        let file = table_file(sharing);
        let text = file.to_text();
        let read = TableFile::parse(&text, Hash::Required).expect("an intact file");
        assert_eq!(read.to_text(), text);
        assert_eq!(read.individual, file.individual);
        let mut lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        let first_row = lines
            .iter()
            .position(|line| line.contains("\"00000 "))
            .expect("the first row");
        lines.swap(first_row, first_row + 5);
        let shuffled = TableFile::parse(&lines.join("\n"), Hash::Required).expect("the same rows");
        assert_eq!(shuffled.individual, file.individual);
    }
}

#[test]
fn layout_matches_golden_file() {
    let text = table_file(Sharing::Shared).to_text();
    let golden = include_str!("golden/table.toml");
    assert_eq!(
        text, golden,
        "after an intended change of the layout, change its version and this golden file"
    );
    TableFile::parse(golden, Hash::Required).expect("files of this version stay readable");
}

#[test]
fn truncated_file_is_rejected() {
    let text = table_file(Sharing::Shared).to_text();
    let end = text.trim_end().len();
    for cut in (0..end).filter(|&cut| text.is_char_boundary(cut)) {
        assert!(
            TableFile::parse(&text[..cut], Hash::Required).is_err(),
            "cut at byte {cut}"
        );
    }
}

#[test]
fn errors_name_the_damage() {
    let text = table_file(Sharing::Shared).to_text();
    let row = text
        .lines()
        .find(|line| line.contains("\"00000 "))
        .expect("the first row")
        .to_owned();
    let spoil = |from: &str, to: &str| text.replacen(from, to, 1);
    let output = &row[row.find(' ').map_or(0, |_| 11)..16];
    let flipped = if output.starts_with("00") { "01" } else { "00" };
    let rows = [
        (spoil("ebts-table-1", "ebts-table-2"), "format is"),
        (
            spoil("agents = 2", "agents = 5"),
            "could not place 5 agents",
        ),
        (
            spoil("agents = 2", "agents = 2\nspeed = 3"),
            "unknown field",
        ),
        (
            spoil("agent_radius_px = 40.0", "agent_radius_px = nan"),
            "agent_radius_px was NaN",
        ),
        (
            spoil(
                "medium_speed_px_per_frame = 6.0",
                "medium_speed_px_per_frame = 1e9",
            ),
            "medium_speed_px_per_frame was 1000000000",
        ),
        (
            spoil("points = [", "points = [nan, "),
            "it is not a table file",
        ),
        (spoil(&row, ""), "a table has 31 rows"),
        (spoil(&row, &row.replace("00000", "00001")), "is duplicated"),
        (
            spoil(&row, &row.replace("00000", "0000x")),
            "does not have the form",
        ),
        (
            spoil(&row, &row.replace("00000", "000000")),
            "does not have the form",
        ),
        (
            spoil(
                &row,
                &row.replacen(
                    &format!("00000 {}", &output[..2]),
                    &format!("00000 {flipped}"),
                    1,
                ),
            ),
            "integrity.sha256 is",
        ),
        (spoil("seed = 7", "seed = 8"), "integrity.sha256 is"),
        (spoil("seed = 7", "seed = -7"), "it is not a table file"),
        (spoil("sha256 = \"", "sha256 = \"0"), "integrity.sha256 is"),
        (spoil("[integrity]", "[integrityx]"), "unknown field"),
        (String::new(), "it is not a table file"),
        ("\u{0}\u{1}garbage".to_owned(), "it is not a table file"),
    ];
    for (text, expected) in rows {
        let why = TableFile::parse(&text, Hash::Required).expect_err(expected);
        assert!(
            why.contains(expected),
            "{why:?} does not contain {expected:?}"
        );
    }
}
