//! Placement checks of walls and posts; positions of random posts.

use crate::check::Finding;
use crate::constants::Constants;
use crate::noise::{Stream, seed};
use crate::obstacle::{DrawnPosts, MAX_OBSTACLES, MOVE_MARGIN_PX, Obstacles, Post, Wall};
use crate::preset::Preset;
use crate::trial::{Point, Pose};

/// Shortest allowed wall, px. Design choice.
const WALL_LENGTH_MIN_PX: f32 = 1.0;
/// Attempts per random post before the field counts as crowded. Design choice.
const ATTEMPTS: usize = 1000;

pub(crate) struct RequiredPlace {
    name: String,
    position: Point,
    /// Radius of the body that must fit.
    radius_px: f32,
    needs: &'static str,
}

/// Starts of agents and object, and goals.
pub(crate) fn required_places(
    preset: &Preset,
    starts: &[Pose],
    goals: &[Point],
) -> Vec<RequiredPlace> {
    let place = |name: String, at, radius_px, needs| RequiredPlace {
        name,
        position: at,
        radius_px,
        needs,
    };
    let (agent, object) = (preset.agent_radius_px, preset.object_radius_px);
    let start = |(k, pose): (usize, &Pose)| {
        let name = format!("the start of agent {}", k + 1);
        place(name, pose.position(), agent, "at least the agent's radius")
    };
    let goal = |(k, &at): (usize, &Point)| {
        let needs = "at least the object's radius; otherwise the object cannot reach it";
        place(format!("goal {}", k + 1), at, object, needs)
    };
    let middle = Point::default();
    let needs = "at least the object's radius";
    let object = place("the start of the object".to_owned(), middle, object, needs);
    let starts = starts.iter().enumerate().map(start);
    let goals = goals.iter().enumerate().map(goal);
    starts.chain([object]).chain(goals).collect()
}

/// Checks shapes and number of walls and posts.
pub(crate) fn shape_findings(preset: &Preset) -> Vec<Finding> {
    let mut findings = Vec::new();
    let mut find = |key: String, value: f32, needs| findings.push(Finding::new(key, value, needs));
    let half = preset.half_side_px;
    let outside = |value: &f32| !(-half..=half).contains(value);
    const INSIDE: &str = "finite numbers inside the field";
    for (k, wall) in preset.walls.iter().enumerate() {
        for (key, end) in [("from_px", wall.from_px), ("to_px", wall.to_px)] {
            if let Some(value) = end.into_iter().find(outside) {
                find(format!("{key} of wall {}", k + 1), value, INSIDE);
            }
        }
        let length = wall.length_px();
        if length < WALL_LENGTH_MIN_PX {
            find(
                format!("the length of wall {}", k + 1),
                length,
                "1 px or more",
            );
        }
    }
    for (k, post) in preset.posts.iter().enumerate() {
        if let Some(value) = post.at_px.into_iter().find(outside) {
            find(format!("at_px of post {}", k + 1), value, INSIDE);
        }
        if !is_radius(post.radius_px, half) {
            let key = format!("radius_px of post {}", k + 1);
            find(key, post.radius_px, RADIUS_RANGE);
        }
    }
    if let Some(drawn) = preset.drawn_posts.filter(|d| !is_radius(d.radius_px, half)) {
        find(
            "radius_px of drawn_posts".to_owned(),
            drawn.radius_px,
            RADIUS_RANGE,
        );
    }
    let drawn = preset.drawn_posts.map_or(0, |drawn| drawn.count.into());
    let count = preset.walls.len() + preset.posts.len() + drawn;
    if count > MAX_OBSTACLES {
        let key = "the number of walls and posts";
        find(key.to_owned(), count as f32, "at most 16");
    }
    let smaller = preset.agent_radius_px.min(preset.object_radius_px);
    // Twice the margin: a wheel move never exceeds the largest move.
    let fastest = 0.5 * (smaller - 2.0 * MOVE_MARGIN_PX);
    if count > 0 && !(0.0..=fastest).contains(&preset.medium_speed_px_per_frame) {
        find(
            "medium_speed_px_per_frame".to_owned(),
            preset.medium_speed_px_per_frame,
            "at most half of (the smaller radius − 1 px) in a field with walls or posts, so that \
             bodies do not jump over them",
        );
    }
    findings
}

const RADIUS_RANGE: &str = "1 px to half the field's side";

fn is_radius(value: f32, half_side_px: f32) -> bool {
    (1.0..=half_side_px).contains(&value)
}

impl Wall {
    fn length_px(&self) -> f32 {
        let [from, to] = self.ends();
        let (dx, dy) = (to.x_px - from.x_px, to.y_px - from.y_px);
        (dx * dx + dy * dy).sqrt()
    }
}

/// Checks every place against every wall and post; obstacles with NaN are never near.
pub(crate) fn blocked_places(preset: &Preset, places: &[RequiredPlace]) -> Vec<Finding> {
    let wall = |(k, wall): (usize, &Wall)| {
        let alone = Constants::obstacles(preset, &[*wall], &[]);
        (format!("wall {}", k + 1), alone)
    };
    let post = |(k, post): (usize, &Post)| {
        let alone = Constants::obstacles(preset, &[], &[*post]);
        (format!("post {}", k + 1), alone)
    };
    let walls = preset.walls.iter().enumerate().map(wall);
    let posts = preset.posts.iter().enumerate().map(post);
    let near = |(name, alone): (String, Obstacles)| {
        let near = |place: &&RequiredPlace| alone.clearance_px(place.position) < place.radius_px;
        let finding = |place: &RequiredPlace| {
            let key = format!("the distance from {name} to {}", place.name);
            Finding::new(key, alone.clearance_px(place.position), place.needs)
        };
        places.iter().filter(near).map(finding).collect::<Vec<_>>()
    };
    walls.chain(posts).flat_map(near).collect()
}

/// Returns the configured posts, then the random ones, at whole px.
pub(crate) fn place_posts(preset: &Preset, places: &[RequiredPlace]) -> Result<Vec<Post>, Finding> {
    let mut posts = preset.posts.to_vec();
    let Some(DrawnPosts {
        count,
        radius_px,
        seed: named,
    }) = preset.drawn_posts
    else {
        return Ok(posts);
    };
    let halves = [named >> 16, named & 0xffff].map(|half| half as f32);
    let mut stream = Stream(seed(halves.into_iter()).max(1));
    let limit = (preset.half_side_px - radius_px) as i32;
    for _ in 0..count {
        let mut coordinate = || (stream.word() % (2 * limit + 1) as u32) as i32 - limit;
        let anywhere = |_| Post {
            at_px: [coordinate() as f32, coordinate() as f32],
            radius_px,
        };
        let free = |post: &Post| {
            let alone = Constants::obstacles(preset, &[], &[*post]);
            let clear =
                |place: &RequiredPlace| alone.clearance_px(place.position) >= place.radius_px;
            places.iter().all(clear)
        };
        let post = (0..ATTEMPTS).map(anywhere).find(free);
        posts.push(post.ok_or_else(|| {
            let needs = "room outside starts, object and goals: fewer or smaller posts";
            Finding::new("count of drawn_posts", count.into(), needs)
        })?);
    }
    Ok(posts)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::Model;

    fn wall(from_px: [f32; 2], to_px: [f32; 2]) -> Wall {
        Wall { from_px, to_px }
    }

    fn post(at_px: [f32; 2], radius_px: f32) -> Post {
        Post { at_px, radius_px }
    }

    /// N: starts at (±200, ±200), goals on a square of half side 250, radii 25 and 50.
    #[test]
    fn all_obstacle_findings_are_reported_together() {
        let nan = f32::NAN;
        let rows: [(&[Wall], &[Post], &[&str]); 10] = [
            (
                &[wall([-150.0, 90.0], [150.0, 90.0])],
                &[post([100.0, -90.0], 20.0)],
                &[],
            ),
            (
                &[wall([-300.0, 190.0], [-100.0, 190.0])],
                &[],
                &["the distance from wall 1 to the start of agent 1"],
            ),
            (
                &[wall([0.0, 0.0], [0.0, 100.0])],
                &[],
                &["the distance from wall 1 to the start of the object"],
            ),
            (
                &[],
                &[post([250.0, 0.0], 10.0)],
                &["the distance from post 1 to goal 1"],
            ),
            (
                &[wall([nan, 0.0], [90.0, 90.0])],
                &[],
                &["from_px of wall 1"],
            ),
            (
                &[wall([0.0, 90.0], [0.0, 90.0])],
                &[],
                &["the length of wall 1"],
            ),
            (
                &[wall([0.0, 90.0], [0.0, 401.0])],
                &[],
                &["to_px of wall 1"],
            ),
            (
                &[],
                &[post([0.0, 150.0], f32::INFINITY)],
                &["radius_px of post 1", "the distance from post 1"],
            ),
            (
                &[],
                &[post([0.0, f32::NEG_INFINITY], 10.0)],
                &["at_px of post 1"],
            ),
            (
                &[
                    wall([nan, 0.0], [0.0, nan]),
                    wall([-300.0, -300.0], [300.0, 300.0]),
                ],
                &[post([0.0, 500.0], 0.5)],
                &[
                    "from_px of wall 1",
                    "to_px of wall 1",
                    "the distance from wall 2 to the start of agent 2",
                    "wall 2 to the start of agent 3",
                    "wall 2 to the start of the object",
                    "wall 2 to goal 2",
                    "wall 2 to goal 6",
                    "at_px of post 1",
                    "radius_px of post 1",
                ],
            ),
        ];
        for (walls, posts, expected) in rows {
            let preset = Preset {
                walls: walls.to_vec().into(),
                posts: posts.to_vec().into(),
                ..Preset::N
            };
            let found = Model::new(preset).map_or_else(|e| e.to_string(), |_| String::new());
            assert_eq!(found.is_empty(), expected.is_empty(), "{found}");
            for expected in expected {
                assert!(
                    found.contains(expected),
                    "{found:?} does not contain {expected:?}"
                );
            }
        }
    }

    #[test]
    fn too_many_obstacles_and_long_moves_are_rejected() {
        let far = wall([-390.0, 390.0], [-380.0, 390.0]);
        let drawn = |count| {
            Some(DrawnPosts {
                count,
                radius_px: 5.0,
                seed: 1,
            })
        };
        let preset = |walls: usize, count, medium_speed_px_per_frame| Preset {
            walls: vec![far; walls].into(),
            drawn_posts: drawn(count),
            medium_speed_px_per_frame,
            ..Preset::N
        };
        let keys = |preset| Model::new(preset).map_err(|e| e.keys().join(" ")).err();
        assert_eq!(keys(preset(8, 8, 12.0)), None);
        let number = "the number of walls and posts".to_owned();
        assert_eq!(keys(preset(8, 9, 12.0)), Some(number));
        let speed = "medium_speed_px_per_frame".to_owned();
        assert_eq!(keys(preset(1, 0, 12.1)), Some(speed));
        let crowd = Preset {
            drawn_posts: Some(DrawnPosts {
                count: 1,
                radius_px: 250.0,
                seed: 1,
            }),
            ..Preset::N
        };
        assert_eq!(keys(crowd), Some("count of drawn_posts".to_owned()));
    }

    #[test]
    fn random_posts_are_reproducible_and_free_of_contact() {
        let posts = |seed| {
            let preset = Preset {
                drawn_posts: Some(DrawnPosts {
                    count: 12,
                    radius_px: 20.0,
                    seed,
                }),
                ..Preset::R3
            };
            Model::new(preset).expect("room").posts().to_vec()
        };
        assert_eq!(posts(7), posts(7));
        let draws = if cfg!(miri) { 2 } else { 50 };
        let mut all: Vec<Post> = (0..draws).flat_map(posts).collect();
        for post in &all {
            let [x, y] = post.at_px;
            assert!(x.abs() <= 380.0 && y.abs() <= 380.0, "{post:?}");
            assert!(
                (x * x + y * y).sqrt() >= 70.0,
                "{post:?} overlaps the object"
            );
        }
        all.sort_by(|a, b| a.at_px.partial_cmp(&b.at_px).expect("finite"));
        all.dedup();
        let (different, drawn) = (all.len(), 12 * draws as usize);
        assert!(
            different > drawn * 11 / 12,
            "only {different} positions of {drawn} are different"
        );
    }
}
