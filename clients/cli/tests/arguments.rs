//! The command line: what is accepted, what is refused, and in which words.

use std::time::Duration;

use atas_cli::arguments::{Arguments, Command, Demo, Eval};
use clap::{CommandFactory, Parser};

fn parse(line: &str) -> Result<Command, String> {
    Arguments::try_parse_from(line.split_whitespace())
        .map(|arguments| arguments.command)
        .map_err(|error| error.to_string())
}

#[test]
fn the_table_of_commands_is_consistent() {
    Arguments::command().debug_assert();
}

#[test]
fn accepted() {
    let check = |line: &str| {
        if let Err(message) = parse(line) {
            panic!("{line}: {message}");
        }
    };
    check("atas demo grasp");
    check("atas demo grasp --object bottle --seed 7 --lockstep");
    check("atas demo grasp --all --realtime --format json");
    check("atas demo swarm");
    check("atas demo swarm --table mine.toml --frame-rate-hz 60 --replay page.html");
    check("atas demo swarm --lockstep --format json");
    check("atas eval grasp --seeds 100 --noise 2 --rate-hz 100 --threads 2");
    check("atas eval grasp --objects wood,sponge,./mine.toml");
    check("atas grasp --at 0.32,-0.15,0.04 --width 50");
    check("atas grasp --at -0.1,0.2,0.1 --yaw -30 --width 50 --hand left --lift 20 --hold 2");
    check("atas grasp --at 0.3,0,0.1 --width 50 --attached --timeout 30 --bus left-arm");
    check("atas release --hand right");
    check("atas stop");
    check("atas estop --bus b");
    check("atas recover");
    check("atas status --watch --format json");
    check("atas events --follow");
    check("atas events --count 3");
    check("atas param list");
    check("atas param get grasp.dr_n");
    check("atas param set grasp.dr_n 0.08");
    check("atas completions bash");
    check("atas man pages");
}

#[test]
fn refused() {
    let check = |line: &str, part: &str| {
        let message = parse(line).expect_err(line);
        assert!(message.contains(part), "{line}: {message}");
    };
    check("atas", "Usage");
    check("atas fly", "unrecognized subcommand");
    check("atas demo grasp --all --object wood", "cannot be used with");
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
    check("atas release --timeout=-1", "above zero");
    check("atas release --timeout 1e30", "above zero");
    check("atas status --bus Not/A/Bus", "use 1 to 24 characters");
    check("atas param set grasp.dr_n inf", "needs a finite number");
    check("atas status --format xml", "human, json");
}

#[test]
fn values_and_defaults() {
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
    match parse("atas eval grasp") {
        Ok(Command::Eval {
            task: Eval::Grasp(eval),
        }) => {
            assert_eq!((eval.seeds, eval.noise, eval.rate_hz), (20, 1.0, 1000));
            assert!(eval.objects.is_empty() && eval.threads == 0);
        }
        other => panic!("{other:?}"),
    }
    match parse("atas demo grasp") {
        Ok(Command::Demo {
            task: Demo::Grasp(demo),
        }) => assert_eq!((demo.object.as_str(), demo.seed), ("wood", 1)),
        other => panic!("{other:?}"),
    }
}
