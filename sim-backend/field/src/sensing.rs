//! Sensor model of one agent (scalar reference).

use crate::arithmetic::greater;
use crate::constants::Constants;
use crate::heading::cos_sin;
use crate::obstacle::Obstacle;
use crate::trial::{Point, Pose};

pub(crate) struct SensingAgent {
    position: Point,
    cos: f32,
    sin: f32,
}

/// Target in the agent's frame, px.
#[derive(Clone, Copy)]
pub(crate) struct RelativePoint {
    pub(crate) ahead: f32,
    left: f32,
    pub(crate) distance_sq: f32,
}

impl SensingAgent {
    pub(crate) fn new(agent: Pose) -> Self {
        let (cos, sin) = cos_sin(agent.heading);
        Self {
            position: agent.position(),
            cos,
            sin,
        }
    }

    pub(crate) fn relative(&self, target: Point) -> RelativePoint {
        let (dx, dy) = (
            target.x_px - self.position.x_px,
            target.y_px - self.position.y_px,
        );
        RelativePoint {
            ahead: dx * self.cos + dy * self.sin,
            left: dy * self.cos - dx * self.sin,
            distance_sq: dx * dx + dy * dy,
        }
    }

    /// Tests if the left, front and right IR segments intersect a circle.
    pub(crate) fn ir(
        &self,
        RelativePoint { ahead, left, .. }: RelativePoint,
        radius_sq: f32,
        c: &Constants,
    ) -> [bool; 3] {
        let cuts = |ahead: f32, left: f32| {
            let beyond = greater(ahead - c.ir_range, 0.0);
            ahead > 0.0 && beyond * beyond + left * left < radius_sq
        };
        let (ahead_cos, left_sin) = (ahead * c.ir_cos, left * c.ir_sin);
        let (left_cos, ahead_sin) = (left * c.ir_cos, ahead * c.ir_sin);
        [
            cuts(ahead_cos + left_sin, left_cos - ahead_sin),
            cuts(ahead, left),
            cuts(ahead_cos - left_sin, left_cos + ahead_sin),
        ]
    }

    /// Tests if they intersect a post or cross a wall.
    pub(crate) fn obstacle(&self, obstacle: &Obstacle, c: &Constants) -> [bool; 3] {
        let [from, to] = obstacle.ends.map(|end| self.relative(end));
        if obstacle.radius > 0.0 {
            return self.ir(from, obstacle.radius_sq, c);
        }
        // Ends of the wall in the sensor's frame.
        let crosses = |from: (f32, f32), to: (f32, f32)| {
            // Distance of the crossing along the sensor, times `across`.
            let across = from.1 - to.1;
            let ahead = (to.0 * from.1 - from.0 * to.1) * across;
            from.1 * to.1 < 0.0 && ahead > 0.0 && ahead < c.ir_range * (across * across)
        };
        let turned = |RelativePoint { ahead, left, .. }: RelativePoint| {
            let (ahead_cos, left_sin) = (ahead * c.ir_cos, left * c.ir_sin);
            let (left_cos, ahead_sin) = (left * c.ir_cos, ahead * c.ir_sin);
            [
                (ahead_cos + left_sin, left_cos - ahead_sin),
                (ahead, left),
                (ahead_cos - left_sin, left_cos + ahead_sin),
            ]
        };
        let (from, to) = (turned(from), turned(to));
        std::array::from_fn(|k| crosses(from[k], to[k]))
    }

    /// Tests if they end outside the field.
    pub(crate) fn walls(&self, c: &Constants) -> [bool; 3] {
        let beyond = |cos: f32, sin: f32| {
            let (x, y) = (
                (self.position.x_px + c.ir_range * cos).abs(),
                (self.position.y_px + c.ir_range * sin).abs(),
            );
            c.half_side < greater(x, y)
        };
        let (cos_cos, sin_sin) = (self.cos * c.ir_cos, self.sin * c.ir_sin);
        let (cos_sin, sin_cos) = (self.cos * c.ir_sin, self.sin * c.ir_cos);
        [
            beyond(cos_cos - sin_sin, sin_cos + cos_sin),
            beyond(self.cos, self.sin),
            beyond(cos_cos + sin_sin, sin_cos - cos_sin),
        ]
    }

    /// Tests if the left and right photo sensors detect a light.
    pub(crate) fn photo(
        &self,
        RelativePoint {
            ahead,
            left,
            distance_sq,
        }: RelativePoint,
        range_sq: f32,
        c: &Constants,
    ) -> [bool; 2] {
        let inside = |along: f32| {
            along > 0.0 && (c.cone_sq == 0.0 || c.cone_sq * distance_sq < along * along)
        };
        let (ahead, left) = (ahead * c.photo_cos, left * c.photo_sin);
        let near = distance_sq < range_sq;
        [near && inside(ahead + left), near && inside(ahead - left)]
    }
}
