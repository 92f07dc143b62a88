//! Walls and posts: impassable, detected by IR sensors, transparent to lights.

use field::{Goals, Model, Point, Pose, Post, Preset, Responses, TeamSize, TrialRun, Wall, Wheels};

/// Distance from a point to a wall or, if both ends are equal, to a point.
fn distance_px(at: Point, [from, to]: [[f32; 2]; 2]) -> f64 {
    let [x, y] = [at.x_px, at.y_px].map(f64::from);
    let [[fx, fy], [tx, ty]] = [from, to].map(|end| end.map(f64::from));
    let (dx, dy) = (tx - fx, ty - fy);
    let part = ((x - fx) * dx + (y - fy) * dy) / (dx * dx + dy * dy).max(1e-9);
    let part = part.clamp(0.0, 1.0);
    (fx + part * dx - x).hypot(fy + part * dy - y)
}

/// Largest penetration of an obstacle.
fn depth_px(model: &Model, at: Point, radius_px: f32) -> f64 {
    let wall = |wall: &Wall| distance_px(at, [wall.from_px, wall.to_px]);
    let post = |post: &Post| distance_px(at, [post.at_px; 2]) - f64::from(post.radius_px);
    let (walls, posts) = (
        model.walls().iter().map(wall),
        model.posts().iter().map(post),
    );
    f64::from(radius_px) - walls.chain(posts).fold(f64::INFINITY, f64::min)
}

/// Square pen with posts at a corner and inside.
fn pen(preset: Preset, half: f32) -> Preset {
    let corners = [[-half, -half], [half, -half], [half, half], [-half, half]];
    let side = |k: usize| Wall {
        from_px: corners[k],
        to_px: corners[(k + 1) % 4],
    };
    let post = |k: usize| Post {
        at_px: corners[k].map(|v| 0.95 * v),
        radius_px: 8.0,
    };
    Preset {
        walls: (0..4).map(side).collect(),
        posts: vec![
            Post {
                at_px: [0.0, 0.62 * half],
                radius_px: 6.0,
            },
            post(0),
        ]
        .into(),
        goals: Goals::CirclePx(20.0),
        ..preset
    }
}

#[test]
fn bodies_stay_in_the_pen_outside_obstacles() {
    let slow = Preset {
        agent_radius_px: 30.0,
        starts: field::Starts {
            distance_px: 150.0,
            ..Preset::N.starts
        },
        medium_speed_px_per_frame: 14.0,
        ..Preset::N
    };
    let blocking = Preset {
        contact: field::Contact::Blocking,
        ..slow.clone()
    };
    let mut state = 1_u64;
    let mut word = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        u128::from(state >> 32)
    };
    for preset in [pen(slow, 200.0), pen(blocking, 200.0)] {
        let (agent_px, object_px) = (preset.agent_radius_px, preset.object_radius_px);
        let model = Model::new(preset).expect("a pen");
        let (mut touched, mut moved) = (0, 0);
        for trial in 0..200 {
            let team = TeamSize::ALL[trial % 4];
            let tables = [(); 4].map(|()| {
                let bits = (0..4).fold(0, |bits, _| bits << 32 | word());
                Responses::from_motor_bits(bits)
            });
            let layout = model.training_layout(model.training_goals()[trial % 8]);
            let mut run = TrialRun::new(&model, team, &layout);
            while !run.is_over() {
                let rows = run.sense();
                run.advance(&std::array::from_fn(|i| tables[i].get(rows[i])));
                let world = run.world();
                let object = world.object();
                assert!(depth_px(&model, object, object_px) < 0.02, "{object:?}");
                assert!(object.x_px.abs() < 200.0 && object.y_px.abs() < 200.0);
                for pose in world.agents() {
                    let at = Point {
                        x_px: pose.x_px,
                        y_px: pose.y_px,
                    };
                    let depth_px = depth_px(&model, at, agent_px);
                    assert!(depth_px < 0.02, "{pose:?} is {depth_px} px inside");
                    assert!(at.x_px.abs() < 200.0 && at.y_px.abs() < 200.0, "{pose:?}");
                    touched += usize::from(depth_px > -0.02);
                }
                moved += usize::from(object != Point::default());
            }
        }
        assert!(
            touched > 1000 && moved > 1000,
            "{touched} {moved}: too few contacts or motions"
        );
    }
}

/// An IR sensor detects a wall or post exactly if its range ends behind it.
#[test]
fn ir_sensors_detect_walls_and_posts() {
    let preset = Preset {
        walls: vec![Wall {
            from_px: [300.0, -300.0],
            to_px: [300.0, 300.0],
        }]
        .into(),
        posts: vec![Post {
            at_px: [-300.0, 0.0],
            radius_px: 20.0,
        }]
        .into(),
        goals: Goals::CirclePx(100.0),
        ir_angle_steps: 8,
        ir_range_px: 60.0,
        object_light_px: 0.0,
        goal_light_px: 0.0,
        ..Preset::N
    };
    let model = Model::new(preset).expect("valid");
    // x, y, heading, row: 1 left, 2 front, 4 right
    let rows = [
        (230.0, 0.0, 0, 0), // nothing within 70 px
        (241.0, 0.0, 0, 2), // straight ahead
        (270.0, 0.0, 0, 7), // all three
        (270.0, 0.0, 8, 2 + 4),
        (270.0, 0.0, 56, 1 + 2),
        (270.0, 0.0, 32, 0),   // behind the agent
        (330.0, 0.0, 32, 7),   // from the other side
        (300.0, 330.0, 32, 0), // along its end
        (-200.0, 0.0, 32, 0),
        (-239.0, 0.0, 32, 2), // the post
        (-255.0, 0.0, 40, 4),
        (-255.0, 0.0, 24, 1),
    ];
    for (x_px, y_px, heading, expected) in rows {
        let corner = |x_px, y_px| Pose {
            x_px,
            y_px,
            heading: 0,
        };
        let starts = [
            Pose {
                x_px,
                y_px,
                heading,
            },
            corner(-100.0, -100.0),
            corner(-100.0, 100.0),
            corner(100.0, -100.0),
        ];
        let layout = model
            .layout(starts, model.training_goals()[0])
            .expect("free");
        let mut run = TrialRun::new(&model, TeamSize::ALL[0], &layout);
        assert_eq!(
            run.sense()[0],
            expected,
            "from {x_px} {y_px} towards {heading}"
        );
    }
}

/// Driving straight at a wall stops in contact; at an angle the agent slides along it.
#[test]
fn agents_stop_at_or_slide_along_walls() {
    let preset = Preset {
        walls: vec![Wall {
            from_px: [120.0, -390.0],
            to_px: [120.0, 390.0],
        }]
        .into(),
        goals: Goals::CirclePx(50.0),
        starts: field::Starts {
            distance_px: 200.0,
            ..Preset::N.starts
        },
        ..Preset::N
    };
    let model = Model::new(preset).expect("valid");
    for (heading, leads) in [(32, false), (34, true), (22, true)] {
        let mut starts = *model.training_layout(model.training_goals()[0]).starts();
        starts[0].x_px = 250.0;
        starts[0].y_px = 0.0;
        starts[0].heading = heading;
        let layout = model
            .layout(starts, model.training_goals()[0])
            .expect("free");
        let mut run = TrialRun::new(&model, TeamSize::ALL[0], &layout);
        let ahead = Wheels { left: 1, right: 1 };
        for _ in 0..60 {
            run.sense();
            run.advance(&[ahead; 4]);
        }
        let Pose { x_px, y_px, .. } = run.world().agents()[0];
        assert!((x_px - 145.0).abs() < 0.02, "in contact: {x_px}");
        assert_eq!(y_px.abs() > 30.0, leads, "{heading}: {y_px}");
    }
}
