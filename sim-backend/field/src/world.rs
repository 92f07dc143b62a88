//! Scalar reference simulator of one field.
//!
//! Order within a frame: all agents sense, all turn and drive, then contacts are resolved as
//! [`Contact`] defines.

use crate::arithmetic::{COINCIDENT_SQ, clamp, greater};
use crate::constants::Constants;
use crate::heading::cos_sin;
use crate::model::{Model, TeamSize};
use crate::noise::{FrameNoise, Stream};
use crate::obstacle::{Body, Obstacles};
use crate::preset::Contact;
use crate::responses::Wheels;
use crate::sensing::SensingAgent;
use crate::trial::{Layout, MAX_AGENTS, Point, Pose, Snapshot};

/// State of one field.
#[derive(Clone, Debug)]
pub struct World {
    constants: Constants,
    obstacles: Obstacles,
    team: TeamSize,
    agents: [Pose; MAX_AGENTS],
    object: Point,
    goal: Point,
    touching: [bool; MAX_AGENTS],
    /// Noise of this frame.
    frame_noise: [FrameNoise; MAX_AGENTS],
    noise: Stream,
}

#[inline]
fn distance_sq(a: Point, b: Point) -> f32 {
    let (dx, dy) = (b.x_px - a.x_px, b.y_px - a.y_px);
    dx * dx + dy * dy
}

impl World {
    /// Creates the field at frame 0, the object at the origin.
    #[must_use]
    pub fn new(model: &Model, team: TeamSize, layout: &Layout) -> Self {
        let (upsets, noise) = layout.noise.frame(model.constants.noise, team.get());
        Self {
            constants: model.constants,
            obstacles: model.obstacles,
            team,
            agents: layout.starts,
            object: Point::default(),
            goal: layout.goal,
            touching: [false; MAX_AGENTS],
            frame_noise: upsets,
            noise,
        }
    }

    /// Returns the team's agents.
    #[must_use]
    pub fn agents(&self) -> &[Pose] {
        &self.agents[..self.team.get()]
    }

    /// Returns the object's centre.
    #[must_use]
    pub fn object(&self) -> Point {
        self.object
    }

    /// Returns the goal's centre.
    #[must_use]
    pub fn goal(&self) -> Point {
        self.goal
    }

    /// Returns the agents that pressed against the object in the last frame.
    #[must_use]
    pub fn touching(&self) -> [bool; MAX_AGENTS] {
        self.touching
    }

    /// Returns true if the object is at the goal.
    #[must_use]
    pub fn object_at_goal(&self) -> bool {
        distance_sq(self.goal, self.object) <= self.constants.goal_radius_sq
    }

    /// Returns the current distances.
    #[must_use]
    pub fn snapshot(&self) -> Snapshot {
        let mut agents_px = [0.0; MAX_AGENTS];
        for (distance, agent) in agents_px.iter_mut().zip(self.agents()) {
            *distance = distance_sq(agent.position(), self.object).sqrt();
        }
        Snapshot {
            goal_px: distance_sq(self.goal, self.object).sqrt(),
            agents_px,
        }
    }

    /// Returns the table row of every agent (see [`crate::Responses`]); 0 outside the team.
    #[must_use]
    pub fn sense(&self) -> [u8; MAX_AGENTS] {
        let mut rows = [0; MAX_AGENTS];
        for (i, row) in rows.iter_mut().enumerate().take(self.team.get()) {
            *row = self.sense_agent(i) ^ self.frame_noise[i].flips;
        }
        rows
    }

    /// Simulates one frame at these wheel levels.
    pub fn advance(&mut self, wheels: &[Wheels; MAX_AGENTS]) {
        self.touching = [false; MAX_AGENTS];
        let wheels: [Wheels; MAX_AGENTS] =
            std::array::from_fn(|i| self.frame_noise[i].apply_slip(wheels[i]));
        match self.constants.contact {
            Contact::Sliding => {
                for (i, wheels) in wheels.iter().enumerate().take(self.team.get()) {
                    let to = self.turn_and_step(i, *wheels);
                    self.move_agent(i, to);
                }
                self.separate_agents();
                self.push_object();
            }
            Contact::Blocking => {
                let push = self.blocking_push();
                for (i, wheels) in wheels.iter().enumerate().take(self.team.get()) {
                    self.drive_blocking(i, *wheels, push);
                }
            }
        }
        (self.frame_noise, self.noise) = self.noise.frame(self.constants.noise, self.team.get());
    }

    fn sense_agent(&self, i: usize) -> u8 {
        let c = &self.constants;
        let sight = SensingAgent::new(self.agents[i]);
        let object = sight.relative(self.object);
        let mut ir = sight.ir(object, c.object_radius_sq, c);
        for (j, other) in self.agents().iter().enumerate() {
            if j != i {
                let seen = sight.ir(sight.relative(other.position()), c.agent_radius_sq, c);
                ir = std::array::from_fn(|k| ir[k] | seen[k]);
            }
        }
        for obstacle in self.obstacles.iter() {
            let seen = sight.obstacle(obstacle, c);
            ir = std::array::from_fn(|k| ir[k] | seen[k]);
        }
        let walls = sight.walls(c);
        let lit = |light, range_sq: f32| sight.photo(light, range_sq, c);
        let (by_object, by_goal) = (
            lit(object, c.object_light_sq),
            lit(sight.relative(self.goal), c.goal_light_sq),
        );
        let bits = [
            ir[0] | walls[0],
            ir[1] | walls[1],
            ir[2] | walls[2],
            by_object[0] | by_goal[0],
            by_object[1] | by_goal[1],
        ];
        bits.iter()
            .rev()
            .fold(0, |row, &bit| row << 1 | u8::from(bit))
    }

    /// Turns agent `i`; returns its target position.
    fn turn_and_step(&mut self, i: usize, wheels: Wheels) -> Point {
        let (left, right) = (wheels.left.min(2), wheels.right.min(2));
        let limit = self.constants.agent_limit;
        let travel = self.constants.travel[usize::from(left | right << 2)];
        let agent = &mut self.agents[i];
        agent.heading = agent.heading.wrapping_add(right).wrapping_sub(left) % 64;
        let (cos, sin) = cos_sin(agent.heading);
        Point {
            x_px: clamp(agent.x_px + travel * cos, limit),
            y_px: clamp(agent.y_px + travel * sin, limit),
        }
    }

    /// Sliding: moves agent `i` to a position, or as near as obstacles allow.
    fn move_agent(&mut self, i: usize, to: Point) {
        let (from, limit) = (self.agents[i].position(), self.constants.agent_limit);
        let at = self.obstacles.resolve_move(Body::Agent, from, to, limit);
        let Point { x_px, y_px } = at.unwrap_or(from);
        (self.agents[i].x_px, self.agents[i].y_px) = (x_px, y_px);
    }

    /// Sliding: moves overlapping agents apart by half the overlap each, then clamps all into the
    /// field.
    fn separate_agents(&mut self) {
        let n = self.team.get();
        let before = self.agents;
        for i in 0..n {
            for j in i + 1..n {
                let (dx, dy) = (
                    self.agents[j].x_px - self.agents[i].x_px,
                    self.agents[j].y_px - self.agents[i].y_px,
                );
                let sq = dx * dx + dy * dy;
                if sq < self.constants.pair_sq {
                    let distance = greater(sq, COINCIDENT_SQ).sqrt();
                    let share = 0.5 * (self.constants.pair - distance) / distance;
                    let (sx, sy) = (share * dx, share * dy);
                    self.agents[i].x_px -= sx;
                    self.agents[i].y_px -= sy;
                    self.agents[j].x_px += sx;
                    self.agents[j].y_px += sy;
                }
            }
        }
        let limit = self.constants.agent_limit;
        for (i, before) in before.into_iter().enumerate().take(n) {
            let Pose { x_px, y_px, .. } = std::mem::replace(&mut self.agents[i], before);
            let to = Point {
                x_px: clamp(x_px, limit),
                y_px: clamp(y_px, limit),
            };
            self.move_agent(i, to);
        }
    }

    /// Pushes the object by the sum of the overlaps, at most the largest one. Then moves agents
    /// that still overlap the object back.
    fn push_object(&mut self) {
        let c = self.constants;
        let (mut sum_x, mut sum_y, mut deepest, mut pushers) = (0.0, 0.0, 0.0, 0);
        for i in 0..self.team.get() {
            if let Some((overlap, dx, dy, distance)) = self.overlap(i) {
                let per_px = overlap / distance;
                sum_x += per_px * dx;
                sum_y += per_px * dy;
                deepest = greater(deepest, overlap);
                pushers += 1;
                self.touching[i] = true;
            }
        }
        if pushers == 0 {
            return;
        }
        let sum_sq = sum_x * sum_x + sum_y * sum_y;
        let capped = if deepest * deepest < sum_sq {
            deepest / greater(sum_sq, COINCIDENT_SQ).sqrt()
        } else {
            1.0
        };
        let part = capped * c.push[pushers - 1];
        let to = Point {
            x_px: clamp(self.object.x_px + part * sum_x, c.object_limit),
            y_px: clamp(self.object.y_px + part * sum_y, c.object_limit),
        };
        let settled = self
            .obstacles
            .resolve_move(Body::Object, self.object, to, c.object_limit);
        self.object = settled.unwrap_or(self.object);
        for i in 0..self.team.get() {
            if let Some((overlap, dx, dy, distance)) = self.overlap(i) {
                let per_px = overlap / distance;
                let agent = self.agents[i];
                let to = Point {
                    x_px: clamp(agent.x_px - per_px * dx, c.agent_limit),
                    y_px: clamp(agent.y_px - per_px * dy, c.agent_limit),
                };
                self.move_agent(i, to);
            }
        }
    }

    /// Returns the overlap of agent `i` with the object, the vector to the object, and its length.
    fn overlap(&self, i: usize) -> Option<(f32, f32, f32, f32)> {
        let agent = self.agents[i];
        let (dx, dy) = (self.object.x_px - agent.x_px, self.object.y_px - agent.y_px);
        let sq = dx * dx + dy * dy;
        (sq < self.constants.touch_sq).then(|| {
            let distance = greater(sq, COINCIDENT_SQ).sqrt();
            (self.constants.touch - distance, dx, dy, distance)
        })
    }

    /// Blocking: returns the share of an overlap that the object yields to the agents facing it.
    fn blocking_push(&self) -> f32 {
        let c = &self.constants;
        let facing = |agent: &Pose| {
            let ray = SensingAgent::new(*agent).relative(self.object);
            ray.distance_sq < c.facing_sq && ray.ahead > 0.0
        };
        let facing = self.agents().iter().filter(|agent| facing(agent)).count();
        c.push[facing.saturating_sub(1)]
    }

    /// Blocking: drives agent `i`, along obstacles if necessary. Cancels a move that would press
    /// into an agent, or press the object into an agent, the border or an obstacle.
    fn drive_blocking(&mut self, i: usize, wheels: Wheels, push: f32) {
        let c = self.constants;
        let from = self.agents[i].position();
        let to = self.turn_and_step(i, wheels);
        let settled = self
            .obstacles
            .resolve_move(Body::Agent, from, to, c.agent_limit);
        let mut target = settled.unwrap_or(to);
        let mut blocked =
            settled.is_none() || self.would_press_other_agent(i, from, target, c.pair_sq);
        let (dx, dy) = (
            self.object.x_px - target.x_px,
            self.object.y_px - target.y_px,
        );
        let sq = dx * dx + dy * dy;
        if sq < c.touch_sq {
            self.touching[i] = true;
            let sq = greater(sq, COINCIDENT_SQ);
            // (contact distance − distance) / distance, with independent root and quotient
            let overlap = sq.sqrt() * (c.touch / sq) - 1.0;
            let yielded = overlap * push;
            let refused = overlap - yielded;
            let pushed = Point {
                x_px: self.object.x_px + yielded * dx,
                y_px: self.object.y_px + yielded * dy,
            };
            blocked |= c.object_limit < greater(pushed.x_px.abs(), pushed.y_px.abs())
                || !self
                    .obstacles
                    .allows_move(Body::Object, self.object, pushed)
                || self.would_press_other_agent(i, self.object, pushed, c.touch_sq);
            let back = Point {
                x_px: clamp(target.x_px - refused * dx, c.agent_limit),
                y_px: clamp(target.y_px - refused * dy, c.agent_limit),
            };
            let settled = self
                .obstacles
                .resolve_move(Body::Agent, target, back, c.agent_limit);
            blocked |= settled.is_none();
            target = settled.unwrap_or(back);
            if !blocked {
                self.object = pushed;
            }
        }
        if !blocked {
            (self.agents[i].x_px, self.agents[i].y_px) = (target.x_px, target.y_px);
        }
    }

    /// Returns true if the move brings a body within contact of an agent other than `i`, and closer
    /// than before.
    fn would_press_other_agent(&self, i: usize, from: Point, to: Point, contact_sq: f32) -> bool {
        self.agents().iter().enumerate().any(|(j, other)| {
            let sq = distance_sq(to, other.position());
            j != i && sq < contact_sq && sq < distance_sq(from, other.position())
        })
    }
}
