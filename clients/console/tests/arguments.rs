//! Command-line tests: accepted and rejected lines, with error messages.

use std::time::Duration;

use atas_console::arguments::{Arguments, Command, Demo, Eval, Place};
use clap::{CommandFactory, Parser};

fn parse(line: &str) -> Result<Command, String> {
    Arguments::try_parse_from(line.split_whitespace())
        .map(|arguments| arguments.command)
        .map_err(|error| error.to_string())
}

#[test]
fn command_definition_is_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn valid_lines_are_accepted() {
    let check = |line: &str| {
        if let Err(message) = parse(line) {
            panic!("{line}: {message}");
        }
    };
    check("atas demo grasp");
    check("atas doctor --fix --dry-run --bus left-arm");
    check("atas demo grasp --object bottle --seed 7 --lockstep");
    check("atas demo grasp --all --realtime --format json");
    check("atas demo grasp --vary --seed 3");
    check("atas demo screw --dashboard");
    check("atas demo pick-place");
    check("atas demo pick-place --object sponge --seed 7 --vary --lockstep");
    check("atas demo screw --realtime --format json");
    check("atas demo assembly --cap mine.toml --lockstep");
    check("atas demo swarm");
    check("atas demo swarm --table mine.toml --frame-rate-hz 60 --replay page.html");
    check("atas demo swarm --lockstep --format json");
    check("atas eval grasp --seeds 100 --noise 2 --rate-hz 100 --threads 2");
    check("atas eval grasp --objects wood,sponge,./mine.toml");
    check("atas eval pick-place --trials 20 --no-baselines --format json");
    check("atas eval screw --first-seed 10001 --fixed-force 3");
    check("atas eval assembly --noise 1.5");
    check("atas eval grasp --shard 2/8 --out two.part");
    check("atas eval merge one.part two.part --rows all.csv");
    check("atas calibrate guide --normal 0.5,1 --tangential -1,1 --seconds 2 --out steps.csv");
    check(
        "atas calibrate fit --presses p.csv --reference s.csv --model resultant --out tip.toml --figure tip.svg",
    );
    check("atas eval recording basic.csv --labels label --cross-validate --format json");
    check(
        "atas eval recording a.csv --labels l --positive 3,10 --negative 4 --train b.csv --save m.toml",
    );
    check("atas plot grasp --out grasp.svg");
    check("atas plot run.mcap --out run.png");
    check("atas plot grasp --out GRASP.SVG");
    check("atas plot run.mcap other.mcap --from lift --out both.pdf");
    check("atas plot screw --object ./cap.toml --seed 7 --out screw.svg");
    check("atas grasp --at 0.32,-0.15,0.04 --width 50");
    check("atas grasp --at -0.1,0.2,0.1 --yaw -30 --width 50 --hand left --lift 20 --hold 2");
    check("atas grasp --at 0.3,0,0.1 --width 50 --attached --timeout 30 --bus left-arm");
    check("atas pick-place");
    check("atas pick-place --from 0.32,-0.15 --to 0.32,-0.27");
    check(
        "atas pick-place --from 0.3,-0.1,0.04 --to -0.1,0.2,0.06 --width 40 --yaw -30 --to-yaw 90 --lift 20 --hand left",
    );
    check("atas screw");
    check(
        "atas screw --at 0.34,-0.12,0.12 --width 30 --yaw 80 --turn anticlockwise --hand left --timeout 60",
    );
    check("atas assemble");
    check(
        "atas assemble --cap 0.32,-0.18,0.05 --cap-width 28 --on 0.38,0,0.12 --bottle-width 60 --hand right --attached",
    );
    check("atas task polish");
    check(
        "atas task polish --from 0.32,-0.15 --to 0.3,-0.2 --width 40 --lift 5 --hold 2 --turn clockwise --helper-width 60",
    );
    check("atas release --hand right");
    check("atas stop");
    check("atas estop --bus b");
    check("atas recover");
    check("atas zero --hand left --bus b");
    check("atas status --watch --format json");
    check("atas events --follow");
    check("atas events --count 3");
    check("atas param list");
    check("atas param get grasp.dr_n");
    check("atas param set grasp.dr_n 0.08");
    check("atas export run.mcap run-001.mcap --to mcap --pictures-hz 30");
    check("atas export run.mcap --to csv --elements --out x.csv");
    check("atas dashboard --bus b --port 0 --robot mine.urdf");
    check("atas dashboard --recording run.mcap run-001.mcap");
    check("atas foxglove --port 0 --robot mine.toml --bus b");
    check("atas top --bus b");
    check("atas topic list");
    check("atas topic echo status --count 3");
    check("atas topic hz view --seconds 0.5");
    check("atas explain run.mcap run-001.mcap");
    check("atas explain run.mcap --out why.pdf");
    check("atas explain last --bus b");
    check("atas completions bash");
    check("atas man pages");
}

#[test]
fn invalid_lines_are_rejected() {
    let check = |line: &str, part: &str| {
        let message = parse(line).expect_err(line);
        assert!(message.contains(part), "{line}: {message}");
    };
    check("atas", "Usage");
    check("atas fly", "unrecognized subcommand");
    check("atas demo grasp --all --object wood", "cannot be used with");
    check("atas demo grasp --all --dashboard", "cannot be used with");
    check(
        "atas eval screw --seeds 2 --trials 3",
        "cannot be used with",
    );
    check(
        "atas demo grasp --lockstep --realtime",
        "cannot be used with",
    );
    check("atas demo grasp --seed=-1", "invalid digit");
    check("atas eval grasp --seeds 0", "0 is not in 1..");
    check("atas eval grasp --rate-hz 1001", "1001 is not in 1..");
    check("atas eval grasp --noise nan", "needs a finite number");
    check("atas grasp --width 50", "--at");
    check("atas grasp --at 0.3,0.1 --width 50", "X,Y,Z");
    check("atas grasp --at 0.3,0.1,0.1,0 --width 50", "X,Y,Z");
    check("atas grasp --at 0.3,inf,0.1 --width 50", "X,Y,Z");
    check(
        "atas grasp --at 0.3,0.1,0.1 --width NaN",
        "needs a finite number",
    );
    check(
        "atas grasp --at 0.3,0.1,0.1 --width 5 --hand third",
        "left, right",
    );
    check("atas grasp --at 0.3,0.1,0.1 --width 0.05", "0.05 m is 50.0");
    check("atas grasp --at 320,-150,34 --width 50", "320 mm is 0.32");
    check("atas screw --at 0.3,-150", "-150 mm is -0.15");
    check("atas pick-place --from 0.3", "X,Y or X,Y,Z");
    check("atas pick-place --to 0.3,0.1,0.1,0.1", "X,Y or X,Y,Z");
    check("atas pick-place --to 0.3,inf", "X,Y or X,Y,Z");
    check("atas pick-place --lift NaN", "needs a finite number");
    check("atas screw --turn left", "clockwise, anticlockwise");
    check("atas screw --at 0.3,0.1 --hand both", "left, right");
    check("atas assemble --bottle-width wide", "needs a finite number");
    check("atas task", "<NAME>");
    check(
        "atas task a-name-that-is-longer-than-the-bus-can-carry",
        "needs at most 32",
    );
    check("atas demo screw --object wood", "unexpected argument");
    check(
        "atas demo assembly --lockstep --realtime",
        "cannot be used with",
    );
    check("atas release --timeout=-1", "above zero");
    check("atas release --timeout 1e30", "above zero");
    check("atas status --bus Not/A/Bus", "use 1 to 24 characters");
    check("atas param set grasp.dr_n inf", "needs a finite number");
    check("atas export run.mcap", "--to");
    check("atas export run.mcap --to xls", "mcap, csv, parquet");
    check(
        "atas export run.mcap --to mcap --pictures-hz 0",
        "above zero",
    );
    check("atas plot", "<RECORDING>");
    check("atas plot run.mcap", "--out");
    check("atas plot run.mcap --out run.gif", ".svg, .png, .pdf");
    check("atas calibrate guide --out steps.toml", ".csv");
    check("atas calibrate fit --presses p.csv --out tip.json", ".toml");
    check(
        "atas calibrate fit --presses p.csv --out tip.toml --daemon tip.json",
        ".toml",
    );
    check("atas eval recording a.csv --save m.json", ".toml");
    check("atas topic echo", "<SERVICE>");
    check("atas topic hz view --seconds 0", "above zero");
    check("atas status --format xml", "human, json");
}

#[test]
fn values_and_defaults_are_parsed() {
    match parse("atas grasp --at 0.32,-0.15,0.04 --width 50 --timeout 2.5") {
        Ok(Command::Grasp(grasp)) => {
            assert_eq!(grasp.at, [0.32, -0.15, 0.04]);
            assert_eq!((grasp.yaw, grasp.width), (90.0, 50.0));
            assert_eq!((grasp.lift, grasp.hold), (40.0, 1.0));
            assert!(!grasp.sending.attached);
            assert_eq!(grasp.sending.timeout, Some(Duration::from_millis(2500)));
        }
        other => panic!("{other:?}"),
    }
    match parse("atas pick-place --from 0.3,-0.1 --to 0.3,-0.2,0.05") {
        Ok(Command::PickPlace(goal)) => {
            let height_m = |place: Option<Place>| place.map(|place| place.or_height(0.04)[2]);
            assert_eq!(
                (height_m(goal.from), height_m(goal.to)),
                (Some(0.04), Some(0.05))
            );
            assert_eq!((goal.yaw, goal.width, goal.lift), (None, None, 40.0));
        }
        other => panic!("{other:?}"),
    }
    match parse("atas eval grasp") {
        Ok(Command::Eval {
            task: Eval::Grasp(eval),
        }) => {
            assert_eq!(
                (eval.trials, eval.seeds, eval.first_seed),
                (200, None, None)
            );
            assert_eq!(
                (eval.noise, eval.rate_hz, eval.fixed_force),
                (None, None, None)
            );
            assert!(eval.objects.is_empty() && eval.threads == 0 && !eval.no_baselines);
        }
        other => panic!("{other:?}"),
    }
    match parse("atas demo grasp") {
        Ok(Command::Demo {
            task: Demo::Grasp(demo),
        }) => assert_eq!((demo.object.as_str(), demo.running.seed), ("wood", 1)),
        other => panic!("{other:?}"),
    }
}

#[test]
fn export_suffix_must_match_kind() {
    let file = |line: &str| match parse(&format!("atas export runs/run.mcap {line}")) {
        Ok(Command::Export(export)) => export.file(),
        other => panic!("{line}: {other:?}"),
    };
    let made = |line: &str, expected: &str| assert_eq!(file(line), Ok(expected.into()), "{line}");
    made("--to mcap", "runs/run-ros2.mcap");
    made("--to csv", "runs/run.csv");
    made("--to parquet", "runs/run.parquet");
    made("--to csv --out x.csv", "x.csv");
    made("--to csv --out x.CSV", "x.CSV");
    let refused = |line: &str, parts: [&str; 3]| {
        let sentence = file(line).expect_err(line);
        for part in parts {
            assert!(sentence.contains(part), "{line}: {part}: {sentence}");
        }
    };
    refused(
        "--to csv --out x.parquet",
        ["means parquet", "--to is csv", "use --to parquet"],
    );
    refused(
        "--to parquet --out x.csv",
        ["means csv", "--to is parquet", "use --to csv"],
    );
    refused(
        "--to mcap --out x.CSV",
        ["means csv", "--to is mcap", "ends in .mcap"],
    );
    refused(
        "--to csv --out x",
        ["means an unknown file type", "--to is csv", "rename it"],
    );
}

#[test]
fn help_lists_simulator_scene_defaults() {
    let check = |command: &str, parts: &[&str]| {
        let help = parse(&format!("atas {command} --help")).expect_err(command);
        for part in parts {
            assert!(help.contains(part), "{command}: {part:?} in {help}");
        }
    };
    check(
        "pick-place",
        &[
            "--scene pick-place",
            "close at 0.32,-0.15,0.0445",
            "let go at 0.32,-0.27,0.0445",
        ],
    );
    check(
        "screw",
        &["--scene screw", "close at 0.34,-0.12,0.1200", "on 30 mm"],
    );
    check(
        "assemble",
        &[
            "--scene assembly",
            "yaw 60°",
            "let go at 0.38,0.00,0.1200",
            "bottle is 60 mm wide",
        ],
    );
    check("task", &["--scene pick-place"]);
}
