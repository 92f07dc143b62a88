//! Equality-constrained least squares of one hand, solved in block-arrow form, which follows from
//! the tree of its joints.
//!
//! Minimise ½·xᵀHx − gᵀx subject to J·x = e, softened by E: x = H⁻¹(g + Jᵀν) with (J·H⁻¹·Jᵀ + E)ν =
//! e − J·H⁻¹g. E is ε for the middle of the tips of each side, and ε + ε_s for their differences. A
//! softened equation has the weight 1/E. Fingers meet only in the trunk (the arm, and drives that
//! they share), so H has the shape
//!
//! ```text
//!   ⎡ finger 1                    cross 1ᵀ ⎤        0 to 4 each
//!   ⎢             ⋱                   ⋮    ⎥
//!   ⎢                 finger n    cross nᵀ ⎥
//!   ⎣ cross 1     …   cross n     trunk    ⎦        0 to 9
//! ```
//!
//! and its Cholesky factor has the same zeros when the fingers are eliminated first. All products
//! use small matrices of which only the first rows and columns are in use: no allocation, and the
//! same order of summation on every machine.

use crate::grasp_sides::GraspSide;
use arrayvec::ArrayVec;
use nalgebra::{SMatrix, SVector, Vector3};

use crate::sizes::{FINGER_JOINTS_MAX, FINGERTIPS_MAX, TRUNK_JOINTS_MAX};
use crate::vector::HandVector;

type Trunk = SVector<f64, TRUNK_JOINTS_MAX>;
type Own = SVector<f64, FINGER_JOINTS_MAX>;
type TrunkSquare = SMatrix<f64, TRUNK_JOINTS_MAX, TRUNK_JOINTS_MAX>;
type OwnSquare = SMatrix<f64, FINGER_JOINTS_MAX, FINGER_JOINTS_MAX>;
type OwnByTrunk = SMatrix<f64, FINGER_JOINTS_MAX, TRUNK_JOINTS_MAX>;
type TrunkByTip = SMatrix<f64, TRUNK_JOINTS_MAX, 3>;
type OwnByTip = SMatrix<f64, FINGER_JOINTS_MAX, 3>;
/// Rows of all tips.
const TIPS: usize = 3 * FINGERTIPS_MAX;

/// Part of the problem that belongs to one finger and its tip.
#[derive(Clone, Copy, Default)]
pub(crate) struct FingerBlock {
    /// First joint of the finger in hand order, and number of joints.
    pub(crate) first_joint: usize,
    pub(crate) joint_count: usize,
    /// Diagonal block of H.
    pub(crate) h: OwnSquare,
    /// Block of H between finger (rows) and trunk (columns).
    pub(crate) cross: OwnByTrunk,
    /// g of the finger's joints.
    pub(crate) g: Own,
    /// Transposed tip Jacobian of the finger's joints.
    pub(crate) tip_by_own: OwnByTip,
    /// Transposed tip Jacobian of the trunk's joints.
    pub(crate) tip_by_trunk: TrunkByTip,
    /// Requested change of the tip.
    pub(crate) e: Vector3<f64>,
    /// Grasp side of the tip.
    pub(crate) side: GraspSide,
}

/// Complete problem of one hand.
#[derive(Clone)]
pub(crate) struct ArrowSystem {
    pub(crate) fingers: ArrayVec<FingerBlock, FINGERTIPS_MAX>,
    pub(crate) trunk_h: TrunkSquare,
    pub(crate) trunk_g: Trunk,
    pub(crate) trunk_joints: usize,
    /// ε, added to the diagonal of J·H⁻¹·Jᵀ.
    pub(crate) softening: f64,
    /// ε_s, added to the differences between the tips of one side: ε_s·(I − 1/n) over the n tips of
    /// each side.
    pub(crate) softening_within: f64,
}

/// A finger's rows of the Cholesky factor L, and L⁻¹ applied to the right-hand sides.
#[derive(Clone, Copy, Default)]
struct Factored {
    l: OwnSquare,
    cross: OwnByTrunk,
    g: Own,
    tip: OwnByTip,
    /// Tip Jacobian of the trunk; after the trunk is factored, its remainder with the trunk's L⁻¹
    /// applied.
    trunk_tip: TrunkByTip,
}

impl Factored {
    /// Creates the initial state of a finger's elimination.
    fn new(finger: &FingerBlock) -> Self {
        Self {
            l: finger.h,
            cross: finger.cross,
            g: finger.g,
            tip: finger.tip_by_own,
            trunk_tip: finger.tip_by_trunk,
        }
    }

    /// Factors the block of the finger's own joints, in place, and applies L⁻¹ to the rest.
    fn eliminate(&mut self, joints: usize, trunk_joints: usize) -> Option<()> {
        cholesky(&mut self.l, joints)?;
        forward_substitute(&self.l, &mut self.cross, joints, trunk_joints);
        forward_substitute(&self.l, &mut self.g, joints, 1);
        forward_substitute(&self.l, &mut self.tip, joints, 3);
        Some(())
    }
}

impl ArrowSystem {
    /// Holds the joint at `value`: its column moves to the right-hand sides and its own equation
    /// becomes x = value.
    pub(crate) fn hold(&mut self, joint: usize, value: f64) {
        if joint < self.trunk_joints {
            return self.hold_trunk(joint, value);
        }
        for finger in 0..self.fingers.len() {
            let block = &self.fingers[finger];
            let own = joint.wrapping_sub(block.first_joint);
            if own < block.joint_count {
                self.hold_finger(finger, own, value);
            }
        }
    }

    fn hold_trunk(&mut self, joint: usize, value: f64) {
        for finger in &mut self.fingers {
            finger.g -= finger.cross.column(joint) * value;
            finger.e -= finger.tip_by_trunk.row(joint).transpose() * value;
            finger.cross.column_mut(joint).fill(0.0);
            finger.tip_by_trunk.row_mut(joint).fill(0.0);
        }
        self.trunk_g -= self.trunk_h.column(joint) * value;
        hold_in_square(&mut self.trunk_h, &mut self.trunk_g, joint, value);
    }

    fn hold_finger(&mut self, finger: usize, joint: usize, value: f64) {
        let finger = &mut self.fingers[finger];
        self.trunk_g -= finger.cross.row(joint).transpose() * value;
        finger.g -= finger.h.column(joint) * value;
        finger.e -= finger.tip_by_own.row(joint).transpose() * value;
        finger.cross.row_mut(joint).fill(0.0);
        finger.tip_by_own.row_mut(joint).fill(0.0);
        hold_in_square(&mut finger.h, &mut finger.g, joint, value);
    }

    /// Returns the minimiser in hand order, of `joint_count` joints, or `None` if a factorisation
    /// met a pivot that is not positive.
    pub(crate) fn solve(&self, joint_count: usize) -> Option<HandVector> {
        let mut factored = ArrayVec::<Factored, FINGERTIPS_MAX>::new();
        for finger in &self.fingers {
            factored.push(Factored::new(finger));
            factored
                .last_mut()?
                .eliminate(finger.joint_count, self.trunk_joints)?;
        }
        let trunk_l = self.factor_trunk(&factored)?;
        let trunk_g = self.eliminate_fingers_from_g(&factored, &trunk_l);
        for (factored, finger) in factored.iter_mut().zip(&self.fingers) {
            self.eliminate_finger_from_tip(finger.joint_count, factored, &trunk_l);
        }
        let force = self.constraint_forces(&factored, &trunk_g)?;

        let n = self.trunk_joints;
        let mut trunk = trunk_g;
        for (factored, force) in factored.iter().zip(&force) {
            for row in 0..n {
                trunk[row] += dot(3, |k| factored.trunk_tip[(row, k)] * force[k]);
            }
        }
        back_substitute(&trunk_l, &mut trunk, n);
        let mut x = HandVector::zeros(joint_count);
        x[..n].copy_from_slice(&trunk.as_slice()[..n]);
        for ((finger, factored), force) in self.fingers.iter().zip(&factored).zip(&force) {
            let own = self.own(finger, factored, force, &trunk);
            x[finger.first_joint..][..finger.joint_count]
                .copy_from_slice(&own.as_slice()[..finger.joint_count]);
        }
        Some(x)
    }

    fn own(&self, finger: &FingerBlock, of: &Factored, force: &Vector3<f64>, trunk: &Trunk) -> Own {
        let mut own = Own::zeros();
        for row in 0..finger.joint_count {
            let pulled = dot(3, |k| of.tip[(row, k)] * force[k]);
            let carried = dot(self.trunk_joints, |k| of.cross[(row, k)] * trunk[k]);
            own[row] = of.g[row] + pulled - carried;
        }
        back_substitute(&of.l, &mut own, finger.joint_count);
        own
    }

    fn factor_trunk(&self, factored: &[Factored]) -> Option<TrunkSquare> {
        let (n, mut h) = (self.trunk_joints, self.trunk_h);
        for (finger, factored) in self.fingers.iter().zip(factored) {
            let cross = &factored.cross;
            for j in 0..n {
                for i in j..n {
                    h[(i, j)] -= dot(finger.joint_count, |k| cross[(k, i)] * cross[(k, j)]);
                }
            }
        }
        cholesky(&mut h, n)?;
        Some(h)
    }

    fn eliminate_fingers_from_g(&self, factored: &[Factored], trunk_l: &TrunkSquare) -> Trunk {
        let (n, mut g) = (self.trunk_joints, self.trunk_g);
        for (finger, of) in self.fingers.iter().zip(factored) {
            for i in 0..n {
                g[i] -= dot(finger.joint_count, |k| of.cross[(k, i)] * of.g[k]);
            }
        }
        forward_substitute(trunk_l, &mut g, n, 1);
        g
    }

    fn eliminate_finger_from_tip(
        &self,
        joints: usize,
        factored: &mut Factored,
        trunk_l: &TrunkSquare,
    ) {
        let n = self.trunk_joints;
        let Factored {
            cross,
            tip,
            trunk_tip,
            ..
        } = factored;
        for j in 0..3 {
            for i in 0..n {
                trunk_tip[(i, j)] -= dot(joints, |k| cross[(k, i)] * tip[(k, j)]);
            }
        }
        forward_substitute(trunk_l, trunk_tip, n, 3);
    }

    /// Returns ν: the multipliers that bring each tip to its target.
    fn constraint_forces(
        &self,
        factored: &[Factored],
        trunk_g: &Trunk,
    ) -> Option<[Vector3<f64>; FINGERTIPS_MAX]> {
        let (n, tips) = (self.trunk_joints, 3 * self.fingers.len());
        let mut a = SMatrix::<f64, TIPS, TIPS>::from_diagonal_element(self.softening);
        let mut residual = SVector::<f64, TIPS>::zeros();
        for (first, (finger, of)) in self.fingers.iter().zip(factored).enumerate() {
            for axis in 0..3 {
                let row = 3 * first + axis;
                let own = dot(finger.joint_count, |k| of.tip[(k, axis)] * of.g[k]);
                let reached = own + dot(n, |k| of.trunk_tip[(k, axis)] * trunk_g[k]);
                residual[row] = finger.e[axis] - reached;
                for other in 0..3 {
                    let own = dot(finger.joint_count, |k| {
                        of.tip[(k, axis)] * of.tip[(k, other)]
                    });
                    let carried = dot(n, |k| of.trunk_tip[(k, axis)] * of.trunk_tip[(k, other)]);
                    a[(row, 3 * first + other)] += own + carried;
                }
                for before in 0..3 * first {
                    let theirs = &factored[before / 3].trunk_tip;
                    a[(row, before)] =
                        dot(n, |k| of.trunk_tip[(k, axis)] * theirs[(k, before % 3)]);
                }
            }
        }
        self.soften_within_sides(&mut a);
        cholesky(&mut a, tips)?;
        forward_substitute(&a, &mut residual, tips, 1);
        back_substitute(&a, &mut residual, tips);
        Some(core::array::from_fn(|finger| {
            residual.fixed_rows::<3>(3 * finger).into()
        }))
    }

    /// Lets the tips of one side differ from each other at the cost ε_s. Their middle is treated
    /// like a single tip.
    fn soften_within_sides(&self, a: &mut SMatrix<f64, TIPS, TIPS>) {
        for (first, finger) in self.fingers.iter().enumerate() {
            let on_side = |other: &FingerBlock| other.side == finger.side;
            let count = self.fingers.iter().filter(|other| on_side(other)).count();
            if count < 2 {
                continue;
            }
            let share = self.softening_within / count as f64;
            for axis in 0..3 {
                a[(3 * first + axis, 3 * first + axis)] += self.softening_within;
                // Only the lower triangle is read.
                for other in (0..=first).filter(|other| on_side(&self.fingers[*other])) {
                    a[(3 * first + axis, 3 * other + axis)] -= share;
                }
            }
        }
    }
}

/// Returns the sum of terms, from the first to the last.
fn dot(count: usize, term: impl Fn(usize) -> f64) -> f64 {
    (0..count).fold(0.0, |sum, k| sum + term(k))
}

fn hold_in_square<const N: usize>(
    h: &mut SMatrix<f64, N, N>,
    g: &mut SVector<f64, N>,
    joint: usize,
    value: f64,
) {
    h.row_mut(joint).fill(0.0);
    h.column_mut(joint).fill(0.0);
    h[(joint, joint)] = 1.0;
    g[joint] = value;
}

/// Replaces the first `n` rows by their lower Cholesky factor; reads only the lower triangle and
/// keeps the upper one.
fn cholesky<const N: usize>(m: &mut SMatrix<f64, N, N>, n: usize) -> Option<()> {
    for j in 0..n {
        for k in 0..j {
            let factor = m[(j, k)];
            for i in j..n {
                m[(i, j)] -= m[(i, k)] * factor;
            }
        }
        let pivot = m[(j, j)];
        // Written so that NaN fails too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let root = libm::sqrt(pivot);
        for i in j..n {
            m[(i, j)] /= root;
        }
    }
    Some(())
}

/// b := L⁻¹b over the first `n` rows, column by column for `columns` of them.
fn forward_substitute<const N: usize, const M: usize>(
    l: &SMatrix<f64, N, N>,
    b: &mut SMatrix<f64, N, M>,
    n: usize,
    columns: usize,
) {
    for column in 0..columns {
        for i in 0..n {
            let mut sum = b[(i, column)];
            for k in 0..i {
                sum -= l[(i, k)] * b[(k, column)];
            }
            b[(i, column)] = sum / l[(i, i)];
        }
    }
}

/// b := L⁻ᵀb over the first `n` rows.
fn back_substitute<const N: usize>(l: &SMatrix<f64, N, N>, b: &mut SVector<f64, N>, n: usize) {
    for i in (0..n).rev() {
        let mut sum = b[i];
        for k in i + 1..n {
            sum -= l[(k, i)] * b[k];
        }
        b[i] = sum / l[(i, i)];
    }
}
