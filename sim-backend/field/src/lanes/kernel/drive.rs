//! How agents turn and drive, and how bodies meet.

use super::{Fields, Team};
use crate::constants::COINCIDENT_SQ;
use crate::lanes::{Ints, Lanes, Mask};

impl<T: Lanes, const N: usize> Fields<'_, T, N> {
    /// Turns agent `i` and says where it would go.
    #[inline(always)]
    fn turn_and_step(&mut self, i: usize, code: T::Ints) -> (T, T) {
        let (turn, travel) = T::drive(code, &self.c.travel);
        self.heading[i] = self.heading[i] + turn;
        (self.cos[i], self.sin[i]) = T::cos_sin(self.heading[i]);
        let (x, y) = (
            self.x[i] + travel * self.cos[i],
            self.y[i] + travel * self.sin[i],
        );
        if self.clear_of_walls[i] {
            (x, y)
        } else {
            (self.inside(x), self.inside(y))
        }
    }

    /// An agent's coordinate, clamped into the field.
    #[inline(always)]
    fn inside(&self, coordinate: T) -> T {
        self.clamp(coordinate, self.c.agent_limit)
    }

    #[inline(always)]
    fn clamp(&self, coordinate: T, limit: f32) -> T {
        coordinate.max(self.v(-limit)).min(self.v(limit))
    }

    #[inline(always)]
    pub(super) fn drive_sliding(&mut self, codes: Team<T::Ints, N>) {
        for (i, &code) in codes.iter().enumerate() {
            (self.x[i], self.y[i]) = self.turn_and_step(i, code);
        }
        self.separate_agents();
        self.push_object();
    }

    #[inline(always)]
    fn separate_agents(&mut self) {
        for i in 0..N {
            for j in i + 1..N {
                let (dx, dy) = (self.x[j] - self.x[i], self.y[j] - self.y[i]);
                let sq = dx * dx + dy * dy;
                let meet = sq.lt(self.v(self.c.pair_sq));
                if meet.any() {
                    let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
                    let share = self.v(0.5) * (self.v(self.c.pair) - distance) / distance;
                    let share = T::select(meet, share, self.v(0.0));
                    let (sx, sy) = (share * dx, share * dy);
                    (self.x[i], self.y[i]) = (self.x[i] - sx, self.y[i] - sy);
                    (self.x[j], self.y[j]) = (self.x[j] + sx, self.y[j] + sy);
                }
            }
        }
        for i in 0..N {
            (self.x[i], self.y[i]) = (self.inside(self.x[i]), self.inside(self.y[i]));
        }
    }

    #[inline(always)]
    fn push_object(&mut self) {
        let zero = self.v(0.0);
        let (mut sum_x, mut sum_y, mut deepest) = (zero, zero, zero);
        let (mut pushers, mut pushed) = (self.int(0), T::mask(self.cpu, 0));
        for i in 0..N {
            let (touch, dx, dy, sq) = self.overlap(i);
            if touch.any() {
                let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
                let overlap = T::select(touch, self.v(self.c.touch) - distance, zero);
                let per_px = overlap / distance;
                (sum_x, sum_y) = (sum_x + per_px * dx, sum_y + per_px * dy);
                deepest = deepest.max(overlap);
                pushers = pushers + self.bit(touch, 1);
                pushed = pushed | touch;
            }
        }
        if !pushed.any() {
            return;
        }
        self.object_moved = true;
        let sum_sq = sum_x * sum_x + sum_y * sum_y;
        let capped = deepest / sum_sq.max(self.v(COINCIDENT_SQ)).sqrt();
        let capped = T::select((deepest * deepest).lt(sum_sq), capped, self.v(1.0));
        let part = capped * self.push_for(pushers);
        self.object_x = self.clamp(self.object_x + part * sum_x, self.c.object_limit);
        self.object_y = self.clamp(self.object_y + part * sum_y, self.c.object_limit);
        for i in 0..N {
            let (touch, dx, dy, sq) = self.overlap(i);
            let touch = touch & pushed;
            if touch.any() {
                let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
                let per_px = T::select(touch, (self.v(self.c.touch) - distance) / distance, zero);
                (self.x[i], self.y[i]) = (
                    self.inside(self.x[i] - per_px * dx),
                    self.inside(self.y[i] - per_px * dy),
                );
            }
        }
    }

    /// The part of an overlap that the object yields to this many agents.
    #[inline(always)]
    fn push_for(&self, agents: T::Ints) -> T {
        let alone = T::is_zero(agents.shr(self.int(1)));
        T::select(alone, self.v(self.c.solo_push), self.v(self.c.team_push))
    }

    #[inline(always)]
    pub(super) fn drive_blocking(&mut self, codes: Team<T::Ints, N>) {
        let push = self.push_for(self.facing);
        for (i, &code) in codes.iter().enumerate() {
            let (mut x, mut y) = self.turn_and_step(i, code);
            let mut blocked = self.others_press(i, (self.x[i], self.y[i]), (x, y), self.c.pair_sq);
            let (dx, dy) = (self.object_x - x, self.object_y - y);
            let sq = dx * dx + dy * dy;
            let touch = sq.lt(self.v(self.c.touch_sq));
            if touch.any() {
                let sq = sq.max(self.v(COINCIDENT_SQ));
                let overlap = sq.sqrt() * (self.v(self.c.touch) / sq) - self.v(1.0);
                let overlap = T::select(touch, overlap, self.v(0.0));
                let yielded = overlap * push;
                let refused = overlap - yielded;
                let (object_x, object_y) =
                    (self.object_x + yielded * dx, self.object_y + yielded * dy);
                let walled = self
                    .v(self.c.object_limit)
                    .lt(object_x.abs().max(object_y.abs()));
                let pressed = self.others_press(
                    i,
                    (self.object_x, self.object_y),
                    (object_x, object_y),
                    self.c.touch_sq,
                );
                blocked = blocked | (touch & (walled | pressed));
                x = self.inside(x - refused * dx);
                y = self.inside(y - refused * dy);
                self.object_moved = true;
                self.object_x = T::select(blocked, self.object_x, object_x);
                self.object_y = T::select(blocked, self.object_y, object_y);
            }
            self.x[i] = T::select(blocked, self.x[i], x);
            self.y[i] = T::select(blocked, self.y[i], y);
        }
    }

    /// Lanes in which a body going `from` → `to` would come closer than contact to an agent other than `i`, and closer than
    /// it was.
    #[inline(always)]
    fn others_press(&self, i: usize, from: (T, T), to: (T, T), contact_sq: f32) -> T::Mask {
        let mut press = T::mask(self.cpu, 0);
        for j in 0..N {
            if j != i {
                let after = self.distance_sq(j, to);
                let contact = after.lt(self.v(contact_sq));
                if contact.any() {
                    press = press | (contact & after.lt(self.distance_sq(j, from)));
                }
            }
        }
        press
    }

    #[inline(always)]
    fn distance_sq(&self, j: usize, (x, y): (T, T)) -> T {
        let (dx, dy) = (self.x[j] - x, self.y[j] - y);
        dx * dx + dy * dy
    }
}
