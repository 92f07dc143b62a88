//! Help text on the JSON output of every command. A test compares it with the actual output.

use clap::{Command, CommandFactory};

use super::Arguments;

const SUMMARY: &str = "{preset, fitness_rule, seeds, generations, wall_s, cpu_s, conditions: [{agents, q1, median, q3, mean}], \
                       p_order: {three_gt_four, two_gt_four, three_gt_two, multi_ge_5x_single}}";
const FINDINGS: &str = "{preset, fitness_rule, ratio, order, single, redundancy}";

fn fields(words: &str) -> Option<String> {
    let fields = match words {
        "evolve" => {
            "{table, agents, seed, generations, fitness_rule, fitness, points, rises: [{generation, fitness}], hash, wall_s}"
        }
        "evolve grasp" => {
            "{table, seed, generations, fitness, points, grasps_simulated, hash, wall_s}"
        }
        "evolve course" => {
            "{table, seed, generations, fitness, points, held_out, groups_driven, hash, wall_s}"
        }
        "experiment" | "merge" => SUMMARY,
        "experiment grasp" => {
            "{table, tables_success_median, tables_success_best, again, tables, with_module_3, rules, modules, without, \
             slip_reactive, fixed_force, seeds, members, members_from, generations, wall_s}; with --shard the number of its runs"
        }
        "sweep" => return Some(format!("a list of {{folder, …}}, each with {SUMMARY}")),
        "search" => {
            "{preset, find, stages: [{number, candidates, first_seed, seeds}], verdict_first_seed, verdict_seeds, best: [{file, \
             folder, changes, preset, tuning, verdict, all_hold}], together: [{one, other, show_one, show_other, show_both}]}"
        }
        "slurm" => "{scripts, runs}",
        "agreement" => {
            "{pairs, agree, share, first_seed, seeds, verdicts, rules: [{rule, share}], objects, differ: [{object, seed, rule, full, reduced}], \
             wall_s}"
        }
        "analyse" => {
            return Some(format!(
                "{{findings: {FINDINGS}, comparisons: [{{agents, evolved_median, baselines, held_out}}]}}"
            ));
        }
        "transfer" => {
            "{preset, fitness_rule, training, unseen_sets, teams: [{agents, tables, training, preset, goals, starts, both, kept}]}"
        }
        "compare" => {
            return Some(format!(
                "a list of {{findings, …}}, findings as {FINDINGS}, the others as {SUMMARY}"
            ));
        }
        "export" => "{file, trials}",
        "find" => {
            "a list of {case, trials, examples: [{agents, seed, goal, points, delivered, reached_frame, distance_px, each}]}"
        }
        "preset" => {
            "a list of {name, fitness_rule, preset}; with NAME the keys of one preset, as its file has them"
        }
        "plot" => "{figures, behaviour: [{frame, agent, sensors, behaviour}]}",
        "show" => {
            "{agents, preset, fitness_rule, seed, generations, edited, hash, fitness, points, fitness_repeats, held_out: {training, \
             goals, starts, goals_and_starts}, tables: [[{sensors, motors, behaviour, read}]]}; of a grasp table {seed, \
             generations, fitness, points, hash, rows_read, again}; of a course's table {seed, generations, fitness, points, \
             held_out, hash, rows: [{sensors, wheels, behaviour, read}]}"
        }
        "agents" => {
            "one object per line: {event: ready or exchanged, hash, tables}, {event: refused, why}, {event: ended, answered, lost, \
             malformed}"
        }
        "replay" => "{page}",
        "completions" => "not used: a script of the shell",
        "man" => "{folder}",
        _ => return None,
    };
    Some(fields.to_owned())
}

/// Returns the command line; every help ends with the JSON fields.
pub(crate) fn command() -> Command {
    with_fields(Arguments::command(), "")
}

fn with_fields(mut command: Command, words: &str) -> Command {
    let names: Vec<String> = command
        .get_subcommands()
        .map(|sub| sub.get_name().to_owned())
        .collect();
    for name in names {
        let words = format!("{words} {name}");
        command = command.mut_subcommand(name, |sub| with_fields(sub, words.trim()));
    }
    let Some(fields) = fields(words) else {
        return command;
    };
    let before = command
        .get_after_help()
        .map_or_else(String::new, |text| format!("{text}\n\n"));
    command.after_help(format!(
        "{before}With --format json: {fields}. An error is one object on standard error: {{error, exit}}."
    ))
}
