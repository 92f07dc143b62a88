//! Motion of the agents and contact between bodies.

use super::{Fields, Team};
use crate::arithmetic::COINCIDENT_SQ;
use crate::lanes::{Ints, Lanes, Mask};
use crate::obstacle::Body;

impl<T: Lanes, const N: usize, const WALLED: bool> Fields<'_, T, N, WALLED> {
    /// Turns agent `i`; returns its target position.
    #[inline(always)]
    fn turn_and_step(&mut self, i: usize, code: T::Ints) -> (T, T) {
        let (turn, travel) = T::drive(code, &self.c.travel);
        self.heading[i] = self.heading[i] + turn;
        (self.cos[i], self.sin[i]) = T::cos_sin(self.heading[i]);
        let (x, y) = (
            self.x[i] + travel * self.cos[i],
            self.y[i] + travel * self.sin[i],
        );
        if self.near[i].walls {
            (self.inside(x), self.inside(y))
        } else {
            (x, y)
        }
    }

    #[inline(always)]
    fn inside(&self, coordinate: T) -> T {
        self.clamp(coordinate, self.c.agent_limit)
    }

    #[inline(always)]
    fn clamp(&self, coordinate: T, limit: f32) -> T {
        coordinate.clamp(self.v(limit))
    }

    #[inline(always)]
    pub(super) fn drive_sliding(&mut self, codes: Team<T::Ints, N>) {
        each_agent!(i of N {
            let from = (self.x[i], self.y[i]);
            let to = self.turn_and_step(i, codes[i]);
            (self.x[i], self.y[i]) = match WALLED && self.near[i].obstacles {
                true => self.move_or_stay(Body::Agent, from, to),
                false => to,
            };
        });
        let met = self.separate_agents();
        self.push_object(met);
    }

    /// Returns true if any agents met.
    #[inline(always)]
    fn separate_agents(&mut self) -> bool {
        let mut met = false;
        let before = (self.x, self.y);
        each_agent!(i of N {
            each_agent!(j of N {
                if i < j && (met || self.near[i].agents && self.near[j].agents) {
                    met |= self.separate(i, j);
                }
            });
        });
        if met {
            each_agent!(i of N {
                let to = (self.inside(self.x[i]), self.inside(self.y[i]));
                (self.x[i], self.y[i]) = self.move_or_stay(Body::Agent, (before.0[i], before.1[i]), to);
            });
        }
        met
    }

    #[inline(always)]
    fn separate(&mut self, i: usize, j: usize) -> bool {
        let (dx, dy) = (self.x[j] - self.x[i], self.y[j] - self.y[i]);
        let sq = dx * dx + dy * dy;
        let meet = sq.lt(self.v(self.c.pair_sq));
        if !meet.any() {
            return false;
        }
        let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
        let share = self.v(0.5) * (self.v(self.c.pair) - distance) / distance;
        let share = T::select(meet, share, self.v(0.0));
        let (sx, sy) = (share * dx, share * dy);
        (self.x[i], self.y[i]) = (self.x[i] - sx, self.y[i] - sy);
        (self.x[j], self.y[j]) = (self.x[j] + sx, self.y[j] + sy);
        true
    }

    #[inline(always)]
    fn push_object(&mut self, met: bool) {
        let zero = self.v(0.0);
        let (mut sum_x, mut sum_y, mut deepest) = (zero, zero, zero);
        let (mut pushers, mut pushed) = (self.int(0), T::mask(self.cpu, 0));
        each_agent!(i of N {
            if met || self.near[i].object {
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
        });
        if !pushed.any() {
            return;
        }
        self.object_moved = true;
        let sum_sq = sum_x * sum_x + sum_y * sum_y;
        let capped = deepest / sum_sq.max(self.v(COINCIDENT_SQ)).sqrt();
        let capped = T::select((deepest * deepest).lt(sum_sq), capped, self.v(1.0));
        let part = capped * self.push_for(pushers);
        let from = (self.object_x, self.object_y);
        let to = (
            self.clamp(from.0 + part * sum_x, self.c.object_limit),
            self.clamp(from.1 + part * sum_y, self.c.object_limit),
        );
        (self.object_x, self.object_y) = self.move_or_stay(Body::Object, from, to);
        each_agent!(i of N { self.move_back(i, pushed) });
    }

    /// Moves agent `i` out of a pushed object.
    #[inline(always)]
    fn move_back(&mut self, i: usize, pushed: T::Mask) {
        let (touch, dx, dy, sq) = self.overlap(i);
        let touch = touch & pushed;
        if touch.any() {
            let distance = sq.max(self.v(COINCIDENT_SQ)).sqrt();
            let per_px = (self.v(self.c.touch) - distance) / distance;
            let per_px = T::select(touch, per_px, self.v(0.0));
            let to = (
                self.inside(self.x[i] - per_px * dx),
                self.inside(self.y[i] - per_px * dy),
            );
            (self.x[i], self.y[i]) = self.move_or_stay(Body::Agent, (self.x[i], self.y[i]), to);
        }
    }

    /// Share of an overlap that the object yields to these agents.
    #[inline(always)]
    fn push_for(&self, agents: T::Ints) -> T {
        let [one, two, three, four] = self.c.push;
        let mut several = self.v(two);
        if N > 2 && (two != three || two != four) {
            several = T::select(self.count_equals(agents, 3), self.v(three), several);
            several = T::select(self.count_equals(agents, 4), self.v(four), several);
        }
        let alone = T::is_zero(agents.shr(self.int(1)));
        T::select(alone, self.v(one), several)
    }

    #[inline(always)]
    fn count_equals(&self, agents: T::Ints, count: i32) -> T::Mask {
        T::is_zero(agents + self.int(-count))
    }

    #[inline(always)]
    pub(super) fn drive_blocking(&mut self, codes: Team<T::Ints, N>) {
        let push = self.push_for(self.facing);
        let mut met = false;
        each_agent!(i of N {
            self.drive_unless_blocked(i, codes[i], push, &mut met);
        });
    }

    /// Sets `met` if the agent touches the object.
    #[inline(always)]
    fn drive_unless_blocked(&mut self, i: usize, code: T::Ints, push: T, met: &mut bool) {
        let from = (self.x[i], self.y[i]);
        let mut to = self.turn_and_step(i, code);
        let mut blocked = T::mask(self.cpu, 0);
        if WALLED && self.near[i].obstacles {
            (to, blocked) = self.resolve_move(Body::Agent, from, to);
        }
        if *met || self.near[i].agents {
            blocked = blocked | self.would_press_other_agent(i, from, to, self.c.pair_sq);
        }
        if *met || self.near[i].object {
            *met |= self.push_ahead(i, &mut to, &mut blocked, push);
        }
        self.x[i] = T::select(blocked, from.0, to.0);
        self.y[i] = T::select(blocked, from.1, to.1);
    }

    /// Pushes the object on the way `to` a position, and holds back or blocks the agent. Returns
    /// true on contact.
    #[inline(always)]
    fn push_ahead(&mut self, i: usize, to: &mut (T, T), blocked: &mut T::Mask, push: T) -> bool {
        let (dx, dy) = (self.object_x - to.0, self.object_y - to.1);
        let sq = dx * dx + dy * dy;
        let touch = sq.lt(self.v(self.c.touch_sq));
        if !touch.any() {
            return false;
        }
        let sq = sq.max(self.v(COINCIDENT_SQ));
        let overlap = sq.sqrt() * (self.v(self.c.touch) / sq) - self.v(1.0);
        let overlap = T::select(touch, overlap, self.v(0.0));
        let yielded = overlap * push;
        let refused = overlap - yielded;
        let object = (self.object_x, self.object_y);
        let pushed = (object.0 + yielded * dx, object.1 + yielded * dy);
        let farthest = pushed.0.max_abs(pushed.1);
        let walled = self.v(self.c.object_limit).lt_among(farthest, touch);
        let pressed = self.would_press_other_agent(i, object, pushed, self.c.touch_sq);
        *blocked = *blocked | walled | (touch & pressed);
        let back = (
            self.inside(to.0 - refused * dx),
            self.inside(to.1 - refused * dy),
        );
        if WALLED {
            let barred = self.forbids_move(Body::Object, object, pushed);
            let (at, stopped) = self.resolve_move(Body::Agent, *to, back);
            *blocked = *blocked | (touch & barred) | stopped;
            *to = at;
        } else {
            *to = back;
        }
        self.object_moved = true;
        self.object_x = T::select(*blocked, object.0, pushed.0);
        self.object_y = T::select(*blocked, object.1, pushed.1);
        true
    }

    /// Lanes in which the move brings a body within contact of an agent other than `i`, and closer
    /// than before.
    #[inline(always)]
    fn would_press_other_agent(
        &self,
        i: usize,
        from: (T, T),
        to: (T, T),
        contact_sq: f32,
    ) -> T::Mask {
        let mut press = T::mask(self.cpu, 0);
        each_agent!(j of N {
            if j != i {
                let after = self.distance_sq(j, to);
                let contact = after.lt(self.v(contact_sq));
                if contact.any() {
                    press = press | after.lt_among(self.distance_sq(j, from), contact);
                }
            }
        });
        press
    }

    #[inline(always)]
    fn distance_sq(&self, j: usize, (x, y): (T, T)) -> T {
        let (dx, dy) = (self.x[j] - x, self.y[j] - y);
        dx * dx + dy * dy
    }
}
