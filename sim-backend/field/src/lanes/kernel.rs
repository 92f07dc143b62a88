//! The field model over lanes: the same operations in the same order as [`crate::World`], for `T::WIDTH` trials at once.
//!
//! Work that no lane needs is skipped. A skipped block is one that would change nothing in any lane: its tests are false in
//! all of them, with a margin of a pixel against rounding ([`Constants::cull_object_sq`] and its siblings). A block that runs
//! because one lane needs it writes the other lanes through a mask.

use super::seats::{Seats, WIDEST};
use super::{Ints, Lanes, Mask};
use crate::model::{COINCIDENT_SQ, Constants, FIELD_PX};
use crate::preset::Contact;
use crate::trial::Outcome;

/// One value per agent.
type Team<T, const N: usize> = [T; N];

/// The state of `T::WIDTH` fields with `N` agents each.
pub(super) struct Fields<'a, T: Lanes, const N: usize> {
    cpu: T::Cpu,
    c: &'a Constants,
    x: Team<T, N>,
    y: Team<T, N>,
    heading: Team<T::Ints, N>,
    cos: Team<T, N>,
    sin: Team<T, N>,
    object_x: T,
    object_y: T,
    goal_x: T,
    goal_y: T,
    /// Frames since the trial began.
    frame: T::Ints,
    rows_read: T::Ints,
    reached_frame: T::Ints,
    /// Agents of which no lane is near a wall in this frame.
    clear_of_walls: Team<bool, N>,
    /// How many agents touch and face the object at the start of the frame.
    facing: T::Ints,
    /// Whether any lane's object is elsewhere than when arrivals were last noted.
    object_moved: bool,
}

/// All that moves: where it does not change in a frame, it never will, because a frame depends on nothing else.
pub(super) struct Stance<T, const N: usize> {
    x: Team<T, N>,
    y: Team<T, N>,
    cos: Team<T, N>,
    sin: Team<T, N>,
    object_x: T,
    object_y: T,
}

/// A target in the frame of the agent that looks.
#[derive(Clone, Copy)]
struct Ray<T> {
    ahead: T,
    left: T,
    distance_sq: T,
}

impl<'a, T: Lanes, const N: usize> Fields<'a, T, N> {
    /// Empty fields.
    #[inline(always)]
    pub(super) fn new(cpu: T::Cpu, c: &'a Constants) -> Self {
        let (zero, none) = (T::splat(cpu, 0.0), T::int_splat(cpu, 0));
        Self {
            cpu,
            c,
            x: [zero; N],
            y: [zero; N],
            heading: [none; N],
            cos: [zero; N],
            sin: [zero; N],
            object_x: zero,
            object_y: zero,
            goal_x: zero,
            goal_y: zero,
            frame: none,
            rows_read: none,
            reached_frame: none,
            clear_of_walls: [false; N],
            facing: none,
            object_moved: false,
        }
    }

    /// Begins the trials of `seats` in the lanes of the mask.
    #[inline(always)]
    pub(super) fn admit(&mut self, lanes: T::Mask, seats: &Seats<N>) {
        let (zero, none) = (self.v(0.0), self.int(0));
        for i in 0..N {
            self.x[i] = T::select(lanes, T::load(self.cpu, &seats.x[i]), self.x[i]);
            self.y[i] = T::select(lanes, T::load(self.cpu, &seats.y[i]), self.y[i]);
            self.heading[i] = T::int_select(
                lanes,
                T::int_load(self.cpu, &seats.heading[i]),
                self.heading[i],
            );
            (self.cos[i], self.sin[i]) = T::cos_sin(self.heading[i]);
        }
        self.object_moved = true;
        self.object_x = T::select(lanes, zero, self.object_x);
        self.object_y = T::select(lanes, zero, self.object_y);
        self.goal_x = T::load(self.cpu, &seats.goal_x);
        self.goal_y = T::load(self.cpu, &seats.goal_y);
        self.frame = T::int_select(lanes, none, self.frame);
        self.rows_read = T::int_select(lanes, none, self.rows_read);
        self.reached_frame = T::int_select(lanes, none, self.reached_frame);
    }

    /// One frame of every field.
    #[inline(always)]
    pub(super) fn advance(&mut self, seats: &Seats<N>) {
        let codes = self.sense(seats);
        match self.c.contact {
            Contact::Sliding => self.drive_sliding(codes),
            Contact::Blocking => self.drive_blocking(codes),
        }
        self.frame = self.frame + self.int(1);
        if self.object_moved {
            self.note_arrivals();
            self.object_moved = false;
        }
    }

    #[inline(always)]
    fn v(&self, value: f32) -> T {
        T::splat(self.cpu, value)
    }

    #[inline(always)]
    fn int(&self, value: i32) -> T::Ints {
        T::int_splat(self.cpu, value)
    }

    /// The response code of every agent.
    #[inline(always)]
    fn sense(&mut self, seats: &Seats<N>) -> Team<T::Ints, N> {
        let mut codes = self.see_agents();
        self.facing = self.int(0);
        for (i, code) in codes.iter_mut().enumerate() {
            let mut ir = *code;
            let object = self.ray(i, self.object_x - self.x[i], self.object_y - self.y[i]);
            if object.distance_sq.lt(self.v(self.c.cull_object_sq)).any() {
                ir = self.ir(ir, object, self.c.object_radius_sq);
                let touching = object.distance_sq.lt(self.v(self.c.facing_sq));
                self.facing = self.facing + self.bit(touching & self.v(0.0).lt(object.ahead), 1);
            }
            let farthest = self.x[i].abs().max(self.y[i].abs());
            self.clear_of_walls[i] = !self.v(self.c.cull_wall).lt(farthest).any();
            if !self.clear_of_walls[i] {
                ir = self.see_walls(ir, i);
            }
            let photo = self.see_lights(i, object);
            *code = self.look_up(seats, i, ir, photo);
        }
        codes
    }

    /// What the left and the right photo sensor of agent `i` see.
    #[inline(always)]
    fn see_lights(&self, i: usize, object: Ray<T>) -> [T::Mask; 2] {
        let by_object = self.photo(object, self.c.object_light_sq);
        let (dx, dy) = (self.goal_x - self.x[i], self.goal_y - self.y[i]);
        if !(dx * dx + dy * dy).lt(self.v(self.c.goal_light_sq)).any() {
            return by_object;
        }
        let by_goal = self.photo(self.ray(i, dx, dy), self.c.goal_light_sq);
        [by_object[0] | by_goal[0], by_object[1] | by_goal[1]]
    }

    #[inline(always)]
    fn ray(&self, i: usize, dx: T, dy: T) -> Ray<T> {
        Ray {
            ahead: dx * self.cos[i] + dy * self.sin[i],
            left: dy * self.cos[i] - dx * self.sin[i],
            distance_sq: dx * dx + dy * dy,
        }
    }

    /// What the IR sensors of every agent see of the other agents. What IR sensors see is written as 4 left, 8 front, 16
    /// right: four times their part of the row, which is how far to shift a table word.
    #[inline(always)]
    fn see_agents(&self) -> Team<T::Ints, N> {
        let mut ir = [self.int(0); N];
        let zero = self.v(0.0);
        for i in 0..N {
            for j in i + 1..N {
                let (dx, dy) = (self.x[j] - self.x[i], self.y[j] - self.y[i]);
                if (dx * dx + dy * dy).lt(self.v(self.c.cull_agent_sq)).any() {
                    ir[i] = self.ir(ir[i], self.ray(i, dx, dy), self.c.agent_radius_sq);
                    ir[j] = self.ir(
                        ir[j],
                        self.ray(j, zero - dx, zero - dy),
                        self.c.agent_radius_sq,
                    );
                }
            }
        }
        ir
    }

    /// Adds the IR sensors whose segments cut a circle.
    #[inline(always)]
    fn ir(&self, seen: T::Ints, Ray { ahead, left, .. }: Ray<T>, radius_sq: f32) -> T::Ints {
        let (cos, sin) = (self.v(self.c.ir_cos), self.v(self.c.ir_sin));
        let (ahead_cos, left_sin) = (ahead * cos, left * sin);
        let (left_cos, ahead_sin) = (left * cos, ahead * sin);
        seen | self.bit(self.cuts(ahead_cos + left_sin, left_cos - ahead_sin, radius_sq), 4)
            | self.bit(self.cuts(ahead, left, radius_sq), 8)
            | self.bit(self.cuts(ahead_cos - left_sin, left_cos + ahead_sin, radius_sq), 16)
    }

    /// Whether the segment straight ahead cuts a circle around this place.
    #[inline(always)]
    fn cuts(&self, ahead: T, left: T, radius_sq: f32) -> T::Mask {
        let zero = self.v(0.0);
        let beyond = (ahead - self.v(self.c.ir_range)).max(zero);
        zero.lt(ahead) & (beyond * beyond + left * left).lt(self.v(radius_sq))
    }

    /// Adds the IR sensors whose tips lie beyond a wall.
    #[inline(always)]
    fn see_walls(&self, seen: T::Ints, i: usize) -> T::Ints {
        let (side_cos, side_sin) = (self.v(self.c.ir_cos), self.v(self.c.ir_sin));
        let (cos_cos, sin_sin) = (self.cos[i] * side_cos, self.sin[i] * side_sin);
        let (cos_sin, sin_cos) = (self.cos[i] * side_sin, self.sin[i] * side_cos);
        seen | self.bit(self.tip_beyond_wall(i, cos_cos - sin_sin, sin_cos + cos_sin), 4)
            | self.bit(self.tip_beyond_wall(i, self.cos[i], self.sin[i]), 8)
            | self.bit(self.tip_beyond_wall(i, cos_cos + sin_sin, sin_cos - cos_sin), 16)
    }

    #[inline(always)]
    fn tip_beyond_wall(&self, i: usize, cos: T, sin: T) -> T::Mask {
        let range = self.v(self.c.ir_range);
        let (x, y) = (
            (self.x[i] + range * cos).abs(),
            (self.y[i] + range * sin).abs(),
        );
        self.v(FIELD_PX).lt(x.max(y))
    }

    /// Whether the left and the right photo sensor see a light.
    #[inline(always)]
    fn photo(&self, Ray { ahead, left, distance_sq }: Ray<T>, range_sq: f32) -> [T::Mask; 2] {
        let near = distance_sq.lt(self.v(range_sq));
        let (ahead, left) = (ahead * self.v(self.c.photo_cos), left * self.v(self.c.photo_sin));
        [
            near & self.in_cone(ahead + left, distance_sq),
            near & self.in_cone(ahead - left, distance_sq),
        ]
    }

    /// Whether a light this far along a photo sensor's axis is inside its cone.
    #[inline(always)]
    fn in_cone(&self, along: T, distance_sq: T) -> T::Mask {
        let forward = self.v(0.0).lt(along);
        if self.c.cone_sq == 0.0 {
            return forward;
        }
        forward & (self.v(self.c.cone_sq) * distance_sq).lt(along * along)
    }

    /// Agent `i`'s response code in its lowest four bits; notes the row that was read.
    #[inline(always)]
    fn look_up(&mut self, seats: &Seats<N>, i: usize, ir: T::Ints, photo: [T::Mask; 2]) -> T::Ints {
        let row = ir.shr(self.int(2)) | self.bit(photo[0], 8) | self.bit(photo[1], 16);
        self.rows_read = self.rows_read | self.int(1).shl(row);
        let lit_left = T::int_select(photo[0], self.word(seats, 1, i), self.word(seats, 0, i));
        let lit_right = T::int_select(photo[0], self.word(seats, 3, i), self.word(seats, 2, i));
        let word = T::int_select(photo[1], lit_right, lit_left);
        word.shr(ir)
    }

    #[inline(always)]
    fn word(&self, seats: &Seats<N>, photo: usize, i: usize) -> T::Ints {
        T::int_load(self.cpu, &seats.words[photo][i])
    }

    /// `value` in the lanes of the mask, 0 elsewhere.
    #[inline(always)]
    fn bit(&self, mask: T::Mask, value: i32) -> T::Ints {
        T::int_select(mask, self.int(value), self.int(0))
    }

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
    fn drive_sliding(&mut self, codes: Team<T::Ints, N>) {
        for i in 0..N {
            (self.x[i], self.y[i]) = self.turn_and_step(i, codes[i]);
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

    /// Which lanes of agent `i` overlap the object, the vector from agent to object and its squared length.
    #[inline(always)]
    fn overlap(&self, i: usize) -> (T::Mask, T, T, T) {
        let (dx, dy) = (self.object_x - self.x[i], self.object_y - self.y[i]);
        let sq = dx * dx + dy * dy;
        (sq.lt(self.v(self.c.touch_sq)), dx, dy, sq)
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
    fn drive_blocking(&mut self, codes: Team<T::Ints, N>) {
        let push = self.push_for(self.facing);
        for i in 0..N {
            let (mut x, mut y) = self.turn_and_step(i, codes[i]);
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

    #[inline(always)]
    fn goal_distance_sq(&self) -> T {
        let (dx, dy) = (self.object_x - self.goal_x, self.object_y - self.goal_y);
        dx * dx + dy * dy
    }

    #[inline(always)]
    fn note_arrivals(&mut self) {
        let beyond = self.v(self.c.goal_radius_sq).lt(self.goal_distance_sq());
        let first = T::int_select(
            T::is_zero(self.reached_frame),
            self.frame,
            self.reached_frame,
        );
        self.reached_frame = T::int_select(beyond, self.reached_frame, first);
    }

    /// One bit per lane whose trial is at this frame.
    #[inline(always)]
    pub(super) fn at_frame(&self, frame: u32) -> u32 {
        T::is_zero(self.frame + self.int(-(frame as i32))).bits()
    }

    /// One bit per lane in which nothing moved since `before`.
    #[inline(always)]
    pub(super) fn unmoved_since(&self, before: &Stance<T, N>) -> u32 {
        let mut same = self.object_x.eq(before.object_x) & self.object_y.eq(before.object_y);
        for i in 0..N {
            same = same & self.x[i].eq(before.x[i]) & self.y[i].eq(before.y[i]);
            same = same & self.cos[i].eq(before.cos[i]) & self.sin[i].eq(before.sin[i]);
        }
        same.bits()
    }

    /// All that moves.
    #[inline(always)]
    pub(super) fn stance(&self) -> Stance<T, N> {
        let Self {
            x,
            y,
            cos,
            sin,
            object_x,
            object_y,
            ..
        } = *self;
        Stance {
            x,
            y,
            cos,
            sin,
            object_x,
            object_y,
        }
    }

    /// The outcome of every lane, were its trial over now; `executed` is left empty.
    #[inline(always)]
    pub(super) fn measure(&self) -> [Outcome; WIDEST] {
        let mut outcomes = [Outcome::default(); WIDEST];
        let (mut floats, mut ints) = ([0.0; WIDEST], [0; WIDEST]);
        self.goal_distance_sq().sqrt().store(&mut floats);
        for (outcome, &value) in outcomes.iter_mut().zip(&floats) {
            outcome.evaluated.goal_px = value;
        }
        for i in 0..N {
            let (_, _, _, sq) = self.overlap(i);
            sq.sqrt().store(&mut floats);
            for (outcome, &value) in outcomes.iter_mut().zip(&floats) {
                outcome.evaluated.agents_px[i] = value;
            }
        }
        self.rows_read.store(&mut ints);
        for (outcome, &value) in outcomes.iter_mut().zip(&ints) {
            outcome.rows_read = value as u32;
        }
        self.reached_frame.store(&mut ints);
        for (outcome, &value) in outcomes.iter_mut().zip(&ints) {
            outcome.reached_frame = value as u32;
        }
        outcomes
    }
}
