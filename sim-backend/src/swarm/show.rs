//! Observer's view of the fields, read-only.

use field::{
    EXECUTION_FRAMES, HEADINGS, Model, Push, TRIAL_FRAMES, TrialRun, accuracy, efficiency, solved,
};
use shm_schemas::{AgentTruth, ArenaTruth, FieldTruth, PostTruth, Text, WallTruth};

use super::{FrameCommands, Swarm};

impl Swarm {
    /// Writes the observer's view of this frame, without the stamp: poses, sensor bits, and the
    /// motion for the commands that [`Swarm::advance`] is about to receive. After a trial it
    /// contains the result. Robots are not affected.
    pub fn show(&self, answer: FrameCommands<'_>, arena: &mut ArenaTruth) {
        let commands = match answer {
            FrameCommands::Commands(commands) if self.accepts(commands) => Some(commands),
            _ => None,
        };
        let team = self.settings.team.get();
        arena.frame = self.frame().into();
        arena.field_hash = self.field_hash;
        arena.table_hash = commands.map_or(0, |commands| commands.table_hash);
        arena.trial = self.trial as u32;
        arena.trial_count = self.settings.goals.len() as u32;
        arena.goal = self
            .settings
            .goals
            .get(self.trial)
            .map_or(0, |goal| u32::from(*goal));
        arena.is_driven = commands.is_some().into();
        arena.team = team as u32;
        arena.field_count = self.runs.len() as u32;
        arena.agent_count = (team * self.runs.len()) as u32;
        arena.trials = self.past;
        describe(&self.settings.model, arena);
        for (shown, run) in arena.fields.iter_mut().zip(&self.runs) {
            *shown = self.field_truth(run);
        }
        let runs = self.runs.iter().zip(&self.rows);
        for (field, (run, rows)) in runs.enumerate() {
            let (world, first) = (run.world(), field * team);
            let touching = world.touching();
            for (agent, pose) in world.agents().iter().enumerate() {
                arena.agents[first + agent] = AgentTruth {
                    position_px: [pose.x_px, pose.y_px],
                    heading_steps: u32::from(pose.heading) % HEADINGS as u32,
                    row: rows[agent].into(),
                    output: commands.map_or(0, |commands| commands.output[first + agent]),
                    touches: touching[agent].into(),
                };
            }
        }
    }

    fn field_truth(&self, run: &TrialRun) -> FieldTruth {
        let (object, goal) = (run.world().object(), run.world().goal());
        let (distance_px, outcome) = (run.world().snapshot().goal_px, run.outcome());
        let points = match run.is_over() {
            true => self.points(&outcome),
            false => 0.0,
        };
        FieldTruth {
            object_px: [object.x_px, object.y_px],
            goal_px: [goal.x_px, goal.y_px],
            distance_px,
            e1_points: accuracy(distance_px),
            e2_points: efficiency(outcome.reached_frame),
            points,
            reached_frame: outcome.reached_frame,
            solved: solved(points).into(),
        }
    }
}

/// Writes the field's description: the visible part of its preset.
fn describe(model: &Model, arena: &mut ArenaTruth) {
    let preset = model.preset();
    arena.execution_frames = EXECUTION_FRAMES;
    arena.trial_frames = TRIAL_FRAMES;
    arena.ir_angle_steps = preset.ir_angle_steps.into();
    arena.photo_angle_steps = preset.photo.angle_steps.into();
    arena.photo_half_angle_cosine = preset.photo.half_angle_cosine;
    arena.half_side_px = preset.half_side_px;
    arena.agent_radius_px = preset.agent_radius_px;
    arena.object_radius_px = preset.object_radius_px;
    arena.goal_radius_px = preset.goal_radius_px;
    arena.ir_range_px = preset.ir_range_px;
    arena.object_light_px = preset.object_light_px;
    arena.goal_light_px = preset.goal_light_px;
    arena.friction_stall_forces = match preset.push {
        Push::Friction(stall_forces) => stall_forces,
        Push::Fitted { .. } => 0.0,
    };
    arena.yielding = preset.push.by_agents();
    let (walls, posts) = (model.walls(), model.posts());
    (arena.wall_count, arena.post_count) = (walls.len() as u32, posts.len() as u32);
    for (shown, wall) in arena.walls.iter_mut().zip(walls) {
        *shown = WallTruth {
            from_px: wall.from_px,
            to_px: wall.to_px,
        };
    }
    for (shown, post) in arena.posts.iter_mut().zip(posts) {
        *shown = PostTruth {
            at_px: post.at_px,
            radius_px: post.radius_px,
        };
    }
    arena.preset = Text::new(&preset.name);
}
