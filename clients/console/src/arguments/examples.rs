//! Examples and JSON output of each command, at the end of its `--help`. A test parses every
//! example.

use clap::CommandFactory;

use super::Arguments;

/// One command: its words, examples, and JSON output.
struct Help(&'static str, &'static [&'static str], &'static str);

/// JSON of a finished goal.
const GOAL: &str = "one object at the end: goal_id, state, step, reason, figures";
/// JSON of an answered request.
const ANSWER: &str = "one object: op, outcome";
/// JSON of an evaluation report.
const REPORT: &str = "one object: success, ci95, failures, medians, families, rows, baselines, …";
/// JSON of a demo table.
const ROWS: &str = "one object: as_expected, and one row per object";

/// JSON of a command group.
const SUBCOMMANDS: &str = "see `--help` of each subcommand";

/// All commands; the program itself has the empty name.
const HELPS: &[Help] = &[
    Help(
        "",
        &[
            "atas demo grasp",
            "atas grasp --at 0.32,-0.15,0.0345 --width 50",
            "atas status --watch",
            "atas estop",
            "atas explain last",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "demo",
        &[
            "atas demo grasp --object sponge --dashboard",
            "atas demo assembly --lockstep",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "eval",
        &[
            "atas eval grasp --trials 50 --no-baselines",
            "atas eval all --markdown",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "topic",
        &["atas topic list", "atas topic echo status --count 1"],
        SUBCOMMANDS,
    ),
    Help(
        "param",
        &["atas param list", "atas param set grasp.dr_n 0.02"],
        SUBCOMMANDS,
    ),
    Help(
        "robot",
        &[
            "atas robot list",
            "atas robot check my_arm.toml --out my_arm.svg",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "calibrate",
        &[
            "atas calibrate guide --out steps.csv",
            "atas calibrate fit --presses presses.csv --reference steps.csv --out tip.toml",
            "atas calibrate model presses.csv --reading b1,b2,b3 --force force_n",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "bench",
        &["atas bench latency --short", "atas bench stop"],
        SUBCOMMANDS,
    ),
    Help(
        "demo grasp",
        &[
            "atas demo grasp --object sponge",
            "atas demo grasp --robot test-bench",
            "atas demo grasp --dashboard",
            "atas demo grasp --all --lockstep",
        ],
        ROWS,
    ),
    Help(
        "demo pick-place",
        &["atas demo pick-place --object sponge --vary --seed 7"],
        ROWS,
    ),
    Help("demo screw", &["atas demo screw --vary --seed 4"], ROWS),
    Help("demo assembly", &["atas demo assembly --lockstep"], ROWS),
    Help(
        "demo swarm",
        &[
            "atas demo swarm --replay swarm.html",
            "atas demo swarm --dashboard --frame-rate-hz 60",
        ],
        "one object: as_evolved, missed_frames, goals",
    ),
    Help(
        "demo hybrid",
        &["atas demo hybrid", "atas demo hybrid --robots 2 --seed 4"],
        "one object: seed, robots[{object, failure, phases[{phase, began_s, took_s}], drive, grip_n, f2_n, off_goal_m}], simulated_s",
    ),
    Help(
        "eval grasp",
        &[
            "atas eval grasp --trials 200",
            "atas eval grasp --robot arm7-gripper --trials 50 --no-baselines",
            "atas eval grasp --objects wood,sponge --noise 2",
            "atas eval grasp --errors crosstalk=3,position=5,yaw=15 --rows trials.csv",
            "atas eval grasp --errors each --trials 48 --noise 1",
        ],
        REPORT,
    ),
    Help(
        "eval pick-place",
        &["atas eval pick-place --trials 50 --no-baselines"],
        REPORT,
    ),
    Help(
        "eval screw",
        &["atas eval screw --first-seed 1 --fixed-force 3"],
        REPORT,
    ),
    Help(
        "eval assembly",
        &["atas eval assembly --trials 20 --rate-hz 100"],
        REPORT,
    ),
    Help(
        "eval all",
        &[
            "atas eval all --markdown",
            "atas eval all --trials 24 --tasks grasp,screw",
        ],
        "one object per task, as printed by `atas eval TASK`",
    ),
    Help(
        "eval errors",
        &["atas eval errors --trials 24 --tasks grasp --no-baselines"],
        "one object per task, as printed by `atas eval TASK`",
    ),
    Help(
        "eval robots",
        &["atas eval robots --trials 24 --markdown"],
        "one object per robot and task, as printed by `atas eval TASK`",
    ),
    Help(
        "eval skins",
        &["atas eval skins --trials 24 --markdown"],
        "one object per layout, as printed by `atas eval TASK`",
    ),
    Help(
        "eval sensor-effects",
        &[
            "atas eval sensor-effects",
            "atas eval sensor-effects --objects wood,sponge --seeds 2 --markdown",
        ],
        "one object: task, engine, objects, seeds, first_seed, purpose, rows{effect, torques, trials, held, crushed, dropped, slipped, not_lifted, discarded, warned}, discarded{REASON}",
    ),
    Help(
        "eval disturbances",
        &[
            "atas eval disturbances",
            "atas eval disturbances --objects wood,sponge --seeds 2 --markdown",
            "atas eval disturbances --engine mujoco --objects wood --seeds 1 --cases bump,ramp",
        ],
        "one object: task, engine, objects, seeds, first_seed, purpose, rows{case, policy, setting, trials, allowed, kept, kept_allowed, catchable, caught, crushed, dropped, put_back, not_lifted, discarded, slip_mm, slipped, answered, slip_to_command_ms, over_grip}, discarded{REASON}",
    ),
    Help(
        "eval gentleness",
        &[
            "atas eval gentleness",
            "atas eval gentleness --objects egg,brick --seeds 8 --markdown",
            "atas eval gentleness --tune",
        ],
        "one object: task, engine, seeds, first_seed, purpose, rows{object, gripper, setting, trials, held, crushed, dropped, slipped, not_lifted, discarded, peak, deformation_mm, slip_mm, lifted_s}, robustness{condition, gripper, trials, held, crushed, dropped, over_grip, over_grip_max}, discarded{REASON}",
    ),
    Help(
        "eval reflex",
        &[
            "atas eval reflex",
            "atas eval reflex --trials 40 --first-seed 1",
        ],
        "one object: with{trials, success, crushed, failures, over_grip_median}, without{…}, slip_to_command_ms{count, at_f2, unanswered, p50, p99, max, p99_with_f2}",
    ),
    Help(
        "eval calibration",
        &["atas eval calibration --trials 40"],
        "one object: trials, exact{success, ci95, failures}, fitted{…}, lost_points, only_exact, only_fitted, fit{error_share, …}",
    ),
    Help(
        "eval hybrid",
        &[
            "atas eval hybrid --robots 1 --seeds 100",
            "atas eval hybrid --seeds 20 --frozen",
        ],
        "one object: robots, trials, success, ci95, failures, failed_seeds, objects, drive{count, slip_mm, slipped, grip_change_n, shake}, simulated_s",
    ),
    Help("eval tune", &["atas eval tune grasp --trials 32"], REPORT),
    Help(
        "robot list",
        &["atas robot list"],
        "one object: robots[{name, joints, fingers, tasks}]",
    ),
    Help(
        "robot check",
        &[
            "atas robot check test-bench",
            "atas robot check my_arm.toml --out my_arm.svg",
        ],
        "one object: name, joints, fingers, tasks, hands[{side, joints[], fingertips[], home_m, home_opening_m, workspace, capabilities}]",
    ),
    Help(
        "fault",
        &[
            "atas fault list",
            "atas fault run F01 --task grasp --at lift",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "fault list",
        &["atas fault list"],
        "one object: faults[{id, name, about, reaction, shown_by}]",
    ),
    Help(
        "fault run",
        &[
            "atas fault run frames-lost",
            "atas fault run F12 --task pick-place --at lift --seed 20007",
            "atas fault run F25 F47 --task grasp",
            "atas fault run --all --seeds 2 --robot arm7-gripper",
            "atas fault run --all --config atas.toml --format json",
        ],
        "one object: faults[{id, name, seeds, passed, worst_ticks, bound_ticks, reaction, shown_by, runs, passed_runs, skipped, failures[]}], automated, unsafe_outputs, catalogue, robot, tasks",
    ),
    Help(
        "soak",
        &[
            "atas soak --ticks 5000000 --seed 7",
            "atas soak --seed 7 --episode 12 --events 0,3 --ticks 5200",
        ],
        "one object: ticks, violations, ticks_per_s, seed, episodes, failures[{command, violation}]",
    ),
    Help(
        "assure",
        &[
            "atas assure",
            "atas assure --check",
            "atas assure --run stop daemon-death",
            "atas assure --run --missing",
            "atas assure --run --scale 20 --results results",
            "atas assure --add faults.json --add soak.json",
            "atas assure --out clients/guide/src/assurance.md",
        ],
        "one object: version, is_shown, goal, extent, strategies[{id, text}], claims[{id, name, strategy, text, context, argument, assumptions[], is_shown, commands[], evidence[{evidence, title, requirement, is_shown, last{tried, passed, worst, bound, version, cores, …}}]}], not_claimed[{fault, reason}], limits[], problems[{subject, text}]",
    ),
    Help(
        "calibrate guide",
        &["atas calibrate guide --normal 0.5,1,2 --seconds 2 --out steps.csv"],
        "one object: file, steps",
    ),
    Help(
        "calibrate fit",
        &[
            "atas calibrate fit --presses presses.csv --reference steps.csv --out tip.toml --daemon tip-daemon.toml",
        ],
        "one object: calibration, model, elements, presses, ridge, error_n, error_share, thresholds, motion_at, drift: {watched_s, element_n_min, warmth: {span_k, total_n_k, element_n_k}}, block, warnings",
    ),
    Help(
        "calibrate model",
        &[
            "atas calibrate model presses.csv --reading b1,b2,b3 --force force_n --accuracy 0.3 --out my-sensor.toml",
        ],
        "one object: recording, rows, seconds, rate_hz, columns[{name, step, noise, largest, saturates}], residual_n, fitted_n, effects[{name, value, unit, without_n, identified}], accuracy_n, not_identified, model",
    ),
    Help(
        "eval merge",
        &["atas eval merge one.part two.part --rows all.csv"],
        "one object: success, ci95, failures, medians, families, rows, baselines, …",
    ),
    Help(
        "eval recording",
        &[
            "atas eval recording basic.csv --labels label --cross-validate",
            "atas eval recording mine.csv --labels label --train others.csv --save mine.toml",
            "atas eval recording run.mcap --labels label --labels-file spans.csv",
        ],
        "one object: judged, n, objects, balanced_accuracy, specificity, sensitivity, auc; mae_n; touches; warnings",
    ),
    Help(
        "plot",
        &[
            "atas plot run.mcap --out run.svg",
            "atas plot run.mcap --goal pick-place --out placing.svg",
            "atas plot monday.mcap tuesday.mcap --from lift --out both.pdf",
        ],
        "one object: file",
    ),
    Help(
        "plot grasp",
        &["atas plot grasp --object bottle --out grasp.svg"],
        "one object: file",
    ),
    Help(
        "plot pick-place",
        &["atas plot pick-place --out placing.svg"],
        "one object: file",
    ),
    Help(
        "plot screw",
        &["atas plot screw --seed 2 --out screw.svg"],
        "one object: file",
    ),
    Help(
        "plot assembly",
        &["atas plot assembly --seed 2 --out assembly.svg"],
        "one object: file",
    ),
    Help(
        "grasp",
        &[
            "atas grasp --at 0.32,-0.15,0.0345 --width 50",
            "atas grasp --at 0.32,0.15,0.0345 --width 50 --hand left --lift 20",
        ],
        GOAL,
    ),
    Help(
        "teleop",
        &[
            "atas teleop",
            "atas teleop --hand left --step 2",
            "atas teleop targets.csv",
        ],
        "one object at the end: goal_id, state, step, reason, figures, targets",
    ),
    Help(
        "pick-place",
        &[
            "atas pick-place",
            "atas pick-place --from 0.32,-0.15 --to 0.32,-0.27 --width 50",
        ],
        GOAL,
    ),
    Help(
        "screw",
        &[
            "atas screw",
            "atas screw --at 0.34,-0.12,0.12 --width 30 --turn anticlockwise",
        ],
        GOAL,
    ),
    Help(
        "assemble",
        &[
            "atas assemble",
            "atas assemble --cap 0.32,-0.18,0.05 --cap-width 30 --on 0.38,0,0.12 --bottle-width 60",
        ],
        GOAL,
    ),
    Help(
        "task",
        &["atas task polish --from 0.32,-0.15 --width 50"],
        GOAL,
    ),
    Help("release", &["atas release --hand left"], GOAL),
    Help("estop", &["atas estop", "atas stop"], ANSWER),
    Help(
        "cancel",
        &["atas cancel"],
        "one object: op, goal_id, outcome",
    ),
    Help("recover", &["atas recover"], ANSWER),
    Help("zero", &["atas zero --hand left"], ANSWER),
    Help(
        "status",
        &["atas status", "atas status --watch --bus left-arm"],
        "one object: mode, goal with its reason, hands, refusals, joints, distributions",
    ),
    Help(
        "events",
        &[
            "atas events --follow",
            "atas events --last-goal",
            "atas events --kind goal,step,warning --hand right",
        ],
        "one object per event: sequence, captured_ns, tick, kind, lost_before, and fields of its \
         kind",
    ),
    Help(
        "param list",
        &["atas param list"],
        "one object per parameter: name, value, lower, upper, meaning",
    ),
    Help(
        "param get",
        &["atas param get grasp.dr_n"],
        "one object: name, value, lower, upper, meaning",
    ),
    Help(
        "param set",
        &["atas param set grasp.dr_n 0.02"],
        "one object: name, value, lower, upper, meaning",
    ),
    Help(
        "latency",
        &["atas latency", "atas latency --watch"],
        "one object: ticks, distributions in ns, stages",
    ),
    Help(
        "bench latency",
        &["atas bench latency --short"],
        "one object: every figure of the tables; null with a reason in not_measured",
    ),
    Help(
        "bench stop",
        &["atas bench stop --count 1000"],
        "one object: stops, seen, within_3_ticks, ticks and answered_us as distributions, goals",
    ),
    Help(
        "bench restart",
        &["atas bench restart --count 1000"],
        "one object: kills, during_start, in_grip, recovered, ready_ms, force_ratio, failures",
    ),
    Help(
        "bench observers",
        &["atas bench observers --seconds 10 --repeats 5"],
        "one object: observers, body and wake with p50 and p99 (alone_us, observed_us, \
         elsewhere_us, ratio of the last two), missed_ticks",
    ),
    Help(
        "record",
        &[
            "atas record --out run.mcap --note seed=7",
            "atas record --max-size 500M --max-files 4",
        ],
        "one object: parts, lost, has_beginning, disk_budget_reached, bytes, files",
    ),
    Help(
        "record check",
        &["atas record check run.mcap"],
        "one object: messages, parts, lost, first_part, damage",
    ),
    Help(
        "record repair",
        &["atas record repair run.mcap --out whole.mcap"],
        "one object: messages, parts, lost, first_part, damage",
    ),
    Help(
        "replay",
        &["atas replay run.mcap", "atas replay run.mcap run-001.mcap"],
        "one object: ticks, different, first_tick, first_field, recorded_version, version",
    ),
    Help(
        "diff",
        &["atas diff run.mcap other.mcap"],
        "one object: equal_ticks, first_tick, first_field, last_status",
    ),
    Help(
        "explain",
        &[
            "atas explain run.mcap",
            "atas explain run.mcap --out why.png",
            "atas explain run.mcap --list",
            "atas explain run.mcap --goal -2",
            "atas explain last",
        ],
        "one object: goal, task, state, reason, took_s, steps, moments, picture; with --list goals[{goal, task, hand, from_s, took_s, state, reason}]",
    ),
    Help(
        "export",
        &[
            "atas export run.mcap --to mcap",
            "atas export run.mcap --to parquet --elements --out run.parquet",
            "atas export run-*.mcap --to lerobot --out dataset --task 'lift the box'",
        ],
        "one object: file, ticks, seconds, took_s; LeRobot: file, episodes, successes, frames, \
         skipped, took_s",
    ),
    Help(
        "dashboard",
        &[
            "atas dashboard",
            "atas dashboard --recording run.mcap --port 0",
        ],
        "one object: url, port, token; then one per change of the open pages: pages",
    ),
    Help(
        "foxglove",
        &[
            "atas foxglove",
            "atas foxglove --port 0 --bus left-arm",
            "atas foxglove --print-layout",
        ],
        "one object: url, port",
    ),
    Help(
        "top",
        &["atas top", "atas top --bus left-arm"],
        "not available: interactive screen",
    ),
    Help(
        "topic list",
        &["atas topic list"],
        "one object per service: service, payload, bytes, writers, readers, readable",
    ),
    Help(
        "topic echo",
        &["atas topic echo status --count 1", "atas topic echo view"],
        "one object per payload: sequence, captured_ns, its fields",
    ),
    Help(
        "topic hz",
        &["atas topic hz tick-report --seconds 2"],
        "one object: service, payloads, lost, rate_hz, newest_age_ns",
    ),
    Help(
        "doctor",
        &[
            "atas doctor",
            "atas doctor --bus left-arm",
            "atas doctor --fix --dry-run",
            "atas doctor --fix",
        ],
        "one list of objects: probe, verdict, found, what_to_do, cost; with --fix also fixes, a \
         list of action, result, reason, command",
    ),
    Help(
        "remote",
        &[
            "atas remote keys --out keys --host robot.lab --client alice",
            "atas remote serve --config remote.toml",
            "atas remote check --remote robot.lab:7843",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "remote serve",
        &["atas remote serve --config remote.toml"],
        "not available: log lines on standard error",
    ),
    Help(
        "remote keys",
        &[
            "atas remote keys --out keys --host robot.lab --host 192.0.2.7 --client alice",
            "atas remote keys --out keys --client display",
        ],
        "one object: files",
    ),
    Help(
        "remote check",
        &["atas remote check --remote lab --count 1000"],
        "one object: version, client, right, connect_ms, count, round_trip_ms{p50, p99, max}",
    ),
    Help(
        "recordings",
        &[
            "atas recordings list --remote lab",
            "atas recordings fetch run.mcap --remote lab",
        ],
        SUBCOMMANDS,
    ),
    Help(
        "recordings list",
        &["atas recordings list", "atas recordings list --remote lab"],
        "one object: recordings[{name, bytes, age_s}]",
    ),
    Help(
        "recordings fetch",
        &["atas recordings fetch run.mcap --remote lab --out copy.mcap"],
        "one object: file, bytes",
    ),
    Help(
        "completions",
        &["atas completions bash"],
        "not available: shell script",
    ),
    Help("man", &["atas man ./man"], "not available: files"),
];

/// Groups of commands in `atas --help`.
const GROUPS: &[(&str, &[&str])] = &[
    (
        "Demonstrate and evaluate",
        &["demo", "eval", "fault", "soak", "assure", "plot"],
    ),
    (
        "Run a task",
        &[
            "grasp",
            "pick-place",
            "screw",
            "assemble",
            "task",
            "teleop",
            "release",
        ],
    ),
    ("Stop and recover", &["estop", "cancel", "recover", "zero"]),
    (
        "Observe",
        &[
            "status",
            "top",
            "topic",
            "events",
            "latency",
            "dashboard",
            "foxglove",
        ],
    ),
    (
        "Use recordings",
        &[
            "record",
            "recordings",
            "replay",
            "diff",
            "explain",
            "export",
        ],
    ),
    (
        "Set up",
        &[
            "doctor",
            "robot",
            "calibrate",
            "param",
            "bench",
            "remote",
            "completions",
            "man",
        ],
    ),
];

/// JSON of an error, the same for every command.
const ERRORS: &str = "on error, one object on standard error: error, exit";

/// Builds the command line with examples, for programs, completions and manual pages.
#[must_use]
pub fn command() -> clap::Command {
    let command = with_examples(Arguments::command(), "");
    let groups = group_list(&command);
    command.help_template(format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{groups}Options:\n{{options}}{{after-help}}"
    ))
}

/// Lists the commands by group, each with the first clause of its description.
fn group_list(command: &clap::Command) -> String {
    let mut text = String::new();
    for (title, names) in GROUPS {
        text += &format!("{title}:\n");
        for name in *names {
            let about = command
                .find_subcommand(name)
                .and_then(clap::Command::get_about)
                .map_or_else(String::new, ToString::to_string);
            let clause = about.split([';', ':']).next().unwrap_or_default();
            text += &format!("  {name:<12} {clause}\n");
        }
        text.push('\n');
    }
    text
}

fn with_examples(mut command: clap::Command, words: &str) -> clap::Command {
    let names: Vec<String> = command
        .get_subcommands()
        .map(|sub| sub.get_name().to_owned())
        .collect();
    for name in names {
        let words = format!("{words} {name}");
        command = command.mut_subcommand(name, |sub| with_examples(sub, words.trim()));
    }
    let Some(Help(_, examples, json)) = HELPS.iter().find(|Help(of, ..)| *of == words) else {
        return command;
    };
    let before = command
        .get_after_help()
        .map_or_else(String::new, |text| format!("{text}\n\n"));
    let lines: String = examples.iter().map(|line| format!("  {line}\n")).collect();
    command.after_help(format!(
        "{before}Examples:\n{lines}\nWith --format json:\n  {json}\n  {ERRORS}"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lists a command and all its visible subcommands by their words.
    fn subcommand_paths(command: &clap::Command, words: &str) -> Vec<String> {
        let below = command.get_subcommands().filter(|sub| !sub.is_hide_set());
        let below = below.filter(|sub| sub.get_name() != "help");
        let below = below
            .flat_map(|sub| subcommand_paths(sub, format!("{words} {}", sub.get_name()).trim()));
        std::iter::once(words.to_owned()).chain(below).collect()
    }

    #[test]
    fn every_command_has_valid_examples() {
        let mut known: Vec<&str> = HELPS.iter().map(|Help(words, ..)| *words).collect();
        let mut found = subcommand_paths(&Arguments::command(), "");
        known.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, known);
        for Help(words, examples, _) in HELPS {
            assert!(!examples.is_empty(), "{words}");
            for line in *examples {
                let parsed = command().try_get_matches_from(line.split_whitespace());
                assert!(parsed.is_ok(), "{line}: {:?}", parsed.err());
                let shown = line.replacen("atas stop", "atas estop", 1);
                assert!(shown.contains(words), "{line} is not an example of {words}");
            }
        }
    }

    #[test]
    fn every_command_is_in_one_group() {
        let command = Arguments::command();
        let mut commands: Vec<&str> = command
            .get_subcommands()
            .map(clap::Command::get_name)
            .collect();
        let mut grouped: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        commands.sort_unstable();
        grouped.sort_unstable();
        assert_eq!(commands, grouped);
    }

    #[test]
    fn examples_follow_existing_help_text() {
        let mut command = command();
        let help = command
            .find_subcommand_mut("screw")
            .map(|sub| sub.render_help().to_string());
        let help = help.unwrap_or_default();
        for part in [
            "--scene screw",
            "Examples:",
            "With --format json:",
            "standard error",
        ] {
            assert!(help.contains(part), "{part}: {help}");
        }
    }
}
