//! Walls and posts inside the field: what neither agents nor the object pass.
//!
//! A wall is a line, a post a disc; both are a line with a radius, 0 of a wall and a line of no length in a post. A body
//! keeps its own radius and the obstacle's away from the line. IR sensors see an obstacle as they see the field's border:
//! where the tip would lie beyond it, that is, where the segment from the agent's centre to the tip crosses the wall or cuts
//! the disc. Lights are seen over them, as over agents.

use serde::{Deserialize, Serialize};

use crate::arithmetic::{COINCIDENT_SQ, clamp, greater};
use crate::trial::Point;

/// Walls and posts of one field, those at drawn places included: every one of them is looked at in every frame (ours).
pub const MAX_OBSTACLES: usize = 16;
/// A body this much nearer than contact still counts as put out of an obstacle: more than rounding ever is (ours).
const SLACK_PX: f32 = 1.0 / 64.0;
/// What a body moves at most in one go is less than its radius by this, so that it is never beyond a wall (ours).
pub(crate) const LEAP_MARGIN_PX: f32 = 0.5;

/// A straight wall without thickness.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Wall {
    /// Where it begins, x and y.
    pub from_px: [f32; 2],
    /// Where it ends.
    pub to_px: [f32; 2],
}

/// A round post.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Post {
    /// Its centre, x and y.
    pub at_px: [f32; 2],
    /// Its radius.
    pub radius_px: f32,
}

/// Posts at places that a seed names: anywhere where they touch neither the border nor a start, the object or a goal.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DrawnPosts {
    /// How many.
    pub count: u8,
    /// Of each.
    pub radius_px: f32,
    /// Other seeds, other places.
    pub seed: u32,
}

/// Which body meets an obstacle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Body {
    Agent,
    Object,
}

/// How near the centre of a body comes to an obstacle's line.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Reach {
    /// In contact.
    pub px: f32,
    pub sq: f32,
    /// The squared distance below which a body is inside.
    pub inside_sq: f32,
}

/// One obstacle as both simulators compute with it.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Obstacle {
    /// The ends of the line.
    pub ends: [Point; 2],
    pub middle: Point,
    /// Unit vector along the line; zero in a post.
    pub along: Point,
    /// Half the length of the line; 1 in a post, so that the limit of a clamp is above 0.
    pub half: f32,
    /// 0 in a wall.
    pub radius: f32,
    pub radius_sq: f32,
    /// Of an agent and of the object.
    pub reach: [Reach; 2],
    /// An agent this far from the line neither sees nor meets the obstacle in this frame, unless bodies meet
    /// before.
    pub cull_sq: f32,
}

/// All obstacles of a field, walls first.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Obstacles {
    each: [Obstacle; MAX_OBSTACLES],
    count: usize,
    /// The squared way that an agent and the object move at most in one go.
    pub leap_sq: [f32; 2],
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
    /// `radii`: of an agent and of the object. `range`: what an agent sees or drives at most in a frame.
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
        let leap_sq = radii.map(|radius| (radius - LEAP_MARGIN_PX) * (radius - LEAP_MARGIN_PX));
        Self {
            each,
            count,
            leap_sq,
        }
    }

    pub(crate) fn iter(&self) -> std::slice::Iter<'_, Obstacle> {
        self.each[..self.count].iter()
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// How far a place is from the nearest obstacle; infinitely where there is none.
    pub(crate) fn clearance_px(&self, at: Point) -> f32 {
        let clearance = |obstacle: &Obstacle| {
            let (dx, dy) = obstacle.to(at);
            (dx * dx + dy * dy).sqrt() - obstacle.radius
        };
        self.iter().map(clearance).fold(f32::INFINITY, f32::min)
    }

    /// Where a body ends that goes `from` → `to`, its centre inside ± `limit`: outside of all obstacles, put out of those
    /// that it would overlap in their order; nothing if there is no such place within a leap. What does not move stays, and without obstacles everything goes.
    ///
    /// `from` is outside of all of them, and a leap is less than a body's radius: no body is ever beyond a wall.
    pub(crate) fn settle(&self, body: Body, from: Point, to: Point, limit: f32) -> Option<Point> {
        if self.is_empty() || from == to {
            return Some(to);
        }
        let mut at = to;
        for obstacle in self.iter() {
            at = obstacle.put_out(body, at);
        }
        let at = Point {
            x_px: clamp(at.x_px, limit),
            y_px: clamp(at.y_px, limit),
        };
        self.lets(body, from, at).then_some(at)
    }

    /// Whether a body of a field with obstacles may go `from` → `to` as it is: to a place outside of all obstacles and no further than a leap.
    pub(crate) fn lets(&self, body: Body, from: Point, to: Point) -> bool {
        let (dx, dy) = (to.x_px - from.x_px, to.y_px - from.y_px);
        let inside = |obstacle: &Obstacle| {
            let (dx, dy) = obstacle.to(to);
            dx * dx + dy * dy < obstacle.reach[body as usize].inside_sq
        };
        self.is_empty()
            || dx * dx + dy * dy <= self.leap_sq[body as usize] && !self.iter().any(inside)
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
            Reach {
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
            reach,
            cull_sq: cull * cull,
        }
    }

    /// The vector from the nearest point of the line to a place.
    pub(crate) fn to(&self, at: Point) -> (f32, f32) {
        let (dx, dy) = (at.x_px - self.middle.x_px, at.y_px - self.middle.y_px);
        let along = clamp(dx * self.along.x_px + dy * self.along.y_px, self.half);
        (dx - along * self.along.x_px, dy - along * self.along.y_px)
    }

    /// The nearest place in contact, of a body that overlaps.
    fn put_out(&self, body: Body, at: Point) -> Point {
        let (dx, dy) = self.to(at);
        let (sq, reach) = (dx * dx + dy * dy, self.reach[body as usize]);
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
    fn bodies_slide_along_obstacles_and_end_outside_of_them() {
        // from, to, where an agent ends
        let rows = [
            ([0.0, 30.0], [3.0, 25.0], Some([3.0, 25.0])), // clear of it
            ([0.0, 21.0], [8.0, 12.0], Some([8.0, 20.0])), // along the wall
            ([0.0, -21.0], [8.0, -12.0], Some([8.0, -20.0])),
            ([125.0, 0.0], [118.0, 0.0], Some([120.0, 0.0])), // against its end
            ([0.0, 149.0], [0.0, 155.0], Some([0.0, 150.0])), // against the post
            ([0.0, 21.0], [0.0, -21.0], None),                // through the wall
            ([0.0, 21.0], [0.0, 0.0], None),                  // into its middle
            ([200.0, 0.0], [200.0, 30.0], None),              // a leap
            ([0.0, 15.0], [0.0, 15.0], Some([0.0, 15.0])),    // what does not move stays
        ];
        for (from, to, expected) in rows {
            let found = obstacles().settle(Body::Agent, point(from), point(to), 400.0);
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
    fn nobody_passes_a_wall_wherever_bodies_are_thrown() {
        let obstacles = obstacles();
        let mut at = point([0.0, 25.0]);
        let mut state = 1_u32;
        for _ in 0..100_000 {
            let mut throw = || {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                (state >> 8) as f32 / (1 << 24) as f32 * 60.0 - 30.0
            };
            let to = point([
                clamp(at.x_px + throw(), 80.0),
                clamp(at.y_px + throw(), 380.0),
            ]);
            at = obstacles.settle(Body::Agent, at, to, 380.0).unwrap_or(at);
            assert!(at.y_px > 20.0 - 2.0 * SLACK_PX, "{at:?} is beyond the wall");
        }
    }
}
