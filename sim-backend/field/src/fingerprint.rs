//! Fingerprint of a field.

use hmac_sha256::Hash;

use crate::preset::{Contact, Corner, Goals, Preset, Push, Start};

impl Preset {
    /// Returns a hash of all numbers of this field, never 0; independent of name, training and
    /// fitness.
    ///
    /// First eight bytes of a SHA-256 over little-endian f32 values in file order. Enums count as
    /// list positions, obstacles and noise only if present.
    #[must_use]
    pub fn fingerprint(&self) -> u64 {
        let mut hash = Hash::new();
        let mut add = |value: f32| hash.update(value.to_bits().to_le_bytes());
        add(self.agent_radius_px);
        add(self.object_radius_px);
        add(self.medium_speed_px_per_frame);
        add(self.starts.distance_px);
        for corner in self.starts.corners {
            add(match corner {
                Corner::LeftTop => 0.0,
                Corner::RightTop => 1.0,
                Corner::LeftBottom => 2.0,
                Corner::RightBottom => 3.0,
            });
        }
        add(match self.starts.heading {
            Start::ToCentre => 0.0,
            Start::East => 1.0,
        });
        add(self.ir_range_px);
        add(self.ir_angle_steps.into());
        add(self.photo.angle_steps.into());
        add(self.photo.half_angle_cosine);
        add(self.object_light_px);
        add(self.goal_light_px);
        let (shape, distance) = match self.goals {
            Goals::CirclePx(radius) => (0.0, radius),
            Goals::SquarePx(half) => (1.0, half),
        };
        add(shape);
        add(distance);
        add(self.goal_radius_px);
        let (law, numbers) = match self.push {
            Push::Fitted { solo, team } => (0.0, [solo, team]),
            Push::Friction(stall_forces) => (1.0, [stall_forces, 0.0]),
        };
        add(law);
        numbers.into_iter().for_each(&mut add);
        add(match self.contact {
            Contact::Sliding => 0.0,
            Contact::Blocking => 1.0,
        });
        add(self.half_side_px);
        self.obstacle_numbers().into_iter().for_each(&mut add);
        if !self.noise.is_none() {
            add(self.noise.sensor_flips_per_1024.into());
            add(self.noise.wheel_slips_per_1024.into());
        }
        let [a, b, c, d, e, f, g, h, ..] = hash.finalize();
        u64::from_le_bytes([a, b, c, d, e, f, g, h]).max(1)
    }

    /// Numbers of walls and posts, each list after its length; empty without obstacles.
    fn obstacle_numbers(&self) -> Vec<f32> {
        let drawn = self.drawn_posts;
        if self.walls.is_empty() && self.posts.is_empty() && drawn.is_none() {
            return Vec::new();
        }
        let mut numbers = vec![self.walls.len() as f32];
        for wall in self.walls.iter() {
            numbers.extend(wall.from_px.into_iter().chain(wall.to_px));
        }
        numbers.push(self.posts.len() as f32);
        for post in self.posts.iter() {
            numbers.extend(post.at_px.into_iter().chain([post.radius_px]));
        }
        if let Some(posts) = drawn {
            // An f32 cannot represent every seed exactly.
            let halves = [posts.seed >> 16, posts.seed & 0xffff].map(|half| half as f32);
            numbers.extend([f32::from(posts.count), posts.radius_px]);
            numbers.extend(halves);
        }
        numbers
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::noise::Noise;
    use crate::obstacle::{DrawnPosts, Post, Wall};
    use crate::training::Training;
    use crate::weights::Weights;

    #[test]
    fn fingerprints_differ_between_fields() {
        let mut names = Preset::ALL.map(|preset| preset.fingerprint()).to_vec();
        let corners = [1, 0, 2, 3].map(|k| Preset::R3.starts.corners[k]);
        let mut other = Preset::R3;
        other.starts.corners = corners;
        names.push(other.fingerprint());
        let noise = Noise {
            wheel_slips_per_1024: 1,
            ..Noise::default()
        };
        names.push(
            Preset {
                noise,
                ..Preset::R3
            }
            .fingerprint(),
        );
        let obstacle = Preset {
            walls: vec![Wall {
                from_px: [0.0, 1.0],
                to_px: [2.0, 3.0],
            }]
            .into(),
            ..Preset::R3
        };
        names.push(obstacle.fingerprint());
        let at_px = [0.0, 1.0];
        let post = |radius_px| Preset {
            posts: vec![Post { at_px, radius_px }].into(),
            ..Preset::R3
        };
        names.extend([post(1.0).fingerprint(), post(2.0).fingerprint()]);
        let drawn = |seed| Preset {
            drawn_posts: Some(DrawnPosts {
                count: 1,
                radius_px: 1.0,
                seed,
            }),
            ..Preset::R3
        };
        let seeds = [1, 2, 1 << 31, (1 << 31) + 1];
        names.extend(seeds.map(|seed| drawn(seed).fingerprint()));
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), Preset::ALL.len() + 2 + 7);
        let renamed = Preset {
            name: "mine".into(),
            training: Some(Training::default()),
            fitness: Some(Weights::default()),
            ..Preset::R3
        };
        assert_eq!(renamed.fingerprint(), Preset::R3.fingerprint());
    }
}
