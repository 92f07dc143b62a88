//! Equality-constrained least squares of one hand, solved in the block-arrow form that the hand's tree gives it.
//!
//! Minimise ½·xᵀHx − gᵀx subject to J·x = e, softened by ε: x = H⁻¹(g + Jᵀν) with (J·H⁻¹·Jᵀ + ε)ν = e − J·H⁻¹g.
//! The two fingers meet only in the arm, so H has the shape
//!
//! ```text
//!   ⎡ finger 1          cross 1ᵀ ⎤        3
//!   ⎢          finger 2 cross 2ᵀ ⎥        3
//!   ⎣ cross 1  cross 2  arm      ⎦        5
//! ```
//!
//! and its Cholesky factor has the same zeros when the fingers are eliminated first. Everything is a product of
//! matrices of at most 6 rows: no allocation, and no summation order that depends on the machine.

use nalgebra::{SMatrix, SVector};

use crate::sizes::{ARM_JOINTS, FINGER_JOINTS, FINGERS, HandVector};

type Arm = SVector<f64, ARM_JOINTS>;
type Finger = SVector<f64, FINGER_JOINTS>;
type ArmSquare = SMatrix<f64, ARM_JOINTS, ARM_JOINTS>;
type FingerSquare = SMatrix<f64, FINGER_JOINTS, FINGER_JOINTS>;
type FingerByArm = SMatrix<f64, FINGER_JOINTS, ARM_JOINTS>;
type ArmByTip = SMatrix<f64, ARM_JOINTS, 3>;
type FingerByTip = SMatrix<f64, FINGER_JOINTS, 3>;
type Tip = SVector<f64, 3>;

/// The part of the problem that belongs to one finger and its tip.
#[derive(Clone, Copy)]
pub(crate) struct FingerBlock {
    /// Diagonal block of H.
    pub(crate) h: FingerSquare,
    /// Block of H between finger (rows) and arm (columns).
    pub(crate) cross: FingerByArm,
    /// g of the finger's joints.
    pub(crate) g: Finger,
    /// Transposed tip Jacobian of the finger's joints.
    pub(crate) tip_by_finger: FingerByTip,
    /// Transposed tip Jacobian of the arm's joints.
    pub(crate) tip_by_arm: ArmByTip,
    /// Wanted change of the tip.
    pub(crate) e: Tip,
}

/// The whole problem of one hand.
#[derive(Clone, Copy)]
pub(crate) struct ArrowSystem {
    pub(crate) fingers: [FingerBlock; FINGERS],
    pub(crate) arm_h: ArmSquare,
    pub(crate) arm_g: Arm,
    /// ε, added to the diagonal of J·H⁻¹·Jᵀ.
    pub(crate) softening: f64,
}

/// A finger's rows of the Cholesky factor L, and L⁻¹ applied to the right-hand sides.
struct FactoredFinger {
    l: FingerSquare,
    cross: FingerByArm,
    g: Finger,
    tip: FingerByTip,
}

impl ArrowSystem {
    /// Holds the joint at `value`: its column moves to the right-hand sides and its own equation becomes x = value.
    pub(crate) fn hold(&mut self, joint: usize, value: f64) {
        match joint.checked_sub(ARM_JOINTS) {
            None => self.hold_arm(joint, value),
            Some(rest) => self.hold_finger(rest / FINGER_JOINTS, rest % FINGER_JOINTS, value),
        }
    }

    fn hold_arm(&mut self, joint: usize, value: f64) {
        for finger in &mut self.fingers {
            finger.g -= finger.cross.column(joint) * value;
            finger.e -= finger.tip_by_arm.row(joint).transpose() * value;
            finger.cross.column_mut(joint).fill(0.0);
            finger.tip_by_arm.row_mut(joint).fill(0.0);
        }
        self.arm_g -= self.arm_h.column(joint) * value;
        hold_in_square(&mut self.arm_h, &mut self.arm_g, joint, value);
    }

    fn hold_finger(&mut self, finger: usize, joint: usize, value: f64) {
        let finger = &mut self.fingers[finger];
        self.arm_g -= finger.cross.row(joint).transpose() * value;
        finger.g -= finger.h.column(joint) * value;
        finger.e -= finger.tip_by_finger.row(joint).transpose() * value;
        finger.cross.row_mut(joint).fill(0.0);
        finger.tip_by_finger.row_mut(joint).fill(0.0);
        hold_in_square(&mut finger.h, &mut finger.g, joint, value);
    }

    /// The minimiser in hand order, or `None` if a factorisation met a pivot that is not positive.
    pub(crate) fn solve(&self) -> Option<HandVector> {
        let factored = [
            factor_finger(&self.fingers[0])?,
            factor_finger(&self.fingers[1])?,
        ];
        let arm_l = self.factor_arm(&factored)?;
        let arm_g = self.eliminate_fingers_from_g(&factored, &arm_l);
        let arm_tip = [
            eliminate_finger_from_tip(&self.fingers[0], &factored[0], &arm_l),
            eliminate_finger_from_tip(&self.fingers[1], &factored[1], &arm_l),
        ];
        let force = self.constraint_forces(&factored, &arm_g, &arm_tip)?;

        let mut arm = arm_g + arm_tip[0] * force[0] + arm_tip[1] * force[1];
        back_substitute(&arm_l, &mut arm);
        let mut x = HandVector::zeros();
        x.fixed_rows_mut::<ARM_JOINTS>(0).copy_from(&arm);
        for (index, finger) in factored.iter().enumerate() {
            let mut own = finger.g + finger.tip * force[index] - finger.cross * arm;
            back_substitute(&finger.l, &mut own);
            x.fixed_rows_mut::<FINGER_JOINTS>(ARM_JOINTS + FINGER_JOINTS * index)
                .copy_from(&own);
        }
        Some(x)
    }

    fn factor_arm(&self, fingers: &[FactoredFinger; FINGERS]) -> Option<ArmSquare> {
        let coupled = |finger: &FactoredFinger| finger.cross.tr_mul(&finger.cross);
        cholesky(self.arm_h - coupled(&fingers[0]) - coupled(&fingers[1]))
    }

    fn eliminate_fingers_from_g(
        &self,
        fingers: &[FactoredFinger; FINGERS],
        arm_l: &ArmSquare,
    ) -> Arm {
        let coupled = |finger: &FactoredFinger| finger.cross.tr_mul(&finger.g);
        let mut arm_g = self.arm_g - coupled(&fingers[0]) - coupled(&fingers[1]);
        forward_substitute(arm_l, &mut arm_g);
        arm_g
    }

    /// ν: the multipliers that bring each tip where it should be.
    fn constraint_forces(
        &self,
        fingers: &[FactoredFinger; FINGERS],
        arm_g: &Arm,
        arm_tip: &[ArmByTip; FINGERS],
    ) -> Option<[Tip; FINGERS]> {
        let mut a = SMatrix::<f64, 6, 6>::from_diagonal_element(self.softening);
        let mut residual = SVector::<f64, 6>::zeros();
        for (index, finger) in fingers.iter().enumerate() {
            let mut block = a.fixed_view_mut::<3, 3>(3 * index, 3 * index);
            block += finger.tip.tr_mul(&finger.tip) + arm_tip[index].tr_mul(&arm_tip[index]);
            let reached = finger.tip.tr_mul(&finger.g) + arm_tip[index].tr_mul(arm_g);
            residual
                .fixed_rows_mut::<3>(3 * index)
                .copy_from(&(self.fingers[index].e - reached));
        }
        a.fixed_view_mut::<3, 3>(3, 0)
            .copy_from(&arm_tip[1].tr_mul(&arm_tip[0]));
        let l = cholesky(a)?;
        forward_substitute(&l, &mut residual);
        back_substitute(&l, &mut residual);
        Some([
            residual.fixed_rows::<3>(0).into(),
            residual.fixed_rows::<3>(3).into(),
        ])
    }
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

fn factor_finger(finger: &FingerBlock) -> Option<FactoredFinger> {
    let l = cholesky(finger.h)?;
    let mut factored = FactoredFinger {
        l,
        cross: finger.cross,
        g: finger.g,
        tip: finger.tip_by_finger,
    };
    forward_substitute(&l, &mut factored.cross);
    forward_substitute(&l, &mut factored.g);
    forward_substitute(&l, &mut factored.tip);
    Some(factored)
}

fn eliminate_finger_from_tip(
    finger: &FingerBlock,
    factored: &FactoredFinger,
    arm_l: &ArmSquare,
) -> ArmByTip {
    let mut arm_tip = finger.tip_by_arm - factored.cross.tr_mul(&factored.tip);
    forward_substitute(arm_l, &mut arm_tip);
    arm_tip
}

/// Lower Cholesky factor; reads only the lower triangle, leaves the upper one as it was.
fn cholesky<const N: usize>(mut m: SMatrix<f64, N, N>) -> Option<SMatrix<f64, N, N>> {
    for j in 0..N {
        for k in 0..j {
            let factor = m[(j, k)];
            for i in j..N {
                m[(i, j)] -= m[(i, k)] * factor;
            }
        }
        let pivot = m[(j, j)];
        // Written so that NaN fails too.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let root = libm::sqrt(pivot);
        for i in j..N {
            m[(i, j)] /= root;
        }
    }
    Some(m)
}

/// b := L⁻¹b, column by column.
fn forward_substitute<const N: usize, const M: usize>(
    l: &SMatrix<f64, N, N>,
    b: &mut SMatrix<f64, N, M>,
) {
    for column in 0..M {
        for i in 0..N {
            let mut sum = b[(i, column)];
            for k in 0..i {
                sum -= l[(i, k)] * b[(k, column)];
            }
            b[(i, column)] = sum / l[(i, i)];
        }
    }
}

/// b := L⁻ᵀb.
fn back_substitute<const N: usize>(l: &SMatrix<f64, N, N>, b: &mut SVector<f64, N>) {
    for i in (0..N).rev() {
        let mut sum = b[i];
        for k in i + 1..N {
            sum -= l[(k, i)] * b[k];
        }
        b[i] = sum / l[(i, i)];
    }
}
