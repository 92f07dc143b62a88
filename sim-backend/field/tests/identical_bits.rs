//! All engines give the bits of the scalar reference for any preset, team and set of trials, and
//! the recorded bits.

use field::{
    Contact, DrawnPosts, Engine, Model, Noise, Outcome, Photo, Pose, Post, Preset, Push, Responses,
    TeamSize, Trial, Wall, Wheels,
};

/// SplitMix64.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }

    fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * (self.next() >> 40) as f32 / (1 << 24) as f32
    }

    fn table(&mut self) -> Responses {
        let level = |bits: u64| (bits & 1) as u8 + (bits >> 1 & 1) as u8;
        Responses::from_fn(|_| {
            let bits = self.next();
            Wheels {
                left: level(bits),
                right: level(bits >> 2),
            }
        })
    }

    fn layout(&mut self, model: &Model) -> field::Layout {
        loop {
            let starts = [(); 4].map(|()| Pose {
                x_px: self.between(-375.0, 375.0),
                y_px: self.between(-375.0, 375.0),
                heading: self.next() as u8,
            });
            if let Ok(layout) = model.layout(starts, model.goal_towards(self.next() as u8)) {
                return layout;
            }
        }
    }
}

/// Built-in presets plus other code paths: narrow photo cones, slow sliding in a crowd, travel
/// beyond the sensing range, both contact models, rare to constant noise, obstacles.
fn presets() -> Vec<Preset> {
    let mut presets = Preset::ALL.to_vec();
    presets.push(Preset {
        photo: Photo {
            angle_steps: 5,
            half_angle_cosine: 0.6,
        },
        ..Preset::LB
    });
    presets.push(Preset {
        agent_radius_px: 60.0,
        ir_range_px: 90.0,
        contact: Contact::Sliding,
        medium_speed_px_per_frame: 9.0,
        push: Push::Fitted {
            solo: 0.02,
            team: 0.4,
        },
        half_side_px: 520.0,
        ..Preset::R3
    });
    for (contact, preset) in [
        (Contact::Sliding, Preset::N),
        (Contact::Blocking, Preset::LB),
    ] {
        presets.push(Preset {
            ir_range_px: preset.agent_radius_px,
            medium_speed_px_per_frame: 0.25 * (preset.agent_radius_px + preset.object_radius_px),
            contact,
            ..preset
        });
    }
    for (flips, slips, preset) in [
        (10, 0, Preset::R3),
        (0, 51, Preset::N),
        (300, 200, Preset::LB2),
        (1024, 1024, Preset::N3),
    ] {
        presets.push(Preset {
            noise: Noise {
                sensor_flips_per_1024: flips,
                wheel_slips_per_1024: slips,
            },
            ..preset
        });
    }
    presets.extend(walled());
    presets
}

/// Obstacles for both contact models: an acute corner, gaps narrower than bodies, touching posts,
/// random posts up to the limit.
fn walled() -> Vec<Preset> {
    let wall = |from_px, to_px| Wall { from_px, to_px };
    let post = |at_px, radius_px| Post { at_px, radius_px };
    let corner = [
        wall([-150.0, 110.0], [150.0, 110.0]),
        wall([150.0, 110.0], [40.0, 160.0]),
        wall([-150.0, -150.0], [-150.0, 70.0]),
    ];
    let gate = [
        post([140.0, -30.0], 12.0),
        post([140.0, 45.0], 18.0),
        post([0.0, -130.0], 25.0),
        post([55.0, -130.0], 30.5),
        post([-150.0, -150.0], 40.0),
    ];
    let drawn = |count, seed| {
        Some(DrawnPosts {
            count,
            radius_px: 15.0,
            seed,
        })
    };
    let around = |preset: &Preset, drawn_posts| Preset {
        name: format!("{} walled", preset.name).into(),
        walls: corner.to_vec().into(),
        posts: gate.to_vec().into(),
        drawn_posts,
        goals: field::Goals::SquarePx(290.0),
        ..preset.clone()
    };
    let noisy = Preset {
        noise: Noise {
            sensor_flips_per_1024: 30,
            wheel_slips_per_1024: 30,
        },
        ..around(&Preset::N, None)
    };
    let fast = Preset {
        medium_speed_px_per_frame: 12.0,
        push: Push::Fitted {
            solo: 1.0,
            team: 1.0,
        },
        ..around(&Preset::PAPER, drawn(8, 3))
    };
    let close = Preset {
        medium_speed_px_per_frame: 14.0,
        ..around(&Preset::LB, drawn(8, 4))
    };
    vec![
        around(&Preset::N, drawn(8, 1)),
        around(&Preset::LB2, drawn(8, 2)),
        Preset {
            walls: Vec::new().into(),
            posts: Vec::new().into(),
            ..around(&Preset::R3, drawn(16, 5))
        },
        noisy,
        fast,
        close,
    ]
}

fn trials(model: &Model, seed: u64) -> Vec<Trial> {
    let mut random = Random(seed);
    let mut trials = Vec::new();
    for round in 0..6 {
        let tables = [(); 4].map(|()| random.table());
        for goal in model.training_goals() {
            trials.push(Trial {
                layout: model.training_layout(goal),
                tables: [tables[0]; 4],
            });
        }
        for _ in 0..round {
            trials.push(Trial {
                layout: random.layout(model).with_noise(round * 77),
                tables,
            });
        }
    }
    trials
}

fn run(engine: Engine, model: &Model, team: TeamSize, trials: &[Trial]) -> Vec<Outcome> {
    let mut outcomes = vec![Outcome {
        reached_frame: 77,
        ..Outcome::default()
    }];
    engine.run(model, team, trials, &mut outcomes);
    outcomes
}

fn fingerprint(outcomes: &[Outcome]) -> u64 {
    let mut hash = Random(0);
    for outcome in outcomes {
        let distances = [outcome.executed, outcome.evaluated]
            .into_iter()
            .flat_map(|s| [s.goal_px].into_iter().chain(s.agents_px));
        for word in [outcome.rows_read, outcome.reached_frame]
            .into_iter()
            .chain(distances.map(f32::to_bits))
        {
            hash.0 ^= u64::from(word);
            hash.0 = hash.next();
        }
    }
    hash.0
}

#[test]
fn engines_match_the_scalar_reference_bit_for_bit() {
    for (seed, preset) in presets().into_iter().enumerate() {
        let model = Model::new(preset).expect("a valid preset");
        let trials = trials(&model, seed as u64);
        for team in TeamSize::ALL {
            let reference = run(Engine::all()[0], &model, team, &trials);
            for engine in Engine::all() {
                let context = format!(
                    "{} on {} with {} agents",
                    engine.name(),
                    model.preset().name,
                    team.get()
                );
                assert_eq!(run(engine, &model, team, &trials), reference, "{context}");
                for count in [0, 1, 7, 17] {
                    assert_eq!(
                        run(engine, &model, team, &trials[..count]),
                        reference[..count],
                        "{context}, {count}"
                    );
                }
                let backwards: Vec<Trial> = trials.iter().rev().copied().collect();
                let mut outcomes = run(engine, &model, team, &backwards);
                outcomes.reverse();
                assert_eq!(outcomes, reference, "{context}, backwards");
            }
        }
    }
}

/// A change of these numbers invalidates every evolved table and every figure.
#[test]
fn bits_match_the_recorded_ones() {
    let record: [(&str, [u64; 4]); 11] = [
        (
            "R3",
            [
                0xd463_5d04_dfbf_d0d7,
                0xae4a_a78a_4593_c5ac,
                0x4b20_5752_adf2_2c79,
                0x4971_b600_6e8b_f87b,
            ],
        ),
        (
            "N",
            [
                0x7014_758a_e9d1_c91c,
                0x00d8_c323_0b36_b3d6,
                0x6163_3c54_3d50_452c,
                0xdd4f_6c29_390a_73e3,
            ],
        ),
        (
            "N3",
            [
                0x7014_758a_e9d1_c91c,
                0x5f8e_17e2_c568_f652,
                0xc5c8_860d_138f_ae08,
                0xdb57_ef6e_5685_810f,
            ],
        ),
        (
            "LB",
            [
                0x25a3_9c54_07a3_0db0,
                0x5805_700a_4193_d665,
                0x8db0_07cb_fd6f_a832,
                0xe444_bb65_eca1_10eb,
            ],
        ),
        (
            "LB2",
            [
                0xf27e_ac95_0bd6_687a,
                0x4040_06b3_eae4_bd38,
                0x2c5c_ebc9_54d8_ad6e,
                0xa59c_ae03_a1c6_e5da,
            ],
        ),
        (
            "LB3",
            [
                0x778f_c4ff_9037_4116,
                0x80aa_d9a2_8c96_30a3,
                0xfd48_9db2_c861_f402,
                0x3407_366e_37cf_54c7,
            ],
        ),
        (
            "LB4",
            [
                0x5edb_2686_616d_d3ef,
                0xf980_16eb_9d19_99bd,
                0x346b_1455_b657_73c0,
                0xbbbf_7c58_a2fa_83bd,
            ],
        ),
        (
            "paper",
            [
                0xe1bb_2dc8_09e5_0bba,
                0xacc5_f954_4669_e0ed,
                0x5b8f_c0cb_0a98_6e78,
                0xb1d6_927f_75bc_29ca,
            ],
        ),
        (
            "R3 with noise",
            [
                0xfb9e_6ab4_0a6b_a3da,
                0x96b7_a3f5_3aa3_fc28,
                0x7fa6_5876_e7fa_ee4a,
                0x271d_323c_37ba_a38c,
            ],
        ),
        (
            "N walled",
            [
                0xc48e_47ed_2b89_9ff7,
                0xe02a_4f0c_375f_fa08,
                0x2dfa_cdf1_0b67_586b,
                0x0a60_e924_c366_61c5,
            ],
        ),
        (
            "LB2 walled",
            [
                0xfa4a_7291_155c_3699,
                0x7804_c5a5_8f19_cd13,
                0x775c_71b5_a8b1_210b,
                0x04d6_e469_9ec7_cbf4,
            ],
        ),
    ];
    let noisy = Preset {
        noise: Noise {
            sensor_flips_per_1024: 10,
            wheel_slips_per_1024: 20,
        },
        ..Preset::R3
    };
    let walled = walled().into_iter().take(2);
    let presets = Preset::ALL.into_iter().chain([noisy]).chain(walled);
    let now = presets.map(|preset| {
        let model = Model::new(preset).expect("a shipped preset");
        let trials = trials(&model, 1);
        TeamSize::ALL.map(|team| fingerprint(&run(Engine::fastest(), &model, team, &trials)))
    });
    for ((name, expected), found) in record.into_iter().zip(now) {
        assert_eq!(found, expected, "{name}: found {found:#018x?}");
    }
}
