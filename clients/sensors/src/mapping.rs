//! Scale and axis mapping of a three-axis sensor: device units to newtons.
//!
//! An element of a [`HandFrame`](shm_schemas::HandFrame) holds `[f_n, f_t1, f_t2]`, with `f_n`
//! positive under pressure. An OMD dome reports negative Fz when pressed along its axis. The
//! default mapping is therefore `f_n = −Fz, f_t1 = +Fx, f_t2 = +Fy`, written `-z,x,y`: outward
//! normal d = device +z, t1 = +x, t2 = +y. A dome turned by 90° about its own axis needs `-z,y,-x`.

use std::str::FromStr;

/// Largest accepted scale, N per count. Design choice: a full-scale reading would exceed three
/// million newtons.
const MAX_NEWTONS_PER_COUNT: f64 = 100.0;

/// Invalid scale or axis mapping.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MappingError {
    /// Invalid scale.
    #[error(
        "invalid scale {0:?}: needs three numbers X,Y,Z above 0 and at most 100 N per count, for \
         example 0.038,0.035,0.33 or 300/7925,300/8641,2000/6049"
    )]
    Scale(String),
    /// Invalid axis mapping.
    #[error(
        "invalid axis mapping {0:?}: needs x, y and z once each with an optional sign, in the \
         order f_n,f_t1,f_t2, for example -z,x,y"
    )]
    Axes(String),
}

/// Newtons per device unit along the device's x, y and z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale([f64; 3]);

impl FromStr for Scale {
    type Err = MappingError;

    fn from_str(text: &str) -> Result<Self, MappingError> {
        let refuse = || MappingError::Scale(text.to_owned());
        let values: Vec<f64> = text
            .split(',')
            .map(parse_quotient)
            .collect::<Option<_>>()
            .ok_or_else(refuse)?;
        let scale: [f64; 3] = values.try_into().map_err(|_| refuse())?;
        let sound = |v: &f64| v.is_finite() && *v > 0.0 && *v <= MAX_NEWTONS_PER_COUNT;
        if scale.iter().all(sound) {
            Ok(Self(scale))
        } else {
            Err(refuse())
        }
    }
}

/// Parses a number, or a data sheet's quotient newtons/counts.
fn parse_quotient(text: &str) -> Option<f64> {
    let number = |part: &str| part.trim().parse::<f64>().ok();
    match text.split_once('/') {
        Some((newtons, counts)) => Some(number(newtons)? / number(counts)?),
        None => number(text),
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct SignedAxis {
    index: usize,
    sign: f64,
}

impl SignedAxis {
    fn parse(text: &str) -> Option<Self> {
        let text = text.trim();
        let (sign, letter) = match text.strip_prefix('-') {
            Some(letter) => (-1.0, letter),
            None => (1.0, text.strip_prefix('+').unwrap_or(text)),
        };
        let index = ["x", "y", "z"]
            .iter()
            .position(|name| letter.eq_ignore_ascii_case(name))?;
        Some(Self { index, sign })
    }
}

/// Device axes of `f_n`, `f_t1` and `f_t2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes([SignedAxis; 3]);

impl FromStr for Axes {
    type Err = MappingError;

    fn from_str(text: &str) -> Result<Self, MappingError> {
        let refuse = || MappingError::Axes(text.to_owned());
        let axes: Vec<SignedAxis> = text
            .split(',')
            .map(SignedAxis::parse)
            .collect::<Option<_>>()
            .ok_or_else(refuse)?;
        let axes: [SignedAxis; 3] = axes.try_into().map_err(|_| refuse())?;
        let each_once = (0..3).all(|index| axes.iter().any(|axis| axis.index == index));
        if each_once {
            Ok(Self(axes))
        } else {
            Err(refuse())
        }
    }
}

/// Scale and axes of one three-axis sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Newtons per count.
    pub scale: Scale,
    /// Device axes of the force components.
    pub axes: Axes,
}

impl Mapping {
    /// Returns `[f_n, f_t1, f_t2]`, N, from `[x, y, z]` in device units. Finite if the inputs are.
    #[must_use]
    pub fn force_n(&self, value: [f64; 3]) -> [f32; 3] {
        self.axes
            .0
            .map(|axis| (axis.sign * self.scale.0[axis.index] * value[axis.index]) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::{Axes, Mapping, Scale};

    #[test]
    fn pressing_the_recorded_unit_gives_positive_normal_force() {
        let mapping = Mapping {
            scale: "300/7925, 300/8641,2000/6049".parse().unwrap(),
            axes: "-z,x,y".parse().unwrap(),
        };
        let [normal_n, t1_n, t2_n] = mapping.force_n([7925.0, -8641.0, -60.0]);
        assert_eq!((t1_n, t2_n), (300.0, -300.0));
        assert!((normal_n - 19.837).abs() < 1e-3, "{normal_n}");
    }

    #[test]
    fn axes_are_selected_with_sign() {
        let check = |axes: &str, expected: [f32; 3]| {
            let mapping = Mapping {
                scale: "1,10,100".parse().unwrap(),
                axes: axes.parse().unwrap(),
            };
            assert_eq!(mapping.force_n([1.0, 2.0, 3.0]), expected, "{axes}");
        };
        check("-z,x,y", [-300.0, 1.0, 20.0]);
        check("+Z, -y ,x", [300.0, -20.0, 1.0]);
        check("x,y,z", [1.0, 20.0, 300.0]);
    }

    #[test]
    fn invalid_scales_and_axes_are_rejected() {
        for text in [
            "", "1,2", "1,2,3,4", "1,2,x", "0,1,1", "-1,1,1", "NaN,1,1", "inf,1,1", "1/0,1,1",
            "0/0,1,1", "1e9,1,1",
        ] {
            assert!(text.parse::<Scale>().is_err(), "{text}");
        }
        for text in ["", "x,y", "x,y,y", "x,y,z,x", "--x,y,z", "u,v,w"] {
            assert!(text.parse::<Axes>().is_err(), "{text}");
        }
    }
}
