//! Tests of Methodology 2 (swarm) on the bus: the field in one process, its agents in another.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use ebts::condition::{Setup, Sharing};
use ebts::ga::Settings;
use ebts::islands::IslandSettings;
use ebts::run::{Run, evolve};
use ebts::sensors::SensorOrder;
use ebts::table_file::TableFile;
use field::{
    Engine, FitnessRule, MAX_AGENTS, Outcome, Preset, Responses, TRIAL_FRAMES, Trial, run_trial,
};
use rustix::process::Signal;
use shm_bus::{Bus, FreshBus, Realtime, Subscriber};
use shm_schemas::{AgentSensors, ArenaTruth, WheelCommands, service};
use sim_backend::swarm::TrialReport;
use system_tests::{Process, wait_for};
use tempfile::TempDir;

/// Evolves a table for 60 generations, so that the agents move.
fn evolved(preset: Preset, agents: usize, sharing: Sharing, seed: u64) -> TableFile {
    let setup = Setup {
        agents,
        sharing,
        sensors: SensorOrder::default(),
        fitness_rule: FitnessRule::default_for(&preset).into(),
        preset,
    };
    let condition = setup.build().expect("a valid setup");
    let (settings, islands) = (Settings::default(), IslandSettings::default());
    let run = Run::new(&condition, settings, islands, seed).expect("valid settings");
    let (mut runs, generations) = ([run], 60);
    let go_on = |_: &[Run]| ControlFlow::Continue(());
    let flow = evolve(&condition, Engine::fastest(), &mut runs, generations, go_on);
    assert!(flow.is_continue());
    let record = runs[0].record(&condition).expect("an evolved run");
    TableFile::from_record(&condition, &record, generations).expect("a record of this condition")
}

fn write_table(folder: &TempDir, name: &str, file: &TableFile) -> PathBuf {
    let path = folder.path().join(name);
    file.write(&path).expect("writable");
    path
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn start_agents(bus: &FreshBus, tables: &[&Path]) -> Process {
    let mut arguments = vec!["agents", "--bus", bus.as_str()];
    for table in tables {
        arguments.extend(["--table", text(table)]);
    }
    Process::start("ebts", &arguments)
}

fn start_field(bus: &FreshBus, arguments: &str) -> Process {
    let mut words = vec!["field", "--bus", bus.as_str(), "--format", "json"];
    words.extend(arguments.split_whitespace());
    Process::start("atas-sim", &words)
}

/// Returns the field process's trial reports so far.
fn reports(host: &Process) -> Vec<TrialReport> {
    let log = host.log();
    let lines = log.lines().filter(|line| line.starts_with('{'));
    lines
        .filter_map(|line| serde_json::from_str(line).ok())
        .collect()
}

fn finished(mut host: Process) -> Vec<TrialReport> {
    assert!(host.wait().success(), "{}", host.log());
    reports(&host)
}

/// Runs the training trials of a team in process.
fn in_process(file: &TableFile, tables: [Responses; MAX_AGENTS]) -> Vec<Outcome> {
    let condition = &file.condition;
    let trial = |layout| run_trial(&condition.model, condition.team, &Trial { layout, tables });
    condition.layouts().into_iter().map(trial).collect()
}

#[test]
fn lockstep_bus_equals_in_process_field() {
    let rows = [
        (Preset::R3, 1, Sharing::Shared),
        (Preset::R3, 2, Sharing::PerAgent),
        (Preset::R3, 3, Sharing::Shared),
        (Preset::R3, 4, Sharing::Shared),
        (Preset::N, 2, Sharing::Shared),
        (Preset::N, 3, Sharing::PerAgent),
        (Preset::LB, 4, Sharing::Shared),
        (Preset::LB2, 4, Sharing::PerAgent),
        (Preset::PAPER, 3, Sharing::Shared),
    ];
    for (seed, (preset, team, sharing)) in (1..).zip(rows) {
        let what = format!("{} {team} {sharing:?}", preset.name);
        let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
        let file = evolved(preset.clone(), team, sharing, seed);
        let _agents = start_agents(&bus, &[&write_table(&folder, "table.toml", &file)]);
        let field = format!("--lockstep --preset {} --agents {team}", preset.name);
        let trials = finished(start_field(&bus, &field));
        let responses = file.condition.responses(&file.individual.genome);
        let outcomes: Vec<Outcome> = trials.iter().map(|trial| trial.outcomes[0]).collect();
        assert_eq!(outcomes, in_process(&file, responses), "{what}");
        let points: Vec<f32> = trials.iter().map(|trial| trial.points[0]).collect();
        assert_eq!(
            points, file.individual.points,
            "{what}: the points of the evolution"
        );
        for trial in &trials {
            assert_eq!(
                (trial.missed_frames, trial.refused_frames),
                (0, 0),
                "{what}"
            );
            assert_eq!(trial.tables, [file.hash()[..16].to_owned()], "{what}");
        }
    }
}

#[test]
fn each_agent_of_each_field_has_own_table() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let files = [5, 6].map(|seed| evolved(Preset::R3, 2, Sharing::Shared, seed));
    let paths = [
        write_table(&folder, "a.toml", &files[0]),
        write_table(&folder, "b.toml", &files[1]),
    ];
    let _agents = start_agents(&bus, &[&paths[0], &paths[1]]);
    let trials = finished(start_field(
        &bus,
        "--lockstep --agents 2 --fields 3 --goal 8",
    ));
    let condition = &files[0].condition;
    let [a, b] = files
        .each_ref()
        .map(|file| condition.responses(&file.individual.genome)[0]);
    let tables = [a, b, a, b];
    let expected = [56, 57, 58].map(|direction| {
        let layout = condition
            .model
            .training_layout(condition.model.goal_towards(direction));
        run_trial(&condition.model, condition.team, &Trial { layout, tables })
    });
    assert_eq!(trials[0].outcomes, expected);
}

/// Observers at different rates: two poll continuously, one never reads.
#[test]
fn observers_do_not_affect_the_field() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::LB2, 3, Sharing::Shared, 9);
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let open = || observer.subscriber::<ArenaTruth>(service::ARENA_TRUTH);
    let (mut first, mut second, _idle) = (open(), open(), open().expect("a place"));
    let mut arena = Box::<ArenaTruth>::default();
    let field = start_field(&bus, "--lockstep --preset LB2 --agents 3");
    let waiting = first.as_mut().expect("a place");
    wait_for("the field that waits", || {
        waiting.newest(&mut arena).expect("readable").then_some(())
    });
    assert_eq!((arena.frame, arena.trial_count, arena.is_driven), (0, 8, 0));
    let _agents = start_agents(&bus, &[&write_table(&folder, "table.toml", &file)]);
    let mut seen = 0;
    wait_for("the end of the last trial", || {
        for onlooker in [&mut first, &mut second] {
            let onlooker = onlooker.as_mut().expect("a place");
            seen += usize::from(onlooker.newest(&mut arena).expect("readable"));
        }
        ((arena.trial, arena.frame) == (7, TRIAL_FRAMES.into())).then_some(())
    });
    assert!(seen > 0);
    let trials = finished(field);
    let points: Vec<f32> = trials.iter().map(|trial| trial.points[0]).collect();
    assert_eq!(
        points, file.individual.points,
        "the points of the evolution"
    );
    let shown: Vec<f32> = arena.trials.iter().map(|trial| trial.points).collect();
    assert_eq!(shown, points, "the points on the bus");
    let distances = |of: &TrialReport| of.outcomes[0].evaluated.goal_px;
    let output: Vec<f32> = arena.trials.iter().map(|trial| trial.distance_px).collect();
    assert_eq!(output, trials.iter().map(distances).collect::<Vec<f32>>());
}

/// Waits for a payload newer than the last one.
fn newest<T: shm_schemas::Payload + Default>(stream: &mut Subscriber<T>) -> T {
    let mut payload = T::default();
    wait_for("a payload", || {
        stream.newest(&mut payload).expect("readable").then_some(())
    });
    payload
}

#[test]
fn valid_tables_replace_running_ones_malformed_never() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let [first, second] = [1, 2].map(|seed| evolved(Preset::R3, 2, Sharing::Shared, seed));
    let hash = |file: &TableFile| u64::from_str_radix(&file.hash()[..16], 16).expect("a hash");
    let path = write_table(&folder, "table.toml", &first);
    let agents = start_agents(&bus, &[&path]);
    let _field = start_field(&bus, "--frame-rate-hz 500 --trials 1000");
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let mut commands = observer
        .subscriber::<WheelCommands>(service::WHEEL_COMMANDS)
        .expect("a subscriber");
    assert_eq!(newest(&mut commands).table_hash, hash(&first));

    let intact = second.to_text();
    let edited = intact.replacen("00000 ", "00000  ", 1).replacen(
        "fitness_rule = \"anti-accident\"",
        "fitness_rule = \"literal\"",
        1,
    );
    let elsewhere = evolved(Preset::N, 2, Sharing::Shared, 2).to_text();
    let half = &intact[..intact.len() / 2];
    let spoilt = ["", "no table", half, &edited, &elsewhere];
    for (count, text) in (1..).zip(spoilt) {
        std::fs::write(&path, text).expect("writable");
        agents.signal(Signal::HUP);
        let refusals = || agents.log().matches("the current ones stay in use").count();
        wait_for("a refusal", || (refusals() == count).then_some(()));
        let before = newest(&mut commands).stamp.sequence;
        wait_for("frames after it", || {
            let command = newest(&mut commands);
            assert_eq!(command.table_hash, hash(&first), "after {text:.20?}");
            (command.stamp.sequence > before + 5).then_some(())
        });
    }

    std::fs::write(&path, intact).expect("writable");
    agents.signal(Signal::HUP);
    wait_for("the second table", || {
        (newest(&mut commands).table_hash == hash(&second)).then_some(())
    });
}

/// Agents do not run tables of another field unless the user permits it.
#[test]
fn tables_of_another_field_are_rejected() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::R3, 2, Sharing::Shared, 4);
    let path = write_table(&folder, "table.toml", &file);
    let field = start_field(&bus, "--lockstep --preset LB --goal 1");
    let mut refused = start_agents(&bus, &[&path]);
    assert_eq!(refused.wait().code(), Some(7), "{}", refused.log());
    let message = refused.log();
    assert!(
        message.contains("their field is LB, needs the field of the tables, R3"),
        "{message}"
    );
    assert!(reports(&field).is_empty(), "no agent moved");
    let arguments = [
        "agents",
        "--any-field",
        "--bus",
        bus.as_str(),
        "--table",
        text(&path),
    ];
    let _driving = Process::start("ebts", &arguments);
    assert_eq!(finished(field).len(), 1);
}

#[test]
fn agents_stop_after_kill_and_resume_with_next() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::R3, 2, Sharing::Shared, 3);
    let path = write_table(&folder, "table.toml", &file);
    let mut killed = start_agents(&bus, &[&path]);
    let field = start_field(&bus, "--frame-rate-hz 300 --goal 1 --trials 5");
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let mut sensors = observer
        .subscriber::<AgentSensors>(service::AGENT_SENSORS)
        .expect("a subscriber");
    let mut commands = observer
        .subscriber::<WheelCommands>(service::WHEEL_COMMANDS)
        .expect("a subscriber");
    wait_for("robots at work", || {
        (newest(&mut sensors).frame >= 30).then_some(())
    });
    killed.signal(Signal::KILL);
    killed.wait();
    let last = newest(&mut commands);

    // Without answers, agents stop: from the second frame on, the sensor rows do not change.
    let (output, mut standing) = (last.trial as usize, None);
    wait_for("the end of a trial without an answer", || {
        let now = newest(&mut sensors);
        if (now.trial, now.frame) > (last.trial, last.frame) && now.trial == last.trial {
            assert_eq!(
                *standing.get_or_insert(now.row),
                now.row,
                "frame {}",
                now.frame
            );
        }
        (reports(&field).len() >= output + 2).then_some(())
    });
    assert!(standing.is_some(), "stopped agents were observed");
    let _next = start_agents(&bus, &[&path]);
    let trials = finished(field);
    let untold = &trials[output + 1];
    assert_eq!(untold.missed_frames, TRIAL_FRAMES);
    assert_eq!(untold.outcomes[0].executed, untold.outcomes[0].evaluated);
    assert!(untold.tables.is_empty(), "no table was reported");
    let again = trials.last().expect("five trials");
    assert!(
        again.missed_frames < TRIAL_FRAMES,
        "the next process answers frames"
    );
}
