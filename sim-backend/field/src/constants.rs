//! Constants derived from a preset, shared by both simulators.

use crate::arithmetic::{greater, lesser};
use crate::heading::cos_sin;
use crate::noise::Noise;
use crate::obstacle::{Obstacles, Post, Wall};
use crate::preset::{Contact, Preset};
use crate::trial::MAX_AGENTS;

/// Margin beyond contact within which an agent counts as pushing, px. Design choice.
const FACING_MARGIN_PX: f32 = 1.0;
/// Margin of the culls against rounding, px. Design choice.
const CULL_MARGIN_PX: f32 = 1.0;

/// Derived constants, px. A `_sq` is a squared distance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants {
    pub contact: Contact,
    pub noise: Noise,
    /// Limit of an agent's |x| and |y|.
    pub agent_limit: f32,
    /// Limit of the object's |x| and |y|.
    pub object_limit: f32,
    pub agent_radius_sq: f32,
    pub object_radius_sq: f32,
    /// Centre distance in contact with the object.
    pub touch: f32,
    pub touch_sq: f32,
    /// Centre distance of two agents in contact.
    pub pair: f32,
    pub pair_sq: f32,
    pub facing_sq: f32,
    pub ir_range: f32,
    pub ir_cos: f32,
    pub ir_sin: f32,
    pub photo_cos: f32,
    pub photo_sin: f32,
    /// Squared cosine of half the photo opening angle; 0: half-plane.
    pub cone_sq: f32,
    pub object_light_sq: f32,
    pub goal_light_sq: f32,
    pub goal_radius_sq: f32,
    /// Share of an overlap that the object yields to one to four agents.
    pub push: [f32; MAX_AGENTS],
    pub half_side: f32,
    /// Travel per frame by left level + 4 · right level.
    pub travel: [f32; 16],
    /// Squared distance beyond which an agent neither detects nor touches the object in this frame,
    /// unless bodies meet before.
    pub cull_object_sq: f32,
    /// Squared distance beyond which two agents do not affect each other in this frame.
    pub cull_agent_sq: f32,
    /// Largest |x| and |y| at which an agent neither detects nor reaches the border in this frame.
    pub cull_wall: f32,
}

impl Constants {
    pub(crate) fn new(p: &Preset) -> Self {
        let sq = |v: f32| v * v;
        let touch = p.agent_radius_px + p.object_radius_px;
        let pair = 2.0 * p.agent_radius_px;
        let (ir_cos, ir_sin) = cos_sin(p.ir_angle_steps);
        let (photo_cos, photo_sin) = cos_sin(p.photo.angle_steps);
        let half_speed = 0.5 * p.medium_speed_px_per_frame;
        let agent_limit = p.half_side_px - p.agent_radius_px;
        // Longest motion in one frame, by wheels or along obstacles.
        let stride = match p.has_obstacles() {
            true => greater(4.0 * half_speed, p.agent_radius_px),
            false => 4.0 * half_speed,
        };
        let near_object = greater(p.ir_range_px + p.object_radius_px, touch + stride);
        let near_agent = greater(p.ir_range_px + p.agent_radius_px, pair + 2.0 * stride);
        let near_wall = lesser(agent_limit - stride, p.half_side_px - p.ir_range_px);
        Self {
            contact: p.contact,
            noise: p.noise,
            agent_limit,
            object_limit: p.half_side_px - p.object_radius_px,
            agent_radius_sq: sq(p.agent_radius_px),
            object_radius_sq: sq(p.object_radius_px),
            touch,
            touch_sq: sq(touch),
            pair,
            pair_sq: sq(pair),
            facing_sq: sq(touch + FACING_MARGIN_PX),
            ir_range: p.ir_range_px,
            ir_cos,
            ir_sin,
            photo_cos,
            photo_sin,
            cone_sq: sq(p.photo.half_angle_cosine),
            object_light_sq: sq(p.object_light_px),
            goal_light_sq: sq(p.goal_light_px),
            goal_radius_sq: sq(p.goal_radius_px),
            push: p.push.by_agents(),
            half_side: p.half_side_px,
            travel: std::array::from_fn(|code| half_speed * ((code & 3) + (code >> 2)) as f32),
            cull_object_sq: sq(near_object + CULL_MARGIN_PX),
            cull_agent_sq: sq(near_agent + CULL_MARGIN_PX),
            cull_wall: near_wall - CULL_MARGIN_PX,
        }
    }

    pub(crate) fn obstacles(p: &Preset, walls: &[Wall], posts: &[Post]) -> Obstacles {
        let radii = [p.agent_radius_px, p.object_radius_px];
        let stride = 2.0 * p.medium_speed_px_per_frame;
        let range = greater(p.ir_range_px, p.agent_radius_px + stride) + CULL_MARGIN_PX;
        Obstacles::new(walls, posts, radii, range)
    }
}
