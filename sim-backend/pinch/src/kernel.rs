//! Simulates a batch of trials, one per lane, in ticks of 1 ms with a reduced controller: probe,
//! table, arbitration limits, path.

use crate::body::{Body, STEP_S, STEPS_PER_TICK};
use crate::lanes::{Lanes, Mask};
use crate::percept::{Percept, TICK_S};
use crate::trial::{End, HOLD_S, Interface, LIFT_M, Object, Outcome, Rows, TimeLimit, Trial};

/// Speed of approach and probe, m/s; probe duration after first touch, s (paper II.b (1)).
const PROBE_M_S: f32 = 0.002;
const PROBE_S: f32 = 0.1;
/// Mean speed of the lift, m/s.
const LIFT_M_S: f32 = 0.01;
const PATH_S: f32 = LIFT_M / LIFT_M_S;
/// Backward hand motion that counts as refusal, s; missing contact that counts as loss, s
/// (controller).
const BACK_MAX_S: f32 = 0.25;
const LOST_AFTER_S: f32 = 0.05;
/// Arbitration: change per tick of the closing speed up and down, m/s, and of the hand's speed
/// factor (controller).
const CLOSING_UP_M_S: f32 = 0.1 * TICK_S;
const CLOSING_DOWN_M_S: f32 = 1.0 * TICK_S;
const CARRY_CHANGE: f32 = 50.0 * TICK_S;
/// Multiple of F_2 above which the gate only allows opening (controller).
const GATE_F2: f32 = 1.5;
/// Module 3: opening speed, m/s, above this multiple of F_2 (controller).
const RELIEVE_M_S: f32 = 0.001;
const RELIEVE_F2: f32 = 1.15;
/// Stiffness overestimate of the probe, mean and standard deviation (`BORDERLINE_SHARE` of the
/// evaluation).
const PROBE_BIAS: f32 = 0.06;
const PROBE_SCATTER: f32 = 0.04;
/// Tremble of the hand: frequencies, Hz, and amplitudes, m (tactile design).
const TREMBLE: [(f32, f32); 2] = [(12.0, 10e-6), (45.0, 2.5e-6)];
/// Limit after which every trial has timed out, even with the longest approach.
const TICKS_MAX: usize = 30_000;

#[inline(always)]
pub(crate) fn run<const N: usize>(
    interface: &Interface<'_>,
    trials: &[Trial],
    outcomes: &mut [Outcome],
) {
    let mut batch = Batch::<N>::new(interface, trials);
    for tick in 0..TICKS_MAX {
        batch.tick(tick);
        if batch.remaining == 0 {
            break;
        }
    }
    outcomes.copy_from_slice(&batch.outcomes[..trials.len()]);
}

struct Batch<'a, const N: usize> {
    interface: &'a Interface<'a>,
    rows: [Rows; N],
    body: Body<N>,
    percept: Percept<N>,
    noise: Noise<N>,
    tremble: [Oscillator<N>; 2],
    crush_n: Lanes<N>,
    f1_n: Lanes<N>,
    f2_n: Lanes<N>,
    probe_left_s: Lanes<N>,
    closing_m_s: Lanes<N>,
    carry: Lanes<N>,
    path_s: Lanes<N>,
    carried_m: Lanes<N>,
    time_s: Lanes<N>,
    held_s: Lanes<N>,
    back_s: Lanes<N>,
    no_contact_s: Lanes<N>,
    max_n: Lanes<N>,
    rows_read: [u64; N],
    outcomes: [Outcome; N],
    ended: [bool; N],
    remaining: usize,
}

impl<'a, const N: usize> Batch<'a, N> {
    #[inline(always)]
    fn new(interface: &'a Interface<'a>, trials: &[Trial]) -> Self {
        let zero = Lanes::splat(0.0);
        // Lanes without a trial repeat the first; their results are discarded.
        let of = |lane: usize| &trials[if lane < trials.len() { lane } else { 0 }];
        let seed = |lane: usize| of(lane).seed.wrapping_mul(0x9e37_79b9) | 1;
        let mut noise = Noise::<N>(core::array::from_fn(seed));
        let rows = core::array::from_fn(|lane| of(lane).rows);
        let _warm = [noise.next(), noise.next(), noise.next()];
        let found = noise.next() * PROBE_SCATTER + (1.0 + PROBE_BIAS);
        let thresholds = |which: usize| {
            Lanes::from_fn(|lane| {
                Object::thresholds_n(of(lane).object.stiffness_n_m * found.0[lane])[which]
            })
        };
        let object = |get: fn(&Object) -> f32| Lanes::from_fn(|lane| get(&of(lane).object));
        let tremble = TREMBLE.map(|(hz, _)| Oscillator::new(noise.next(), hz));
        Self {
            interface,
            rows,
            body: Body::new(
                object(|o| o.mass_kg),
                object(|o| o.friction),
                object(|o| o.stiffness_n_m),
            ),
            percept: Percept::new(),
            noise,
            tremble,
            crush_n: object(|o| o.crush_n),
            f1_n: thresholds(0),
            f2_n: thresholds(1),
            probe_left_s: Lanes::splat(PROBE_S),
            closing_m_s: zero,
            carry: Lanes::splat(1.0),
            path_s: zero,
            carried_m: zero,
            time_s: zero,
            held_s: zero,
            back_s: zero,
            no_contact_s: zero,
            max_n: zero,
            rows_read: [0; N],
            outcomes: [Outcome::NONE; N],
            ended: core::array::from_fn(|lane| lane >= trials.len()),
            remaining: trials.len(),
        }
    }

    #[inline(always)]
    fn tick(&mut self, tick: usize) {
        let mut most_n = self.max_n;
        for _ in 0..STEPS_PER_TICK {
            let mut tremble_m = Lanes::splat(0.0);
            for (rotor, (_, amplitude_m)) in self.tremble.iter_mut().zip(TREMBLE) {
                tremble_m = tremble_m + rotor.advance() * amplitude_m;
            }
            self.body.step(tremble_m);
            let [a, b, c] = self.body.normal_n;
            most_n = most_n.greater(a + b + c);
        }
        self.max_n = most_n;
        let noise = [self.noise.next(), self.noise.next()];
        let body = &self.body;
        self.percept
            .update(&body.normal_n, &body.shear_n, noise, tick);
        self.percept.update_bits(self.f2_n);
        let probes = self.probe_left_s.above(0.0);
        let (fingers_m_s, hand) = self.read_tables(probes);
        self.act(probes, fingers_m_s, hand);
        self.evaluate(probes);
    }

    /// Looks up the row of each table; records rows only after the probe.
    #[inline(always)]
    fn read_tables(&mut self, probes: Mask<N>) -> (Lanes<N>, Lanes<N>) {
        let mut row = [0_u32; N];
        for (index, bit) in self.interface.bits.iter().enumerate() {
            let reports = self.percept.bit(*bit, self.f1_n, self.carried_m);
            for (row, reports) in row.iter_mut().zip(reports.0) {
                *row |= (reports & 1) << index;
            }
        }
        let (mut fingers_m_s, mut hand) = (Lanes::splat(0.0), Lanes::splat(0.0));
        for (lane, row) in row.into_iter().enumerate() {
            let number = row as usize % 64;
            let levels = (self.rows[lane][number / 16] >> (number % 16 * 4)) as usize;
            fingers_m_s.0[lane] = self.interface.fingers_m_s[levels % 4];
            hand.0[lane] = self.interface.hand[levels / 4 % 4];
            let reads = u64::from(!probes.0[lane] & 1);
            self.rows_read[lane] |= reads << number;
        }
        (fingers_m_s, hand)
    }

    /// Arbitration and path.
    #[inline(always)]
    fn act(&mut self, probes: Mask<N>, fingers_m_s: Lanes<N>, hand: Lanes<N>) {
        let zero = Lanes::splat(0.0);
        let touching = self.percept.bit(crate::Bit::Touching, self.f1_n, zero);
        // At first touch a finger waits for the other: the probe starts from rest.
        let first = touching & self.probe_left_s.above(PROBE_S - TICK_S / 2.0);
        self.closing_m_s = first.select(zero, self.closing_m_s);
        self.probe_left_s = touching.select(self.probe_left_s - TICK_S, self.probe_left_s);
        let mut wanted = probes.select(Lanes::splat(PROBE_M_S), fingers_m_s);
        if self.interface.force_limit {
            let normal_n = self.percept.normal_n;
            let relieve = normal_n.gt(self.f2_n * RELIEVE_F2);
            let ceiling = relieve.select(Lanes::splat(-RELIEVE_M_S), zero);
            let ceiling = self
                .percept
                .is_above_f2()
                .select(ceiling, Lanes::splat(1.0));
            wanted = wanted.lesser(ceiling);
        }
        let gated = self.percept.normal_n.gt(self.f2_n * GATE_F2);
        let wanted = gated.select(wanted.lesser(zero), wanted);
        let up = wanted.gt(self.closing_m_s) & wanted.above(0.0);
        let most = up.select(Lanes::splat(CLOSING_UP_M_S), Lanes::splat(CLOSING_DOWN_M_S));
        let change = (wanted - self.closing_m_s)
            .lesser(most)
            .greater(zero - most);
        self.closing_m_s = self.closing_m_s + change;
        self.body.commanded_closing_m = self.body.commanded_closing_m + self.closing_m_s * TICK_S;
        let most = Lanes::splat(CARRY_CHANGE);
        let change = (hand - self.carry).lesser(most).greater(zero - most);
        self.carry = probes.select(self.carry, self.carry + change);
        let step_s = probes.select(zero, self.carry * TICK_S);
        self.path_s = (self.path_s + step_s)
            .greater(zero)
            .lesser(Lanes::splat(PATH_S));
        let tau = self.path_s * (1.0 / PATH_S);
        let share = tau * tau * tau * ((tau * 6.0 - 15.0) * tau + 10.0);
        self.carried_m = share * LIFT_M;
        self.body.commanded_hand_m = self.carried_m;
        let back = hand.below(0.0) & !probes;
        self.back_s = back.select(self.back_s + TICK_S, self.back_s);
        self.no_contact_s = touching.select(zero, self.no_contact_s + TICK_S);
    }

    /// Records both evaluations and ends finished trials.
    #[inline(always)]
    fn evaluate(&mut self, probes: Mask<N>) {
        self.time_s = probes.select(self.time_s, self.time_s + TICK_S);
        let arrived = self.path_s.above(PATH_S * (1.0 - 1e-6));
        let first = arrived & !self.held_s.above(0.0);
        self.held_s = arrived.select(self.held_s + TICK_S, self.held_s);
        let crushed = self.max_n.gt(self.crush_n);
        let refused = self.back_s.above(BACK_MAX_S);
        let lost = self.no_contact_s.above(LOST_AFTER_S) & !probes;
        let held = self.held_s.above(HOLD_S);
        let TimeLimit {
            constant_s,
            path_factor,
        } = self.interface.time_limit;
        let late =
            self.time_s.gt(self.path_s * path_factor + constant_s) | (probes & self.time_up());
        if !(first | crushed | refused | lost | held | late).any() {
            return;
        }
        for lane in 0..N {
            if self.ended[lane] {
                continue;
            }
            if first.0[lane] != 0 {
                self.outcomes[lane].raised_m[0] = self.body.raised_m.0[lane];
                self.outcomes[lane].slip_m[0] = self.body.slip_m.0[lane];
            }
            let end = match lane {
                _ if crushed.0[lane] != 0 => End::Crushed,
                _ if refused.0[lane] != 0 => End::Refused,
                _ if lost.0[lane] != 0 => End::Lost,
                _ if held.0[lane] != 0 => End::Arrived,
                _ if late.0[lane] != 0 => End::TimedOut,
                _ => continue,
            };
            self.end(lane, end);
        }
    }

    /// Fingers closed without contact.
    #[inline(always)]
    fn time_up(&self) -> Mask<N> {
        self.body.commanded_closing_m.above(0.01)
    }

    fn end(&mut self, lane: usize, end: End) {
        let outcome = &mut self.outcomes[lane];
        outcome.end = end;
        outcome.raised_m[1] = self.body.raised_m.0[lane];
        outcome.slip_m[1] = self.body.slip_m.0[lane];
        outcome.normal_n = self
            .body
            .normal_n
            .iter()
            .fold(0.0, |sum, n| sum + n.0[lane]);
        outcome.max_n = self.max_n.0[lane];
        outcome.time_s = self.time_s.0[lane];
        outcome.rows_read = self.rows_read[lane];
        self.ended[lane] = true;
        self.remaining -= 1;
    }
}

impl Outcome {
    pub(crate) const NONE: Self = Self {
        end: End::TimedOut,
        raised_m: [0.0; 2],
        slip_m: [0.0; 2],
        normal_n: 0.0,
        max_n: 0.0,
        time_s: 0.0,
        rows_read: 0,
    };
}

/// Approximately normal numbers: sum of four bytes of a xorshift generator (Marsaglia 2003).
struct Noise<const N: usize>([u32; N]);

impl<const N: usize> Noise<N> {
    /// Mean and standard deviation of that sum.
    const MEAN: f32 = 510.0;
    const DEVIATION: f32 = 147.8;

    #[inline(always)]
    fn next(&mut self) -> Lanes<N> {
        let mut drawn = Lanes::splat(0.0);
        for (x, drawn) in self.0.iter_mut().zip(&mut drawn.0) {
            *x ^= *x << 13;
            *x ^= *x >> 17;
            *x ^= *x << 5;
            let mixed = *x;
            let sum = (mixed & 255) + (mixed >> 8 & 255) + (mixed >> 16 & 255) + (mixed >> 24);
            *drawn = (sum as i32 as f32 - Self::MEAN) * (1.0 / Self::DEVIATION);
        }
        drawn
    }
}

/// Sine generator: a point rotating on the unit circle.
struct Oscillator<const N: usize> {
    cos: Lanes<N>,
    sin: Lanes<N>,
    /// Cosine and sine of one step.
    step: [f32; 2],
}

impl<const N: usize> Oscillator<N> {
    /// Starts at a random phase.
    #[inline(always)]
    fn new(drawn: Lanes<N>, hz: f32) -> Self {
        let square = drawn * drawn;
        let norm = square + 1.0;
        // Series for a small angle; error below 1e-9.
        let angle = core::f32::consts::TAU * hz * STEP_S;
        let (a2, a) = (angle * angle, angle);
        Self {
            cos: (Lanes::splat(1.0) - square) / norm,
            sin: (drawn + drawn) / norm,
            step: [
                1.0 - a2 / 2.0 + a2 * a2 / 24.0,
                a - a * a2 / 6.0 + a * a2 * a2 / 120.0,
            ],
        }
    }

    #[inline(always)]
    fn advance(&mut self) -> Lanes<N> {
        let [cos, sin] = self.step;
        let turned = self.cos * cos - self.sin * sin;
        self.sin = self.sin * cos + self.cos * sin;
        self.cos = turned;
        self.sin
    }
}
