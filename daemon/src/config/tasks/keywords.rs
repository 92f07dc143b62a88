//! Keywords of a step; an unknown one is rejected with a suggestion.

use atas_core::modules::{IDS, Selection};
use atas_core::tasks::{MOTIONS, Motion, TRANSITIONS, Transition, WAYPOINTS, Waypoint};
use shm_schemas::ModuleId;
use toml::Value;

use super::super::keys::SIMILARITY_MIN;

pub(super) fn motion(word: &str, waypoint: Option<&str>) -> Result<Motion, String> {
    let known = MOTIONS.into_iter().find(|motion| motion.name() == word);
    let motion =
        known.ok_or_else(|| unknown("motion", word, MOTIONS.into_iter().map(Motion::name)))?;
    match (motion.waypoint(), waypoint) {
        (None, None) => Ok(motion),
        (None, Some(_)) => Err(format!(
            "motion \"{word}\" goes to no waypoint; leave waypoint out"
        )),
        (Some(_), None) => Err(format!(
            "motion \"{word}\" has no waypoint, needs one of {}",
            list(WAYPOINTS.into_iter().map(Waypoint::name))
        )),
        (Some(_), Some(waypoint)) => Ok(motion.with_waypoint(read_waypoint(waypoint)?)),
    }
}

fn read_waypoint(word: &str) -> Result<Waypoint, String> {
    let known = WAYPOINTS
        .into_iter()
        .find(|waypoint| waypoint.name() == word);
    known.ok_or_else(|| unknown("waypoint", word, WAYPOINTS.into_iter().map(Waypoint::name)))
}

/// Parses a transition; only `met` has a point.
pub(super) fn transition(word: &str, point: Option<&Value>) -> Result<Transition, String> {
    let known = TRANSITIONS.into_iter().find(|until| until.name() == word);
    let until = known.ok_or_else(|| {
        unknown(
            "transition",
            word,
            TRANSITIONS.into_iter().map(Transition::name),
        )
    })?;
    match (until, point) {
        (Transition::Met(_), Some(value)) => value
            .as_integer()
            .and_then(|point| u8::try_from(point).ok())
            .filter(|point| (1..u8::MAX).contains(point))
            .map(Transition::Met)
            .ok_or_else(|| format!("point is {value}, needs a whole number from 1 to 254")),
        (Transition::Met(_), None) => {
            Err("transition \"met\" has no point, needs 1 to 254".to_owned())
        }
        (_, Some(_)) => Err(format!(
            "transition \"{word}\" has no point; leave point out"
        )),
        (until, None) => Ok(until),
    }
}

/// Parses module names. The part of a name before its comma may be omitted.
pub(super) fn modules(value: Option<&Value>) -> Result<Selection, String> {
    let Some(value) = value else {
        return Ok(Selection::NONE);
    };
    let names = value.as_array().and_then(|list| {
        let names: Option<Vec<_>> = list.iter().map(Value::as_str).collect();
        names
    });
    let names =
        names.ok_or_else(|| format!("modules is {value}, needs a list of names in quotes"))?;
    names.into_iter().try_fold(Selection::NONE, |sum, name| {
        module(name).map(|id| sum.union(Selection::from_modules(&[id])))
    })
}

fn module(name: &str) -> Result<ModuleId, String> {
    let known = IDS
        .into_iter()
        .find(|id| id.name() == name || short(id.name()) == name);
    let names = || IDS.into_iter().map(ModuleId::name);
    known.ok_or_else(|| unknown("module", name, names().chain(names().map(short))))
}

fn short(name: &'static str) -> &'static str {
    name.rsplit_once(", ").map_or(name, |(_, short)| short)
}

/// Error for an unknown keyword, with a suggestion or all known ones.
pub(super) fn unknown(
    what: &str,
    word: &str,
    known: impl Iterator<Item = &'static str> + Clone,
) -> String {
    let likely = known
        .clone()
        .map(|known| (strsim::jaro_winkler(known, word), known))
        .filter(|(likeness, _)| *likeness > SIMILARITY_MIN)
        .max_by(|a, b| a.0.total_cmp(&b.0));
    match likely {
        Some((_, meant)) => format!("\"{word}\" is no {what}; did you mean \"{meant}\"?"),
        None => format!("\"{word}\" is no {what}, needs one of {}", list(known)),
    }
}

fn list(words: impl Iterator<Item = &'static str>) -> String {
    words.collect::<Vec<_>>().join(", ")
}
