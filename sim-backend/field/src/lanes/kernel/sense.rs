//! Sensors of the agents and responses of their tables.

use super::{Fields, Near, Team};
use crate::lanes::inputs::LaneInputs;
use crate::lanes::{Ints, Lanes, Mask};

/// Target in the agent's frame.
#[derive(Clone, Copy)]
pub(super) struct RelativePoint<T> {
    pub(super) ahead: T,
    pub(super) left: T,
    distance_sq: T,
}

impl<T: Lanes, const N: usize, const WALLED: bool> Fields<'_, T, N, WALLED> {
    #[inline(always)]
    pub(super) fn sense(&mut self, seats: &LaneInputs<N>) -> Team<T::Ints, N> {
        let mut codes = self.detect_agents();
        self.facing = self.int(0);
        each_agent!(i of N {
            let mut ir = codes[i];
            let object = self.relative(i, self.object_x - self.x[i], self.object_y - self.y[i]);
            self.near[i].object = object.distance_sq.lt(self.v(self.c.cull_object_sq)).any();
            if self.near[i].object {
                ir = self.ir(ir, object, self.c.object_radius_sq);
                let touching = object.distance_sq.lt(self.v(self.c.facing_sq));
                self.facing = self.facing + self.bit(self.v(0.0).lt_among(object.ahead, touching), 1);
            }
            let farthest = self.x[i].max_abs(self.y[i]);
            self.near[i].walls = self.v(self.c.cull_wall).lt(farthest).any();
            if self.near[i].walls {
                ir = self.detect_border(ir, i);
            }
            if WALLED {
                (ir, self.near[i].obstacles) = self.detect_obstacles(ir, i);
            }
            let photo = self.detect_lights(i, object);
            codes[i] = self.look_up(seats, i, ir, photo);
        });
        codes
    }

    /// Left and right photo sensor of agent `i`.
    #[inline(always)]
    fn detect_lights(&self, i: usize, object: RelativePoint<T>) -> [T::Mask; 2] {
        let by_object = self.photo(object, self.c.object_light_sq);
        let (dx, dy) = (self.goal_x - self.x[i], self.goal_y - self.y[i]);
        if !(dx * dx + dy * dy).lt(self.v(self.c.goal_light_sq)).any() {
            return by_object;
        }
        let by_goal = self.photo(self.relative(i, dx, dy), self.c.goal_light_sq);
        [by_object[0] | by_goal[0], by_object[1] | by_goal[1]]
    }

    #[inline(always)]
    pub(super) fn relative(&self, i: usize, dx: T, dy: T) -> RelativePoint<T> {
        RelativePoint {
            ahead: dx * self.cos[i] + dy * self.sin[i],
            left: dy * self.cos[i] - dx * self.sin[i],
            distance_sq: dx * dx + dy * dy,
        }
    }

    /// IR readings caused by other agents, as 4 left, 8 front, 16 right: four times their part of
    /// the row, the shift of a table word.
    #[inline(always)]
    fn detect_agents(&mut self) -> Team<T::Ints, N> {
        let mut ir = [self.int(0); N];
        self.near = [Near::default(); N];
        each_agent!(i of N {
            each_agent!(j of N {
                if i < j {
                    (ir[i], ir[j]) = self.detect_pair(i, j, ir[i], ir[j]);
                }
            });
        });
        ir
    }

    #[inline(always)]
    fn detect_pair(
        &mut self,
        i: usize,
        j: usize,
        seen_by_i: T::Ints,
        seen_by_j: T::Ints,
    ) -> (T::Ints, T::Ints) {
        let (dx, dy) = (self.x[j] - self.x[i], self.y[j] - self.y[i]);
        if !(dx * dx + dy * dy).lt(self.v(self.c.cull_agent_sq)).any() {
            return (seen_by_i, seen_by_j);
        }
        (self.near[i].agents, self.near[j].agents) = (true, true);
        let zero = self.v(0.0);
        let (ahead_of_i, ahead_of_j) = (
            self.relative(i, dx, dy),
            self.relative(j, zero - dx, zero - dy),
        );
        (
            self.ir(seen_by_i, ahead_of_i, self.c.agent_radius_sq),
            self.ir(seen_by_j, ahead_of_j, self.c.agent_radius_sq),
        )
    }

    /// Adds IR sensors whose segments intersect a circle.
    #[inline(always)]
    pub(super) fn ir(
        &self,
        seen: T::Ints,
        RelativePoint { ahead, left, .. }: RelativePoint<T>,
        radius_sq: f32,
    ) -> T::Ints {
        let (cos, sin) = (self.v(self.c.ir_cos), self.v(self.c.ir_sin));
        let (ahead_cos, left_sin) = (ahead * cos, left * sin);
        let (left_cos, ahead_sin) = (left * cos, ahead * sin);
        seen | self.bit(
            self.cuts(ahead_cos + left_sin, left_cos - ahead_sin, radius_sq),
            4,
        ) | self.bit(self.cuts(ahead, left, radius_sq), 8)
            | self.bit(
                self.cuts(ahead_cos - left_sin, left_cos + ahead_sin, radius_sq),
                16,
            )
    }

    #[inline(always)]
    fn cuts(&self, ahead: T, left: T, radius_sq: f32) -> T::Mask {
        let zero = self.v(0.0);
        let beyond = (ahead - self.v(self.c.ir_range)).max(zero);
        (beyond * beyond + left * left).lt_among(self.v(radius_sq), zero.lt(ahead))
    }

    /// Adds IR sensors whose segments end outside the field.
    #[inline(always)]
    fn detect_border(&self, seen: T::Ints, i: usize) -> T::Ints {
        let (side_cos, side_sin) = (self.v(self.c.ir_cos), self.v(self.c.ir_sin));
        let (cos_cos, sin_sin) = (self.cos[i] * side_cos, self.sin[i] * side_sin);
        let (cos_sin, sin_cos) = (self.cos[i] * side_sin, self.sin[i] * side_cos);
        seen | self.bit(
            self.ends_outside(i, cos_cos - sin_sin, sin_cos + cos_sin),
            4,
        ) | self.bit(self.ends_outside(i, self.cos[i], self.sin[i]), 8)
            | self.bit(
                self.ends_outside(i, cos_cos + sin_sin, sin_cos - cos_sin),
                16,
            )
    }

    #[inline(always)]
    fn ends_outside(&self, i: usize, cos: T, sin: T) -> T::Mask {
        let range = self.v(self.c.ir_range);
        let (x, y) = (self.x[i] + range * cos, self.y[i] + range * sin);
        self.v(self.c.half_side).lt(x.max_abs(y))
    }

    #[inline(always)]
    fn photo(
        &self,
        RelativePoint {
            ahead,
            left,
            distance_sq,
        }: RelativePoint<T>,
        range_sq: f32,
    ) -> [T::Mask; 2] {
        let near = distance_sq.lt(self.v(range_sq));
        let (ahead, left) = (
            ahead * self.v(self.c.photo_cos),
            left * self.v(self.c.photo_sin),
        );
        [
            self.in_cone(ahead + left, distance_sq, near),
            self.in_cone(ahead - left, distance_sq, near),
        ]
    }

    /// Tests if a light this far along the sensor's axis is inside its cone.
    #[inline(always)]
    fn in_cone(&self, along: T, distance_sq: T, near: T::Mask) -> T::Mask {
        let forward = self.v(0.0).lt_among(along, near);
        if self.c.cone_sq == 0.0 {
            return forward;
        }
        (self.v(self.c.cone_sq) * distance_sq).lt_among(along * along, forward)
    }

    /// Response code in the lowest four bits, after wheel slip; records the row.
    #[inline(always)]
    fn look_up(
        &mut self,
        seats: &LaneInputs<N>,
        i: usize,
        ir: T::Ints,
        photo: [T::Mask; 2],
    ) -> T::Ints {
        if self.c.noise.is_none() {
            return self.respond(seats, i, ir, photo);
        }
        let (ir, photo) = self.apply_sensor_noise(ir, photo);
        let code = self.respond(seats, i, ir, photo);
        self.apply_slip(code)
    }

    #[inline(always)]
    fn respond(
        &mut self,
        seats: &LaneInputs<N>,
        i: usize,
        ir: T::Ints,
        photo: [T::Mask; 2],
    ) -> T::Ints {
        let row = ir.shr(self.int(2)) | self.bit(photo[0], 8) | self.bit(photo[1], 16);
        self.rows_read = self.rows_read | row.bit();
        let lit_left = T::int_select(photo[0], self.word(seats, 1, i), self.word(seats, 0, i));
        let lit_right = T::int_select(photo[0], self.word(seats, 3, i), self.word(seats, 2, i));
        let word = T::int_select(photo[1], lit_right, lit_left);
        word.shr(ir)
    }

    #[inline(always)]
    fn word(&self, seats: &LaneInputs<N>, photo: usize, i: usize) -> T::Ints {
        T::int_load(self.cpu, &seats.words[photo][i])
    }
}
