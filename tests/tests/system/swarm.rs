//! Methodology 2 on the bus: the field in one process, its robots in another.

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

/// A table that has learned a little, so that something happens on the field.
fn evolved(preset: Preset, agents: usize, sharing: Sharing, seed: u64) -> TableFile {
    let setup = Setup {
        agents,
        sharing,
        sensors: SensorOrder::default(),
        fitness_rule: FitnessRule::usual(&preset).into(),
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

fn written(folder: &TempDir, name: &str, file: &TableFile) -> PathBuf {
    let path = folder.path().join(name);
    file.write(&path).expect("writable");
    path
}

fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}

fn agents(bus: &FreshBus, tables: &[&Path]) -> Process {
    let mut arguments = vec!["agents", "--bus", bus.as_str()];
    for table in tables {
        arguments.extend(["--table", text(table)]);
    }
    Process::start("ebts", &arguments)
}

fn host(bus: &FreshBus, arguments: &str) -> Process {
    let mut words = vec!["field", "--bus", bus.as_str(), "--format", "json"];
    words.extend(arguments.split_whitespace());
    Process::start("atas-sim", &words)
}

/// What the host has said of its trials so far.
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

/// The eight trials of a team in process.
fn in_process(file: &TableFile, tables: [Responses; MAX_AGENTS]) -> Vec<Outcome> {
    let condition = &file.condition;
    let trial = |layout| run_trial(&condition.model, condition.team, &Trial { layout, tables });
    condition.layouts().into_iter().map(trial).collect()
}

#[test]
fn in_lock_step_the_bus_gives_the_bits_of_the_field_in_process() {
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
        let _agents = agents(&bus, &[&written(&folder, "table.toml", &file)]);
        let field = format!("--lockstep --preset {} --agents {team}", preset.name);
        let trials = finished(host(&bus, &field));
        let responses = file.condition.responses(&file.individual.genome);
        let outcomes: Vec<Outcome> = trials.iter().map(|trial| trial.outcomes[0]).collect();
        assert_eq!(outcomes, in_process(&file, responses), "{what}");
        let points: Vec<f32> = trials.iter().map(|trial| trial.points[0]).collect();
        assert_eq!(points, file.individual.points, "{what}: what evolution saw");
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
fn every_robot_of_every_field_has_its_own_table() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let files = [5, 6].map(|seed| evolved(Preset::R3, 2, Sharing::Shared, seed));
    let paths = [
        written(&folder, "a.toml", &files[0]),
        written(&folder, "b.toml", &files[1]),
    ];
    let _agents = agents(&bus, &[&paths[0], &paths[1]]);
    let trials = finished(host(&bus, "--lockstep --agents 2 --fields 3 --goal 8"));
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

/// Onlookers of every kind of pace: two that read every frame, one that reads nothing at all.
#[test]
fn onlookers_see_the_field_to_its_last_bit_and_do_not_change_it() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::LB2, 3, Sharing::Shared, 9);
    let observer = Bus::open(&bus, "observer", Realtime::No).expect("a bus");
    let open = || observer.subscriber::<ArenaTruth>(service::ARENA_TRUTH);
    let (mut first, mut second, _idle) = (open(), open(), open().expect("a place"));
    let mut arena = Box::<ArenaTruth>::default();
    let field = host(&bus, "--lockstep --preset LB2 --agents 3");
    let waiting = first.as_mut().expect("a place");
    wait_for("the field that waits", || {
        waiting.newest(&mut arena).expect("readable").then_some(())
    });
    assert_eq!((arena.frame, arena.trial_count, arena.is_driven), (0, 8, 0));
    let _agents = agents(&bus, &[&written(&folder, "table.toml", &file)]);
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
    assert_eq!(points, file.individual.points, "what evolution saw");
    let shown: Vec<f32> = arena.trials.iter().map(|trial| trial.points).collect();
    assert_eq!(shown, points, "what onlookers were told");
    let distances = |of: &TrialReport| of.outcomes[0].evaluated.goal_px;
    let told: Vec<f32> = arena.trials.iter().map(|trial| trial.distance_px).collect();
    assert_eq!(told, trials.iter().map(distances).collect::<Vec<f32>>());
}

/// The newest payload after those that have been seen.
fn newest<T: shm_schemas::Payload + Default>(stream: &mut Subscriber<T>) -> T {
    let mut payload = T::default();
    wait_for("a payload", || {
        stream.newest(&mut payload).expect("readable").then_some(())
    });
    payload
}

#[test]
fn tables_are_exchanged_while_robots_drive_and_malformed_ones_never() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let [first, second] = [1, 2].map(|seed| evolved(Preset::R3, 2, Sharing::Shared, seed));
    let hash = |file: &TableFile| u64::from_str_radix(&file.hash()[..16], 16).expect("a hash");
    let path = written(&folder, "table.toml", &first);
    let agents = agents(&bus, &[&path]);
    let _field = host(&bus, "--frame-rate-hz 500 --trials 1000");
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
        let refusals = || {
            agents
                .log()
                .matches("the tables in use stay in use")
                .count()
        };
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

/// Robots stand still rather than to do on one field what was learned on another, unless somebody wants to see it.
#[test]
fn tables_of_another_field_are_refused() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::R3, 2, Sharing::Shared, 4);
    let path = written(&folder, "table.toml", &file);
    let field = host(&bus, "--lockstep --preset LB --goal 1");
    let mut refused = agents(&bus, &[&path]);
    assert_eq!(refused.wait().code(), Some(3), "{}", refused.log());
    let said = refused.log();
    assert!(
        said.contains("their field was LB, needs the field of the tables, R3"),
        "{said}"
    );
    assert!(reports(&field).is_empty(), "no robot moved");
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
fn robots_stop_when_their_process_is_killed_and_go_on_with_the_next() {
    let (bus, folder) = (FreshBus::new("swarm"), TempDir::new().expect("a folder"));
    let file = evolved(Preset::R3, 2, Sharing::Shared, 3);
    let path = written(&folder, "table.toml", &file);
    let mut killed = agents(&bus, &[&path]);
    let field = host(&bus, "--frame-rate-hz 300 --goal 1 --trials 5");
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

    // From the second frame after the last answered one on, everybody stands where the frame before left them.
    let (told, mut standing) = (last.trial as usize, None);
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
        (reports(&field).len() >= told + 2).then_some(())
    });
    assert!(standing.is_some(), "robots were seen standing");
    let _next = agents(&bus, &[&path]);
    let trials = finished(field);
    let untold = &trials[told + 1];
    assert_eq!(untold.missed_frames, TRIAL_FRAMES);
    assert_eq!(untold.outcomes[0].executed, untold.outcomes[0].evaluated);
    assert!(untold.tables.is_empty(), "no table was looked up");
    let again = trials.last().expect("five trials");
    assert!(
        again.missed_frames < TRIAL_FRAMES,
        "the next process answers"
    );
}
