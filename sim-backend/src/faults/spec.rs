//! Fault description `KIND[=VALUE]@START[+LENGTH][:TARGET]`, times in seconds.
//!
//! `drop=0.3@2+0.5:right` drops 30 % of the right hand's frames for 0.5 s from second 2. Without a
//! length the fault is permanent; without a target it applies to both hands (joint faults: to the
//! joints).

use std::str::FromStr;

/// Kind of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(
    missing_docs,
    reason = "the table of FaultKind::all describes each kind"
)]
pub enum FaultKind {
    Drop,
    Delay,
    Duplicate,
    Reorder,
    Burst,
    Freeze,
    Stick,
    Nan,
    Huge,
    Denormal,
    Bias,
    Saturate,
    Corrupt,
    Future,
    Stale,
    Epoch,
    Wrap,
    Foreign,
    Jump,
}

/// Targets that a kind of fault supports.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    Any,
    Hands,
    Joints,
}

/// Description of a kind of fault.
#[derive(Debug)]
pub struct FaultInfo {
    kind: FaultKind,
    /// Name in the fault description.
    pub name: &'static str,
    /// Effect, and meaning of the value.
    pub about: &'static str,
    /// Default value.
    pub value: f64,
    /// Lowest and highest value; both zero if the kind has no value.
    pub range: [f64; 2],
    scope: Scope,
}

#[rustfmt::skip]
const TABLE: &[FaultInfo] = {
    use FaultKind::*;
    use Scope::*;
    const fn info(kind: FaultKind, name: &'static str, about: &'static str, value: f64, range: [f64; 2], scope: Scope) -> FaultInfo {
        FaultInfo { kind, name, about, value, range, scope }
    }
    &[
        info(Drop, "drop", "payloads are lost with this probability", 1.0, [0.0, 1.0], Any),
        info(Delay, "delay", "payloads arrive this many milliseconds late", 10.0, [1.0, 1000.0], Any),
        info(Duplicate, "duplicate", "every payload arrives twice", 0.0, [0.0, 0.0], Any),
        info(Reorder, "reorder", "neighbouring payloads swap their order", 0.0, [0.0, 0.0], Any),
        info(Burst, "burst", "payloads are held back and arrive this many at once", 20.0, [2.0, 64.0], Any),
        info(Freeze, "freeze", "content is frozen while the sequence counter continues", 0.0, [0.0, 0.0], Any),
        info(Stick, "stick", "the element with this index repeats its reading", 0.0, [0.0, 40.0], Hands),
        info(Nan, "nan", "this many readings, from the first, are NaN", 1.0, [1.0, 41.0], Any),
        info(Huge, "huge", "the first reading is this large, N or rad", 1e9, [-1e30, 1e30], Any),
        info(Denormal, "denormal", "every reading is a denormal number", 0.0, [0.0, 0.0], Hands),
        info(Bias, "bias", "normal forces drift by this many newtons per second", 0.01, [-10.0, 10.0], Hands),
        info(Saturate, "saturate", "every normal force reads this, N", 25.0, [0.0, 1e3], Hands),
        info(Corrupt, "corrupt", "a bit flips after the seal with this probability", 1.0, [0.0, 1.0], Hands),
        info(Future, "future", "timestamps are this many seconds ahead", 0.01, [0.0, 1e9], Any),
        info(Stale, "stale", "timestamps are this many seconds behind", 0.01, [0.0, 1e9], Any),
        info(Epoch, "epoch", "the writer epoch changes and the sequence counter restarts", 0.0, [0.0, 0.0], Any),
        info(Wrap, "wrap", "the sequence counter wraps to zero after this many payloads from the \
            world's start", 1000.0, [1.0, 1e9], Any),
        info(Foreign, "foreign", "frames carry the id of the other hand", 0.0, [0.0, 0.0], Hands),
        info(Jump, "jump", "every joint position is offset by this, rad", 0.5, [-10.0, 10.0], Joints),
    ]
};

/// Channel that a fault applies to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// Frames of the left hand.
    Left,
    /// Frames of the right hand.
    Right,
    /// Frames of both hands.
    Hands,
    /// Joint feedback.
    Joints,
}

/// Fault with its time and target.
///
/// ```
/// use sim_backend::faults::Fault;
///
/// assert!("melt@1".parse::<Fault>().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fault {
    /// Kind.
    pub kind: FaultKind,
    /// Value; its meaning depends on the kind.
    pub value: f64,
    /// First active tick.
    pub first_tick: u64,
    /// First tick after the fault.
    pub end_tick: u64,
    /// Channel.
    pub target: Target,
}

/// Error in a fault description.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FaultError {
    /// Missing start.
    #[error(
        "could not read the fault {0:?}: it lacks a start, needs \
         KIND[=VALUE]@START[+LENGTH][:TARGET]; e.g. drop=0.3@2+0.5:right"
    )]
    Form(String),
    /// Unknown kind.
    #[error("could not read the fault {text:?}: unknown kind {kind:?}, needs one of {known}")]
    Kind {
        /// Fault description.
        text: String,
        /// Given kind.
        kind: String,
        /// Known kinds.
        known: String,
    },
    /// Value that is not a number or out of range.
    #[error("could not read the fault {text:?}: {what} is {value:?}, needs {lower} to {upper}")]
    Number {
        /// Fault description.
        text: String,
        /// Name of the value.
        what: &'static str,
        /// Given value.
        value: String,
        /// Lowest allowed value.
        lower: f64,
        /// Highest allowed value.
        upper: f64,
    },
    /// Target that the kind does not support.
    #[error(
        "could not read the fault {text:?}: unsupported target {target:?}, needs one of {known}"
    )]
    Target {
        /// Fault description.
        text: String,
        /// Given target.
        target: String,
        /// Supported targets.
        known: &'static str,
    },
}

/// Largest start and length of a fault, s: one day.
const TIME_MAX_S: f64 = 86_400.0;

impl FaultKind {
    /// Returns every kind.
    #[must_use]
    pub fn all() -> &'static [FaultInfo] {
        TABLE
    }
}

impl Target {
    /// Returns true if a fault with this target applies to a channel.
    pub(super) fn covers(self, channel: Self) -> bool {
        self == channel || (self == Self::Hands && matches!(channel, Self::Left | Self::Right))
    }

    fn from_name(name: &str, scope: Scope) -> Option<Self> {
        match name {
            "left" if scope != Scope::Joints => Some(Self::Left),
            "right" if scope != Scope::Joints => Some(Self::Right),
            "hands" if scope != Scope::Joints => Some(Self::Hands),
            "joints" if scope != Scope::Hands => Some(Self::Joints),
            _ => None,
        }
    }
}

impl FaultInfo {
    /// Returns the supported targets as a list.
    #[must_use]
    pub fn targets(&self) -> &'static str {
        self.scope.names()
    }
}

impl Scope {
    fn names(self) -> &'static str {
        match self {
            Self::Any => "left, right, hands, joints",
            Self::Hands => "left, right, hands",
            Self::Joints => "joints",
        }
    }

    fn default_target(self) -> &'static str {
        if self == Self::Joints {
            "joints"
        } else {
            "hands"
        }
    }
}

impl Fault {
    pub(super) fn is_active(&self, tick: u64) -> bool {
        (self.first_tick..self.end_tick).contains(&tick)
    }
}

impl FromStr for Fault {
    type Err = FaultError;

    fn from_str(text: &str) -> Result<Self, FaultError> {
        let (what, when) = text
            .split_once('@')
            .ok_or_else(|| FaultError::Form(text.into()))?;
        let (name, value) = what
            .split_once('=')
            .map_or((what, None), |(name, value)| (name, Some(value)));
        let (when, target) = when
            .split_once(':')
            .map_or((when, None), |(when, target)| (when, Some(target)));
        let (start, length) = when
            .split_once('+')
            .map_or((when, None), |(start, length)| (start, Some(length)));
        let entry = TABLE
            .iter()
            .find(|info| info.name == name)
            .ok_or_else(|| unknown_kind(text, name))?;
        let seconds = |what, value| number(text, what, value, [0.0, TIME_MAX_S]);
        let first_tick = ticks(seconds("start", start)?);
        let length = length.map(|length| seconds("length", length)).transpose()?;
        let target = target.unwrap_or(entry.scope.default_target());
        Ok(Self {
            kind: entry.kind,
            value: value.map_or(Ok(entry.value), |value| {
                number(text, "value", value, entry.range)
            })?,
            first_tick,
            end_tick: length.map_or(u64::MAX, |length_s| first_tick + ticks(length_s)),
            target: Target::from_name(target, entry.scope).ok_or_else(|| FaultError::Target {
                text: text.into(),
                target: target.into(),
                known: entry.scope.names(),
            })?,
        })
    }
}

fn unknown_kind(text: &str, kind: &str) -> FaultError {
    let known: Vec<&str> = TABLE.iter().map(|info| info.name).collect();
    FaultError::Kind {
        text: text.into(),
        kind: kind.into(),
        known: known.join(", "),
    }
}

/// Parses a number within a range.
fn number(
    text: &str,
    what: &'static str,
    value: &str,
    [lower, upper]: [f64; 2],
) -> Result<f64, FaultError> {
    match value.parse() {
        Ok(number) if number >= lower && number <= upper => Ok(number),
        _ => Err(FaultError::Number {
            text: text.into(),
            what,
            value: value.into(),
            lower,
            upper,
        }),
    }
}

fn ticks(seconds: f64) -> u64 {
    (seconds * 1e3).round() as u64
}
