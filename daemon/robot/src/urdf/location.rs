//! Lines of the parts that errors name, and the first number of a URDF that is none.

use std::string::String;

/// Attributes of a URDF that contain numbers.
const NUMBERS: [&str; 20] = [
    "xyz",
    "rpy",
    "lower",
    "upper",
    "effort",
    "velocity",
    "radius",
    "length",
    "size",
    "scale",
    "value",
    "multiplier",
    "offset",
    "mass",
    "ixx",
    "ixy",
    "ixz",
    "iyy",
    "iyz",
    "izz",
];

/// An attribute of a URDF that should contain numbers.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct BadNumber {
    pub(super) line: usize,
    pub(super) attribute: String,
    pub(super) value: String,
}

/// Returns the line, from 1, of the element of this kind and name.
pub(super) fn element_line(urdf: &str, kind: &str, name: &str) -> Option<usize> {
    let mut tags = urdf.match_indices('<').map(|(at, _)| (at, &urdf[at + 1..]));
    let found = tags.find(|(_, rest)| {
        let tag = rest.split(['<', '>']).next().unwrap_or_default();
        let own = tag.strip_prefix(kind).unwrap_or_default();
        own.starts_with(char::is_whitespace)
            && attributes(own).any(|(key, value)| key == "name" && value == name)
    });
    found.map(|(at, _)| line_at(urdf, at))
}

/// Returns the line, from 1, that contains this name as a whole word.
pub(super) fn word_line(text: &str, name: &str) -> Option<usize> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == '-';
    let mut found = text.match_indices(name).map(|(at, _)| at).filter(|at| {
        let (before, after) = (&text[..*at], &text[at + name.len()..]);
        !before.ends_with(is_part) && !after.starts_with(is_part)
    });
    found.next().map(|at| line_at(text, at))
}

/// Returns the first attribute of numbers that contains something else.
pub(super) fn bad_number(urdf: &str) -> Option<BadNumber> {
    attributes(urdf)
        .filter(|(key, _)| NUMBERS.contains(key))
        .find(|(_, value)| {
            value
                .split_whitespace()
                .any(|word| word.parse::<f64>().is_err())
        })
        .map(|(attribute, value)| BadNumber {
            line: line_at(urdf, value.as_ptr() as usize - urdf.as_ptr() as usize),
            attribute: attribute.into(),
            value: value.into(),
        })
}

/// Attributes `key="value"` or `key='value'` of a text, in order.
fn attributes(text: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut rest = text;
    core::iter::from_fn(move || {
        loop {
            let (before, after) = rest.split_once('=')?;
            rest = after;
            let opened = after.trim_start();
            let Some(quote) = opened.chars().next().filter(|c| ['"', '\''].contains(c)) else {
                continue;
            };
            let (value, beyond) = opened[1..].split_once(quote)?;
            rest = beyond;
            let key = before.trim_end();
            let key = key.rsplit(|c: char| c.is_whitespace() || c == '<').next();
            return Some((key.unwrap_or_default(), value));
        }
    })
}

fn line_at(text: &str, at: usize) -> usize {
    text[..at].matches('\n').count() + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    const URDF: &str = "<?xml version='1.0'?>\n<link name=\"jaw\"/>\n<joint type='x'\n name='jaw'>\
        \n<axis xyz=\"0 1 0\"/>\n<joint name=\"jaw_2\"/>";

    #[test]
    fn element_is_found_by_kind_and_name() {
        let check = |kind, name, line| assert_eq!(element_line(URDF, kind, name), line, "{name}");
        check("link", "jaw", Some(2));
        check("joint", "jaw", Some(3));
        check("joint", "jaw_2", Some(6));
        check("joint", "ja", None);
        check("lin", "jaw", None);
        check("axis", "jaw", None);
    }

    #[test]
    fn word_is_found_as_a_whole() {
        let text = "a = 1\njaw_a = 2\n\"jaw\" = 3\n";
        assert_eq!(word_line(text, "jaw"), Some(3));
        assert_eq!(word_line(text, "jaw_a"), Some(2));
        assert_eq!(word_line(text, "w"), None);
    }

    #[test]
    fn text_instead_of_a_number_is_found() {
        assert_eq!(bad_number(URDF), None);
        for (good, bad) in [
            ("0 1 0", "0,5 1 0"),
            ("0 1 0", "0 ${a/2} 0"),
            ("0 1 0", "$(arg x)"),
        ] {
            let found = bad_number(&URDF.replace(good, bad)).expect("found");
            let expected = BadNumber {
                line: 5,
                attribute: "xyz".into(),
                value: bad.into(),
            };
            assert_eq!(found, expected);
        }
    }
}
