//! A box about where a hand rests in which every grasp from above has a posture, grown on a grid.

use std::collections::HashMap;

use nalgebra::Vector3;
use robot_model::{GraspFrame, HandModel, Workspace};

/// Distance of the grid's points, m (ours).
pub(super) const STEP_M: f64 = 0.02;
/// Farthest that the box may grow from where the hand rests, steps.
const STEPS_MAX: i32 = 20;
/// Narrowest opening that is tried, m.
const NARROW_M: f64 = 0.02;
/// Distance that the lowest dome keeps from the table, m (ours: half what the two-hand arm keeps).
const TABLE_M: f64 = 0.005;

/// What a hand reaches.
pub(super) struct Reach {
    /// The box.
    pub(super) space: Workspace,
}

/// Which grasps were tried already, by their place on the grid.
struct Grid<'a> {
    hand: &'a HandModel,
    lowest_m: f64,
    known: HashMap<[i32; 3], bool>,
}

impl Reach {
    /// Grows the box; `None` if the hand cannot even rest.
    pub(super) fn of(hand: &HandModel) -> Option<Self> {
        let lowest_m = hand.tip_radius_m().iter().copied().fold(0.0, f64::max) + TABLE_M;
        let mut grid = Grid {
            hand,
            lowest_m,
            known: HashMap::new(),
        };
        let mut bounds = [[0, 0]; 3];
        if !grid.reaches([0, 0, 0]) {
            return None;
        }
        let mut grows = true;
        while grows {
            grows = false;
            for axis in 0..3 {
                for end in 0..2 {
                    grows |= grid.grow(&mut bounds, axis, end);
                }
            }
        }
        let home_m = hand.home_m();
        let range = |axis: usize| bounds[axis].map(|step| home_m[axis] + f64::from(step) * STEP_M);
        let opening_m = [NARROW_M.min(hand.home_opening_m()), hand.home_opening_m()];
        Some(Self {
            space: Workspace {
                x_m: range(0),
                y_m: range(1),
                z_m: range(2),
                opening_m,
            },
        })
    }
}

impl Grid<'_> {
    /// Moves one face of the box out by a step if every point of it is reached.
    fn grow(&mut self, bounds: &mut [[i32; 2]; 3], axis: usize, end: usize) -> bool {
        let step = if end == 0 { -1 } else { 1 };
        let face = bounds[axis][end] + step;
        if face.abs() > STEPS_MAX {
            return false;
        }
        let mut of = *bounds;
        of[axis] = [face, face];
        let [xs, ys, zs] = of.map(|[from, to]| from..=to);
        let whole = xs.clone().all(|x| {
            ys.clone()
                .all(|y| zs.clone().all(|z| self.reaches([x, y, z])))
        });
        if whole {
            bounds[axis][end] = face;
        }
        whole
    }

    fn reaches(&mut self, at: [i32; 3]) -> bool {
        if let Some(known) = self.known.get(&at) {
            return *known;
        }
        let [x, y, z] = at.map(|step| f64::from(step) * STEP_M);
        let centre_m = self.hand.home_m() + Vector3::new(x, y, z);
        let yaw_rad = self
            .hand
            .closing_yaw_rad(&centre_m, self.hand.home_yaw_rad());
        let open_m = self.hand.home_opening_m();
        let has_posture = |opening_m: f64| {
            let frame = GraspFrame::from_above(centre_m, yaw_rad, opening_m);
            self.hand.posture_for(&frame).is_ok()
        };
        let reached =
            centre_m.z >= self.lowest_m && has_posture(open_m) && has_posture(NARROW_M.min(open_m));
        self.known.insert(at, reached);
        reached
    }
}

/// A workspace as its entry of a robot file.
pub(super) fn entry(space: &Workspace) -> String {
    let range = |[least, most]: [f64; 2]| format!("[{:.3}, {:.3}]", least + 0.0, most + 0.0);
    format!(
        "{{ x_m = {}, y_m = {}, z_m = {}, opening_m = {} }}",
        range(space.x_m),
        range(space.y_m),
        range(space.z_m),
        range(space.opening_m)
    )
}
