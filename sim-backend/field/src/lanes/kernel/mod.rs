//! Field model over lanes: operations of [`crate::World`] in the same order, for `T::WIDTH` trials.
//!
//! A block is skipped only if it changes nothing in any lane, with a margin of one pixel against
//! rounding ([`Constants::cull_object_sq`]). Otherwise a mask protects the other lanes.

/// Repeats a block per agent, unrolled for register lanes. The compiler does not unroll long blocks
/// and keeps the state in memory; unrolling saves 2 to 13 % per frame with two or more agents.
/// Array lanes take half as long again if unrolled. Both measured.
macro_rules! each_agent {
    ($i:ident of $team:ident $body:block) => {
        each_agent!($i of $team $body, 0 1 2 3)
    };
    ($i:ident of $team:ident $body:block, $($agent:literal)*) => {
        if T::REGISTERS {
            $(if $team > $agent {
                let $i = $agent;
                $body
            })*
        } else {
            let mut agent = 0;
            while agent < $team {
                let $i = agent;
                $body
                agent += 1;
            }
        }
    };
}

mod drive;
mod noise;
mod obstacles;
mod sense;

use super::inputs::{LaneInputs, WIDEST};
use super::results::LaneResults;
use super::{Ints, Lanes, Mask};
use crate::constants::Constants;
use crate::obstacle::Obstacles;
use crate::preset::Contact;

type Team<T, const N: usize> = [T; N];

/// State of `T::WIDTH` fields. Fields with obstacles have a separate kernel, which keeps the others
/// fast.
pub(in crate::lanes) struct Fields<'a, T: Lanes, const N: usize, const WALLED: bool> {
    cpu: T::Cpu,
    c: &'a Constants,
    obstacles: &'a Obstacles,
    x: Team<T, N>,
    y: Team<T, N>,
    heading: Team<T::Ints, N>,
    cos: Team<T, N>,
    sin: Team<T, N>,
    object_x: T,
    object_y: T,
    goal_x: T,
    goal_y: T,
    /// Frames since the start.
    frame: T::Ints,
    rows_read: T::Ints,
    reached_frame: T::Ints,
    noise: T::Ints,
    near: Team<Near, N>,
    /// Agents that touch and face the object at the start of the frame.
    facing: T::Ints,
    /// True if any object moved since the last arrival check.
    object_moved: bool,
}

/// Bodies that an agent may detect or touch in this frame in some lane. Other bodies stay out of
/// reach until bodies meet, because only wheels move an agent until then.
#[derive(Clone, Copy, Default)]
struct Near {
    walls: bool,
    obstacles: bool,
    object: bool,
    agents: bool,
}

/// Dynamic state; without noise the next frame depends on nothing else.
pub(in crate::lanes) struct State<T, const N: usize> {
    x: Team<T, N>,
    y: Team<T, N>,
    cos: Team<T, N>,
    sin: Team<T, N>,
    object_x: T,
    object_y: T,
}

impl<'a, T: Lanes, const N: usize, const WALLED: bool> Fields<'a, T, N, WALLED> {
    #[inline(always)]
    pub(in crate::lanes) fn new(cpu: T::Cpu, c: &'a Constants, obstacles: &'a Obstacles) -> Self {
        let (zero, none) = (T::splat(cpu, 0.0), T::int_splat(cpu, 0));
        Self {
            cpu,
            c,
            obstacles,
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
            noise: none,
            near: [Near::default(); N],
            facing: none,
            object_moved: false,
        }
    }

    /// Starts the trials of `inputs` in the lanes of the mask.
    #[inline(always)]
    pub(in crate::lanes) fn start_trials(&mut self, lanes: T::Mask, seats: &LaneInputs<N>) {
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
        let noise = T::int_load(self.cpu, &seats.noise);
        self.noise = T::int_select(lanes, noise, self.noise);
    }

    #[inline(always)]
    pub(in crate::lanes) fn advance(&mut self, seats: &LaneInputs<N>) {
        let codes = self.sense(seats);
        match self.c.contact {
            Contact::Sliding => self.drive_sliding(codes),
            Contact::Blocking => self.drive_blocking(codes),
        }
        self.frame = self.frame + self.int(1);
        if self.object_moved {
            self.record_arrivals();
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

    /// `value` in the lanes of the mask, else 0.
    #[inline(always)]
    fn bit(&self, mask: T::Mask, value: i32) -> T::Ints {
        T::int_select(mask, self.int(value), self.int(0))
    }

    /// Lanes in which agent `i` overlaps the object, the vector to the object, its squared length.
    #[inline(always)]
    fn overlap(&self, i: usize) -> (T::Mask, T, T, T) {
        let (dx, dy) = (self.object_x - self.x[i], self.object_y - self.y[i]);
        let sq = dx * dx + dy * dy;
        (sq.lt(self.v(self.c.touch_sq)), dx, dy, sq)
    }

    #[inline(always)]
    fn goal_distance_sq(&self) -> T {
        let (dx, dy) = (self.object_x - self.goal_x, self.object_y - self.goal_y);
        dx * dx + dy * dy
    }

    #[inline(always)]
    fn record_arrivals(&mut self) {
        let beyond = self.v(self.c.goal_radius_sq).lt(self.goal_distance_sq());
        if beyond.all() {
            return;
        }
        let first = T::int_select(
            T::is_zero(self.reached_frame),
            self.frame,
            self.reached_frame,
        );
        self.reached_frame = T::int_select(beyond, self.reached_frame, first);
    }

    /// Lanes at this frame.
    #[inline(always)]
    pub(in crate::lanes) fn at_frame(&self, frame: u32) -> u32 {
        T::is_zero(self.frame + self.int(-(frame as i32))).bits()
    }

    /// Lanes whose state equals `before`; none with noise.
    #[inline(always)]
    pub(in crate::lanes) fn equals_state(&self, before: &State<T, N>) -> u32 {
        if !self.c.noise.is_none() {
            return 0;
        }
        let mut same = self.object_x.eq(before.object_x) & self.object_y.eq(before.object_y);
        for i in 0..N {
            same = same & self.x[i].eq(before.x[i]) & self.y[i].eq(before.y[i]);
            same = same & self.cos[i].eq(before.cos[i]) & self.sin[i].eq(before.sin[i]);
        }
        same.bits()
    }

    #[inline(always)]
    pub(in crate::lanes) fn state(&self) -> State<T, N> {
        let Self {
            x,
            y,
            cos,
            sin,
            object_x,
            object_y,
            ..
        } = *self;
        State {
            x,
            y,
            cos,
            sin,
            object_x,
            object_y,
        }
    }

    #[inline(always)]
    pub(in crate::lanes) fn measure(&self) -> LaneResults<N> {
        let mut results = LaneResults {
            goal_px: [0.0; WIDEST],
            agents_px: [[0.0; WIDEST]; N],
            rows_read: [0; WIDEST],
            reached_frame: [0; WIDEST],
        };
        self.goal_distance_sq().sqrt().store(&mut results.goal_px);
        for (i, agent_px) in results.agents_px.iter_mut().enumerate() {
            let (_, _, _, sq) = self.overlap(i);
            sq.sqrt().store(agent_px);
        }
        self.rows_read.store(&mut results.rows_read);
        self.reached_frame.store(&mut results.reached_frame);
        results
    }
}
