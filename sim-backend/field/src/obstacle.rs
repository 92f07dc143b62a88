//! Walls and posts, impassable for agents and object.
//!
//! Both are a line segment with a radius: 0 for a wall; a post has length 0. An IR sensor detects
//! an obstacle that its segment crosses. Obstacles, like agents, do not block lights.

use serde::{Deserialize, Serialize};

use crate::arithmetic::{COINCIDENT_SQ, clamp, greater};
use crate::trial::Point;

/// Largest number of obstacles of a field. Design choice: every frame checks each of them.
pub const MAX_OBSTACLES: usize = 16;
/// Tolerated penetration, px; above any rounding error. Design choice.
const SLACK_PX: f32 = 1.0 / 64.0;
/// Margin of a body's largest move below its radius, px, so that no body crosses a wall. Design
/// choice.
pub(crate) const MOVE_MARGIN_PX: f32 = 0.5;

/// Straight wall without thickness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// First end, x and y.
    pub from_px: [f32; 2],
    /// Second end, x and y.
    pub to_px: [f32; 2],
}

/// Round post.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Post {
    /// Centre, x and y.
    pub at_px: [f32; 2],
    /// Radius.
    pub radius_px: f32,
}

/// Posts at random free positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnPosts {
    /// Number of posts.
    pub count: u8,
    /// Radius of each.
    pub radius_px: f32,
    /// Seed of the positions.
    pub seed: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Body {
    Agent,
    Object,
}

/// Distances between a body's centre and an obstacle's line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ContactDistance {
    /// Contact distance.
    pub px: f32,
    pub sq: f32,
    /// Squared distance below which the body counts as inside.
    pub inside_sq: f32,
}

/// Obstacle, prepared for both simulators.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Obstacle {
    /// Ends of the line.
    pub ends: [Point; 2],
    pub middle: Point,
    /// Unit vector along the line; zero for a post.
    pub along: Point,
    /// Half the length; 1 for a post, because a clamp needs a limit above 0.
    pub half: f32,
    /// 0 for a wall.
    pub radius: f32,
    pub radius_sq: f32,
    /// Contact distances of agent and object.
    pub contact: [ContactDistance; 2],
    /// Squared distance beyond which an agent neither detects nor touches the obstacle in this
    /// frame, unless bodies meet before.
    pub cull_sq: f32,
}

/// Obstacles of a field, walls first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacles {
    each: [Obstacle; MAX_OBSTACLES],
    count: usize,
    /// Squared largest move of an agent and of the object.
    pub max_move_sq: [f32; 2],
}

impl Wall {
    pub(crate) fn ends(&self) -> [Point; 2] {
        [self.from_px, self.to_px].map(point)
    }
}

pub(crate) fn point([x_px, y_px]: [f32; 2]) -> Point {
    Point { x_px, y_px }
}

impl Obstacles {
    /// `radii`: of agent and object. `range`: the larger of sensing range and travel per frame.
    pub(crate) fn new(walls: &[Wall], posts: &[Post], radii: [f32; 2], range: f32) -> Self {
        let walls = walls.iter().map(|wall| (wall.ends(), 0.0));
        let posts = posts
            .iter()
            .map(|post| ([point(post.at_px); 2], post.radius_px));
        let mut each = [Obstacle::default(); MAX_OBSTACLES];
        let mut count = 0;
        for (slot, (ends, radius)) in each.iter_mut().zip(walls.chain(posts)) {
            *slot = Obstacle::new(ends, radius, radii, range);
            count += 1;
        }
        let leap_sq = radii.map(|radius| (radius - MOVE_MARGIN_PX) * (radius - MOVE_MARGIN_PX));
        Self {
            each,
            count,
            max_move_sq: leap_sq,
        }
    }

    pub(crate) fn iter(&self) -> std::slice::Iter<'_, Obstacle> {
        self.each[..self.count].iter()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Returns the distance to the nearest obstacle; infinite without obstacles.
    pub(crate) fn clearance_px(&self, at: Point) -> f32 {
        let clearance = |obstacle: &Obstacle| {
            let (dx, dy) = obstacle.vector_to(at);
            (dx * dx + dy * dy).sqrt() - obstacle.radius
        };
        self.iter().map(clearance).fold(f32::INFINITY, f32::min)
    }

    /// Returns the end position of a body moving `from` → `to`, pushed out of each obstacle in
    /// order and clamped to ± `limit`. `None`: the result is inside an obstacle or beyond the
    /// largest move. A body at rest stays; without obstacles `to` is returned.
    ///
    /// Precondition: `from` is outside all obstacles.
    pub(crate) fn resolve_move(
        &self,
        body: Body,
        from: Point,
        to: Point,
        limit: f32,
    ) -> Option<Point> {
        if self.is_empty() || from == to {
            return Some(to);
        }
        let mut at = to;
        for obstacle in self.iter() {
            at = obstacle.push_out(body, at);
        }
        let at = Point {
            x_px: clamp(at.x_px, limit),
            y_px: clamp(at.y_px, limit),
        };
        self.allows_move(body, from, at).then_some(at)
    }

    /// Returns true if `to` is outside all obstacles and within the largest move, or if there are
    /// no obstacles.
    pub(crate) fn allows_move(&self, body: Body, from: Point, to: Point) -> bool {
        let (dx, dy) = (to.x_px - from.x_px, to.y_px - from.y_px);
        let inside = |obstacle: &Obstacle| {
            let (dx, dy) = obstacle.vector_to(to);
            dx * dx + dy * dy < obstacle.contact[body as usize].inside_sq
        };
        self.is_empty()
            || dx * dx + dy * dy <= self.max_move_sq[body as usize] && !self.iter().any(inside)
    }
}

impl Obstacle {
    fn new(ends: [Point; 2], radius: f32, radii: [f32; 2], range: f32) -> Self {
        let [from, to] = ends;
        let (dx, dy) = (to.x_px - from.x_px, to.y_px - from.y_px);
        let length = (dx * dx + dy * dy).sqrt();
        let (along, half) = match length > 0.0 {
            true => (point([dx / length, dy / length]), 0.5 * length),
            false => (Point::default(), 1.0),
        };
        let reach = radii.map(|body| {
            let (px, inside) = (body + radius, body + radius - SLACK_PX);
            ContactDistance {
                px,
                sq: px * px,
                inside_sq: inside * inside,
            }
        });
        let cull = radius + range;
        Self {
            ends,
            middle: point([0.5 * (from.x_px + to.x_px), 0.5 * (from.y_px + to.y_px)]),
            along,
            half,
            radius,
            radius_sq: radius * radius,
            contact: reach,
            cull_sq: cull * cull,
        }
    }

    /// Returns the vector from the nearest point of the line.
    pub(crate) fn vector_to(&self, at: Point) -> (f32, f32) {
        let (dx, dy) = (at.x_px - self.middle.x_px, at.y_px - self.middle.y_px);
        let along = clamp(dx * self.along.x_px + dy * self.along.y_px, self.half);
        (dx - along * self.along.x_px, dy - along * self.along.y_px)
    }

    /// Moves an overlapping body to the nearest position in contact.
    fn push_out(&self, body: Body, at: Point) -> Point {
        let (dx, dy) = self.vector_to(at);
        let (sq, reach) = (dx * dx + dy * dy, self.contact[body as usize]);
        if sq < reach.sq {
            let more = reach.px / greater(sq, COINCIDENT_SQ).sqrt() - 1.0;
            point([at.x_px + more * dx, at.y_px + more * dy])
        } else {
            at
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn obstacles() -> Obstacles {
        let wall = Wall {
            from_px: [-100.0, 0.0],
            to_px: [100.0, 0.0],
        };
        let post = Post {
            at_px: [0.0, 200.0],
            radius_px: 30.0,
        };
        Obstacles::new(&[wall], &[post], [20.0, 40.0], 50.0)
    }

    #[test]
    fn bodies_slide_along_obstacles() {
        // from, to, end position of the agent
        let rows = [
            ([0.0, 30.0], [3.0, 25.0], Some([3.0, 25.0])), // clear of it
            ([0.0, 21.0], [8.0, 12.0], Some([8.0, 20.0])), // along the wall
            ([0.0, -21.0], [8.0, -12.0], Some([8.0, -20.0])),
            ([125.0, 0.0], [118.0, 0.0], Some([120.0, 0.0])), // against its end
            ([0.0, 149.0], [0.0, 155.0], Some([0.0, 150.0])), // against the post
            ([0.0, 21.0], [0.0, -21.0], None),                // through the wall
            ([0.0, 21.0], [0.0, 0.0], None),                  // onto its centre line
            ([200.0, 0.0], [200.0, 30.0], None),              // move too long
            ([0.0, 15.0], [0.0, 15.0], Some([0.0, 15.0])),    // no motion
        ];
        for (from, to, expected) in rows {
            let found = obstacles().resolve_move(Body::Agent, point(from), point(to), 400.0);
            let near = |a: Point, b: [f32; 2]| {
                (a.x_px - b[0]).abs() < 0.01 && (a.y_px - b[1]).abs() < 0.01
            };
            let same = match (found, expected) {
                (Some(found), Some(expected)) => near(found, expected),
                (found, expected) => found.is_none() && expected.is_none(),
            };
            assert!(same, "{from:?} to {to:?}: {found:?}, not {expected:?}");
        }
    }

    #[test]
    fn random_moves_never_cross_a_wall() {
        let obstacles = obstacles();
        let mut at = point([0.0, 25.0]);
        let mut state = 1_u32;
        let moves = if cfg!(miri) { 500 } else { 100_000 };
        for _ in 0..moves {
            let mut throw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / (1 << 24) as f32 * 60.0 - 30.0
            };
            let to = point([
                clamp(at.x_px + throw(), 80.0),
                clamp(at.y_px + throw(), 380.0),
            ]);
            at = obstacles
                .resolve_move(Body::Agent, at, to, 380.0)
                .unwrap_or(at);
            assert!(at.y_px > 20.0 - 2.0 * SLACK_PX, "{at:?} is behind the wall");
        }
    }
}
