//! Reachable box around the rest pose of a hand: every vertical grasp in it has a posture. The box
//! grows on a grid.

use std::collections::HashMap;

use atas_console::Progress;
use nalgebra::Vector3;
use robot_model::{GraspPose, HandModel, Workspace};

pub(super) const STEP_M: f64 = 0.02;
/// Largest growth of the box from the rest pose, steps.
const STEPS_MAX: i32 = 20;
const NARROW_M: f64 = 0.02;
/// Number of tested openings between the rest opening and the largest one (design choice).
const OPENINGS: u32 = 8;
/// Clearance between the lowest fingertip and the table, m (design choice: half that of the
/// two-hand arm).
const TABLE_M: f64 = 0.005;

pub(super) struct Reach {
    /// Box in which every grasp from above is reachable.
    pub(super) space: Workspace,
}

struct Grid<'a> {
    hand: &'a HandModel,
    lowest_m: f64,
    known: HashMap<[i32; 3], bool>,
    progress: Progress,
}

impl Reach {
    /// Grows the box; returns `None` if the rest pose itself is unreachable.
    pub(super) fn from_hand(hand: &HandModel) -> Option<Self> {
        let lowest_m = hand.tip_radius_m().iter().copied().fold(0.0, f64::max) + TABLE_M;
        let mut grid = Grid {
            hand,
            lowest_m,
            known: HashMap::new(),
            progress: Progress::new("robot check"),
        };
        let mut bounds = [[0, 0]; 3];
        if !grid.reaches([0, 0, 0]) {
            return None;
        }
        // Grow downwards first: objects stand on the table.
        while grid.grow(&mut bounds, 2, 0) {}
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
        let mut space = Workspace {
            x_m: range(0),
            y_m: range(1),
            z_m: range(2),
            opening_m: [NARROW_M.min(hand.home_opening_m()), hand.home_opening_m()],
        };
        space.opening_m[1] = opening_max_m(hand, &space);
        Some(Self { space })
    }
}

/// Returns the reason why no grasp near the rest pose is reachable.
pub(super) fn unreachable_reason(hand: &HandModel) -> String {
    let home_m = hand.home_m();
    let frame = GraspPose::from_above(home_m, hand.home_yaw_rad(), hand.home_opening_m());
    match hand.posture_for(&frame) {
        Err(unreachable) => unreachable.to_string(),
        Ok(_) => format!(
            "the fingertips are too close to the table at {:.3} m, or cannot close to {:.0} mm \
             there",
            home_m.z,
            NARROW_M * 1e3
        ),
    }
}

/// Returns the largest opening that is reachable in all corners of a box, at least the rest
/// opening.
fn opening_max_m(hand: &HandModel, space: &Workspace) -> f64 {
    let mut corners = Vec::new();
    for x in space.x_m {
        for y in space.y_m {
            corners.extend(space.z_m.map(|z| Vector3::new(x, y, z)));
        }
    }
    let opens = |opening_m: f64| corners.iter().all(|at| has_posture(hand, *at, opening_m));
    let [_, rests_m] = space.opening_m;
    let step_m = (hand.max_opening_m() - rests_m) / f64::from(OPENINGS);
    (0..=OPENINGS)
        .rev()
        .map(|step| rests_m + f64::from(step) * step_m)
        .find(|opening_m| opens(*opening_m))
        .unwrap_or(rests_m)
}

/// Returns true if a vertical grasp at this position, with the closing axis of the rest pose, has a
/// posture.
fn has_posture(hand: &HandModel, centre_m: Vector3<f64>, opening_m: f64) -> bool {
    let yaw_rad = hand.closing_yaw_rad(&centre_m, hand.home_yaw_rad());
    let frame = GraspPose::from_above(centre_m, yaw_rad, opening_m);
    hand.reaches(&frame)
}

impl Grid<'_> {
    /// Moves one face of the box outwards by one step if every point of the new face is reachable.
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
        let open_m = self.hand.home_opening_m();
        let reached = centre_m.z >= self.lowest_m
            && [open_m, NARROW_M.min(open_m)]
                .into_iter()
                .all(|opening_m| has_posture(self.hand, centre_m, opening_m));
        self.known.insert(at, reached);
        let tried = self.known.len();
        self.progress
            .show_live(&format!("tests reachability: {tried} positions"));
        reached
    }
}

pub(super) fn workspace_entry(space: &Workspace) -> String {
    let range = |[least, most]: [f64; 2]| format!("[{:.3}, {:.3}]", least + 0.0, most + 0.0);
    format!(
        "{{ x_m = {}, y_m = {}, z_m = {}, opening_m = {} }}",
        range(space.x_m),
        range(space.y_m),
        range(space.z_m),
        range(space.opening_m)
    )
}
