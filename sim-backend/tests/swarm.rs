//! Swarm fields without a bus: rejected settings, and robots with missing or malformed commands.

use field::{
    DrawnPosts, Model, Noise, Outcome, Preset, Responses, TRIAL_FRAMES, TeamSize, Trial, Wall,
    Wheels, run_trial,
};
use shm_schemas::{AgentSensors, ArenaTruth, WheelCommands};
use sim_backend::swarm::{FrameCommands, Swarm, SwarmError, SwarmSettings, TrialReport};

fn settings(agents: usize, fields: usize, goals: &[u8]) -> SwarmSettings {
    SwarmSettings {
        model: Model::new(Preset::N).expect("valid preset"),
        team: TeamSize::new(agents).expect("1 to 4 robots"),
        fields,
        goals: goals.to_vec(),
    }
}

fn swarm(agents: usize, fields: usize, goals: &[u8]) -> Swarm {
    Swarm::new(settings(agents, fields, goals)).expect("valid settings")
}

/// Motor bits of a table that drives ahead and turns on a sensor contact.
fn output(row: u32) -> u32 {
    [0b1111, 0b0101, 0b1101, 0b0111][(row % 4) as usize]
}

fn answer(sensors: &AgentSensors) -> WheelCommands {
    let mut commands = WheelCommands {
        agent_count: sensors.agent_count,
        table_hash: 7,
        ..WheelCommands::default()
    };
    for (bits, row) in commands.output.iter_mut().zip(sensors.row) {
        *bits = output(row);
    }
    commands
}

/// Runs one trial; `spoil` may change every command.
fn trial(swarm: &mut Swarm, spoil: impl Fn(&mut WheelCommands)) -> TrialReport {
    let mut sensors = AgentSensors::default();
    loop {
        swarm.sense(&mut sensors);
        let mut commands = answer(&sensors);
        spoil(&mut commands);
        if let Some(report) = swarm.advance(FrameCommands::Commands(&commands)) {
            return report;
        }
    }
}

/// Observers receive walls and posts, and robots on the bus collide with them as in the field
/// alone.
#[test]
fn observers_receive_walls_and_posts() {
    let walled = Preset {
        walls: vec![Wall {
            from_px: [-100.0, 120.0],
            to_px: [100.0, 120.5],
        }]
        .into(),
        drawn_posts: Some(DrawnPosts {
            count: 2,
            radius_px: 15.0,
            seed: 3,
        }),
        ..Preset::N
    };
    let model = Model::new(walled).expect("valid preset");
    let settings = SwarmSettings {
        model: model.clone(),
        ..settings(3, 1, &[3])
    };
    let mut swarm = Swarm::new(settings).expect("valid settings");
    let mut arena = Box::<ArenaTruth>::default();
    swarm.show(FrameCommands::Missing, &mut arena);
    assert_eq!((arena.wall_count, arena.post_count), (1, 2));
    assert_eq!(arena.walls[0].to_px, [100.0, 120.5]);
    for (shown, post) in arena.posts.iter().zip(model.posts()) {
        assert_eq!((shown.at_px, shown.radius_px), (post.at_px, post.radius_px));
    }
    let table = Responses::from_fn(|row| Wheels::from_motor_bits(output(row as u32)));
    let alone = Trial {
        layout: model.training_layout(model.training_goals()[2]),
        tables: [table; 4],
    };
    let team = TeamSize::new(3).expect("team of three");
    let report = trial(&mut swarm, |_| ());
    assert_eq!(report.outcomes, [run_trial(&model, team, &alone)]);
}

#[test]
fn parallel_fields_equal_single_field_trials() {
    for noise in [0, 100] {
        side_by_side(Noise {
            sensor_flips_per_1024: noise,
            wheel_slips_per_1024: noise,
        });
    }
}

fn side_by_side(noise: Noise) {
    let noisy = Preset { noise, ..Preset::N };
    let model = Model::new(noisy).expect("valid model");
    let settings = SwarmSettings {
        model: model.clone(),
        ..settings(3, 5, &[1, 7])
    };
    let team = settings.team;
    let mut swarm = Swarm::new(settings).expect("valid settings");
    let table = Responses::from_fn(|row| Wheels::from_motor_bits(output(row as u32)));
    for (goal, first) in [(1, 0), (7, 48)] {
        let report = trial(&mut swarm, |_| ());
        let expected: Vec<Outcome> = (first..first + 5)
            .map(|direction| model.training_layout(model.goal_towards(direction)))
            .map(|layout| {
                run_trial(
                    &model,
                    team,
                    &Trial {
                        layout,
                        tables: [table; 4],
                    },
                )
            })
            .collect();
        assert_eq!((report.goal, report.outcomes), (goal, expected));
        assert_eq!(report.tables, ["0000000000000007"]);
    }
    assert!(swarm.is_over());
    let nothing = swarm.advance(FrameCommands::Missing);
    assert_eq!(nothing, None, "no effect after the last trial");
}

#[test]
fn observers_receive_every_frame_without_effect() {
    let unseen = trial(&mut swarm(3, 2, &[4]), |_| ());
    let mut swarm = swarm(3, 2, &[4, 5]);
    let (mut sensors, mut arena) = (AgentSensors::default(), Box::<ArenaTruth>::default());
    let mut before = None;
    let report = loop {
        swarm.sense(&mut sensors);
        let commands = answer(&sensors);
        let answer = FrameCommands::Commands(&commands);
        swarm.show(answer, &mut arena);
        assert_eq!(
            (arena.frame, arena.trial, arena.goal),
            (sensors.frame, 0, 4)
        );
        assert_eq!(
            (arena.agent_count, arena.field_count, arena.is_driven),
            (6, 2, 1)
        );
        for (agent, truth) in arena.agents[..6].iter().enumerate() {
            assert_eq!(
                (truth.row, truth.output),
                (sensors.row[agent], commands.output[agent])
            );
        }
        // A wheel level turns a robot by at most two steps: motion is shown without jumps.
        let headings = [0, 1, 2, 3, 4, 5].map(|agent: usize| arena.agents[agent].heading_steps);
        for (now, then) in headings.iter().zip(before.unwrap_or(headings)) {
            assert!((now + 64 - then + 2) % 64 <= 4, "frame {}", arena.frame);
        }
        before = Some(headings);
        if let Some(report) = swarm.advance(answer) {
            break report;
        }
    };
    assert_eq!(report, unseen);
    // The result stays until the next trial's first frame is sensed.
    swarm.show(FrameCommands::Missing, &mut arena);
    assert_eq!((arena.frame, arena.trial), (TRIAL_FRAMES.into(), 0));
    for (field, shown) in arena.fields[..2].iter().enumerate() {
        let outcome = &report.outcomes[field];
        assert_eq!(shown.distance_px, outcome.evaluated.goal_px);
        assert_eq!(shown.reached_frame, outcome.reached_frame);
        assert_eq!(shown.points, report.points[field]);
        assert_eq!(shown.e1_points, 1000.0 / shown.distance_px.max(10.0));
    }
    assert!(arena.agents[..6].iter().all(|agent| agent.output == 0));
    let past = arena.trials[0];
    assert_eq!((past.goal, past.points), (4, report.points[0]));
    assert_eq!(arena.trials[1].goal, 0, "no other trial is complete");
    swarm.sense(&mut sensors);
    swarm.show(FrameCommands::Missing, &mut arena);
    assert_eq!(
        (arena.frame, arena.trial, arena.goal, arena.is_driven),
        (0, 1, 5, 0)
    );
}

#[test]
fn malformed_commands_stop_the_robots() {
    type Spoil = fn(&mut WheelCommands);
    let spoils: [Spoil; 3] = [
        |commands| commands.agent_count += 1,
        |commands| commands.agent_count = u32::MAX,
        |commands| commands.output[1] = 16,
    ];
    for spoil in spoils {
        let report = trial(&mut swarm(2, 1, &[3]), spoil);
        assert_eq!(
            (report.missed_frames, report.refused_frames),
            (0, TRIAL_FRAMES)
        );
        assert_eq!(report.outcomes[0].executed, report.outcomes[0].evaluated);
        assert!(report.tables.is_empty());
    }
}

#[test]
fn invalid_settings_are_rejected() {
    let check = |agents, fields, goals: &[u8], expected| {
        let refused = Swarm::new(settings(agents, fields, goals)).err();
        assert_eq!(refused, expected, "{agents} {fields} {goals:?}");
    };
    let robots = |fields, team| Some(SwarmError::Robots { fields, team });
    check(4, 256, &[1], None);
    check(4, 257, &[1], robots(257, 4));
    check(1, 0, &[1], robots(0, 1));
    check(3, usize::MAX, &[1], robots(usize::MAX, 3));
    check(2, 1, &[1, 0], Some(SwarmError::Goal(0)));
    check(2, 1, &[9], Some(SwarmError::Goal(9)));
}
