//! The field model over lanes: the same operations in the same order as [`crate::World`], for `T::WIDTH` trials at once.
//!
//! Work that no lane needs is skipped. A skipped block is one that would change nothing in any lane: its tests are false in
//! all of them, with a margin of a pixel against rounding ([`Constants::cull_object_sq`] and its siblings). A block that runs
//! because one lane needs it writes the other lanes through a mask.

/// Repeats a block for each agent of a team; unrolled where the lanes are registers. The compiler leaves blocks as long as the
/// kernel's rolled up and the whole state in memory; unrolled, the frame of two and more agents takes 2 to 13 % less. Lanes
/// in plain arrays are better left to the compiler, which needs half as long again for them unrolled (both measured).
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

mod chance;
mod drive;
mod obstacles;
mod sense;

use super::results::Results;
use super::seats::{Seats, WIDEST};
use super::{Ints, Lanes, Mask};
use crate::constants::Constants;
use crate::obstacle::Obstacles;
use crate::preset::Contact;

/// One value per agent.
type Team<T, const N: usize> = [T; N];

/// The state of `T::WIDTH` fields with `N` agents each; a kernel of its own for fields with walls or posts, so that nobody
/// else pays for them.
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
    /// Frames since the trial began.
    frame: T::Ints,
    rows_read: T::Ints,
    reached_frame: T::Ints,
    /// The stream of noise; nobody reads it without noise.
    noise: T::Ints,
    /// What each agent may see or touch in this frame.
    near: Team<Near, N>,
    /// How many agents touch and face the object at the start of the frame.
    facing: T::Ints,
    /// Whether any lane's object is elsewhere than when arrivals were last noted.
    object_moved: bool,
}

/// What an agent may see by IR or touch in this frame in some lane. Until bodies meet, an agent moves no further than its
/// wheels turn: what is not near at the start of the frame stays out of reach until then.
#[derive(Clone, Copy, Default)]
struct Near {
    walls: bool,
    obstacles: bool,
    object: bool,
    agents: bool,
}

/// All that moves, and all that the next frame depends on.
pub(in crate::lanes) struct Stance<T, const N: usize> {
    x: Team<T, N>,
    y: Team<T, N>,
    cos: Team<T, N>,
    sin: Team<T, N>,
    object_x: T,
    object_y: T,
}

impl<'a, T: Lanes, const N: usize, const WALLED: bool> Fields<'a, T, N, WALLED> {
    /// Empty fields.
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

    /// Begins the trials of `seats` in the lanes of the mask.
    #[inline(always)]
    pub(in crate::lanes) fn admit(&mut self, lanes: T::Mask, seats: &Seats<N>) {
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

    /// One frame of every field.
    #[inline(always)]
    pub(in crate::lanes) fn advance(&mut self, seats: &Seats<N>) {
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

    /// `value` in the lanes of the mask, 0 elsewhere.
    #[inline(always)]
    fn bit(&self, mask: T::Mask, value: i32) -> T::Ints {
        T::int_select(mask, self.int(value), self.int(0))
    }

    /// Which lanes of agent `i` overlap the object, the vector from agent to object and its squared length.
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
    fn note_arrivals(&mut self) {
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

    /// One bit per lane whose trial is at this frame.
    #[inline(always)]
    pub(in crate::lanes) fn at_frame(&self, frame: u32) -> u32 {
        T::is_zero(self.frame + self.int(-(frame as i32))).bits()
    }

    /// One bit per lane that is where it was `before`, and goes on from there as it did then.
    #[inline(always)]
    pub(in crate::lanes) fn back_at(&self, before: &Stance<T, N>) -> u32 {
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

    /// All that moves.
    #[inline(always)]
    pub(in crate::lanes) fn stance(&self) -> Stance<T, N> {
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

    /// What every lane came to so far.
    #[inline(always)]
    pub(in crate::lanes) fn measure(&self) -> Results<N> {
        let mut results = Results {
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
