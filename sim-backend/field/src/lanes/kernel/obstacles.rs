//! Walls and posts over lanes: operations of [`crate::obstacle`] and [`crate::sensing`] in the same
//! order.

use super::Fields;
use super::sense::RelativePoint;
use crate::arithmetic::COINCIDENT_SQ;
use crate::lanes::{Lanes, Mask};
use crate::obstacle::{Body, Obstacle};
use crate::trial::Point;

impl<T: Lanes, const N: usize, const WALLED: bool> Fields<'_, T, N, WALLED> {
    /// Returns true if any obstacle is near in some lane.
    #[inline(always)]
    pub(super) fn detect_obstacles(&self, mut seen: T::Ints, i: usize) -> (T::Ints, bool) {
        let mut near = false;
        for obstacle in self.obstacles.iter() {
            let (dx, dy) = self.vector_from(obstacle, (self.x[i], self.y[i]));
            if (dx * dx + dy * dy).lt(self.v(obstacle.cull_sq)).any() {
                near = true;
                seen = self.detect_obstacle(seen, i, obstacle);
            }
        }
        (seen, near)
    }

    #[inline(always)]
    fn detect_obstacle(&self, seen: T::Ints, i: usize, obstacle: &Obstacle) -> T::Ints {
        let [from, to] = obstacle.ends;
        let from = self.relative_to(i, from);
        if obstacle.radius > 0.0 {
            return self.ir(seen, from, obstacle.radius_sq);
        }
        let (from, to) = (self.turned(from), self.turned(self.relative_to(i, to)));
        seen | self.bit(self.crosses(from[0], to[0]), 4)
            | self.bit(self.crosses(from[1], to[1]), 8)
            | self.bit(self.crosses(from[2], to[2]), 16)
    }

    #[inline(always)]
    fn relative_to(&self, i: usize, at: Point) -> RelativePoint<T> {
        let (x, y) = (self.v(at.x_px), self.v(at.y_px));
        self.relative(i, x - self.x[i], y - self.y[i])
    }

    /// A point in the frames of the left, front and right IR sensor.
    #[inline(always)]
    fn turned(&self, RelativePoint { ahead, left, .. }: RelativePoint<T>) -> [(T, T); 3] {
        let (cos, sin) = (self.v(self.c.ir_cos), self.v(self.c.ir_sin));
        let (ahead_cos, left_sin) = (ahead * cos, left * sin);
        let (left_cos, ahead_sin) = (left * cos, ahead * sin);
        [
            (ahead_cos + left_sin, left_cos - ahead_sin),
            (ahead, left),
            (ahead_cos - left_sin, left_cos + ahead_sin),
        ]
    }

    /// Tests if the segment ahead crosses a wall.
    #[inline(always)]
    fn crosses(&self, from: (T, T), to: (T, T)) -> T::Mask {
        let zero = self.v(0.0);
        let across = from.1 - to.1;
        let ahead = (to.0 * from.1 - from.0 * to.1) * across;
        let beyond = self.v(self.c.ir_range) * (across * across);
        let apart = (from.1 * to.1).lt(zero);
        ahead.lt_among(beyond, zero.lt_among(ahead, apart))
    }

    /// Returns the end position and the blocked lanes. A body at rest stays.
    #[inline(always)]
    pub(super) fn resolve_move(&self, body: Body, from: (T, T), to: (T, T)) -> ((T, T), T::Mask) {
        let moved = self.moved(from, to);
        if !moved.any() {
            return (to, T::mask(self.cpu, 0));
        }
        let mut at = to;
        for obstacle in self.obstacles.iter() {
            at = self.push_out(body, obstacle, at);
        }
        let limit = match body {
            Body::Agent => self.c.agent_limit,
            Body::Object => self.c.object_limit,
        };
        at = (at.0.clamp(self.v(limit)), at.1.clamp(self.v(limit)));
        let at = (T::select(moved, at.0, to.0), T::select(moved, at.1, to.1));
        (at, moved & self.forbids_move(body, from, at))
    }

    /// Returns the end position; a blocked body stays at `from`.
    #[inline(always)]
    pub(super) fn move_or_stay(&self, body: Body, from: (T, T), to: (T, T)) -> (T, T) {
        if !WALLED {
            return to;
        }
        let (at, barred) = self.resolve_move(body, from, to);
        (
            T::select(barred, from.0, at.0),
            T::select(barred, from.1, at.1),
        )
    }

    /// Lanes in which obstacles forbid the move.
    #[inline(always)]
    pub(super) fn forbids_move(&self, body: Body, from: (T, T), to: (T, T)) -> T::Mask {
        let (dx, dy) = (to.0 - from.0, to.1 - from.1);
        let leap = self.v(self.obstacles.max_move_sq[body as usize]);
        let mut barred = leap.lt(dx * dx + dy * dy);
        for obstacle in self.obstacles.iter() {
            let (dx, dy) = self.vector_from(obstacle, to);
            let inside = self.v(obstacle.contact[body as usize].inside_sq);
            barred = barred | (dx * dx + dy * dy).lt(inside);
        }
        barred
    }

    #[inline(always)]
    fn moved(&self, from: (T, T), to: (T, T)) -> T::Mask {
        let zero = self.v(0.0);
        zero.lt((to.0 - from.0).max_abs(to.1 - from.1))
    }

    #[inline(always)]
    fn push_out(&self, body: Body, obstacle: &Obstacle, at: (T, T)) -> (T, T) {
        let (dx, dy) = self.vector_from(obstacle, at);
        let (sq, reach) = (dx * dx + dy * dy, obstacle.contact[body as usize]);
        let overlaps = sq.lt(self.v(reach.sq));
        if !overlaps.any() {
            return at;
        }
        let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
        let more = self.v(reach.px) / distance - self.v(1.0);
        (
            T::select(overlaps, at.0 + more * dx, at.0),
            T::select(overlaps, at.1 + more * dy, at.1),
        )
    }

    /// Vector from the nearest point of the obstacle's line.
    #[inline(always)]
    fn vector_from(&self, obstacle: &Obstacle, (x, y): (T, T)) -> (T, T) {
        let (dx, dy) = (
            x - self.v(obstacle.middle.x_px),
            y - self.v(obstacle.middle.y_px),
        );
        let (ux, uy) = (self.v(obstacle.along.x_px), self.v(obstacle.along.y_px));
        let along = (dx * ux + dy * uy).clamp(self.v(obstacle.half));
        (dx - along * ux, dy - along * uy)
    }
}
