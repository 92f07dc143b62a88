//! Object files: built-in objects, user files and rejections.

use std::io::Write;

use sim_backend::{ClosingDirection, Object, ObjectError, Shape};

const BOX: &str = r#"
    name = "mine"
    mass_kg = 0.1
    friction = 0.4
    shape = { kind = "box", size_m = [0.05, 0.04, 0.06] }
"#;

#[test]
fn built_in_objects_match_the_tactile_design() {
    // Name, required normal force, crushable.
    let expected = [
        ("wood", 2.94, false),
        ("slippery-200", 3.92, false),
        ("slippery-50", 1.23, false),
        ("paper-box", 0.25, true),
        ("sponge", 0.12, true),
        ("bottle", 4.91, true),
        ("heavy-block", 18.39, false),
        ("filled-paper-box", 1.47, true),
    ];
    assert!(Object::names().eq(expected.iter().map(|(name, ..)| *name)));
    for (name, needed_n, crushable) in expected {
        let object = Object::built_in(name).expect(name);
        assert_eq!(object.name, name, "file name equals object name");
        assert!(
            (object.required_normal_n() - needed_n).abs() < 0.005,
            "{name} needs {} N",
            object.required_normal_n()
        );
        assert_eq!(object.crush_n.is_finite(), crushable, "{name}");
    }
}

#[test]
fn user_file_is_loaded() {
    let mut file = tempfile::Builder::new()
        .suffix(".toml")
        .tempfile()
        .expect("temporary file");
    file.write_all(BOX.as_bytes()).expect("file is writable");
    let path = file.path().to_str().expect("UTF-8 path");
    let object = Object::from_name_or_file(path).expect("valid object");
    assert_eq!((object.name.as_str(), object.mass_kg), ("mine", 0.1));
    assert!(matches!(object.shape, Shape::Box { half_m } if half_m.y == 0.02));
    assert!(object.stiffness_n_m.is_infinite() && object.crush_n.is_infinite());
}

#[test]
fn errors_state_key_value_and_range() {
    let check = |from: &str, to: &str, parts: &[&str]| {
        assert!(BOX.contains(from), "{from}");
        let text = BOX.replace(from, to);
        let message = Object::parse(&text, "mine.toml")
            .expect_err(&text)
            .to_string();
        for part in ["mine.toml"].iter().chain(parts) {
            assert!(message.contains(part), "{to}: {message}");
        }
    };
    check("0.1", "0.001", &["mass_kg is 0.001, needs 0.0125 to 5"]);
    check("0.1", "nan", &["mass_kg is NaN"]);
    check("0.4", "inf", &["friction is inf, needs 0.05 to 2"]);
    check(
        "0.06]",
        "0.6]",
        &["shape.size_m[2] is 0.6, needs 0.01 to 0.3"],
    );
    check("mass_kg = 0.1", "", &["missing field `mass_kg`"]);
    check("0.4", "\"slippery\"", &["friction", "expected f64"]);
    check(
        "friction",
        "frction",
        &["unknown field `frction`", "line 4"],
    );
    check(
        "\"box\"",
        "\"sphere\"",
        &["unknown variant `sphere`", "`box`", "`cylinder`"],
    );
    check("size_m", "size", &["size"]);
    check("0.04, 0.06", "0.04", &["size_m"]);
    check(
        "\"mine\"",
        "\"\"",
        &["the length of name in bytes is 0, needs 1 to 31"],
    );
    check(
        "friction = 0.4",
        "friction = 0.4\nstiffness_n_m = 1.0",
        &["stiffness_n_m is 1, needs 100"],
    );
    check(
        "friction = 0.4",
        "friction = 0.4\ncrush_n = -1.0",
        &["crush_n is -1, needs 0.1"],
    );
    check("]", "], radius_m = 1.0", &["radius_m"]);
}

#[test]
fn cap_has_a_thread_and_bottle_a_neck() {
    let part = |name| Object::built_in(name).expect(name);
    assert!(Object::part_names().eq(["cap", "open-bottle"]));
    let thread = part("cap").thread.expect("cap has a thread");
    assert_eq!((thread.friction_n_m, thread.pitch_m), (0.015, 0.003));
    assert_eq!(
        thread.closes,
        ClosingDirection::Clockwise,
        "default direction"
    );
    assert!((thread.closing_rad.to_degrees() - 240.0).abs() < 1e-9);
    assert_eq!(
        part("open-bottle").neck.expect("bottle has a neck").rim_m,
        0.11
    );
    assert!(Object::names().all(|name| part(name).thread.is_none() && part(name).neck.is_none()));
}

#[test]
fn invalid_caps_and_bottles_are_rejected() {
    const CYLINDER: &str = "name = \"c\"\nmass_kg = 0.02\nfriction = 0.5\n\
        shape = { kind = \"cylinder\", radius_m = 0.02, height_m = 0.05 }\n";
    let check = |from: &str, to: &str, part: &str| {
        assert!(CYLINDER.contains(from), "{from}");
        let message = Object::parse(&CYLINDER.replace(from, to), "c.toml")
            .expect_err(to)
            .to_string();
        assert!(message.contains(part), "{to}: {message}");
    };
    let thread = |change: &str| {
        format!("{{ friction_n_m = 0.01, closing_deg = 90, pitch_m = 0.003, {change} }}")
    };
    let with_thread = |change: &str| format!("friction = 0.5\nthread = {}", thread(change));
    check(
        "friction = 0.5",
        &with_thread("closes = \"up\""),
        "unknown variant `up`",
    );
    check(
        "friction = 0.5",
        &with_thread("lead_m = 1.0"),
        "unknown field `lead_m`",
    );
    for (key, value, range) in [
        (
            "friction_n_m = 0.01",
            "friction_n_m = nan",
            "thread.friction_n_m is NaN, needs 0.001 to 0.2",
        ),
        (
            "closing_deg = 90",
            "closing_deg = 3",
            "thread.closing_deg is 3, needs 30 to 1440",
        ),
        (
            "pitch_m = 0.003",
            "pitch_m = 3",
            "thread.pitch_m is 3, needs 0.0005 to 0.01",
        ),
    ] {
        let text = with_thread("").replace(key, value).replace(", }", " }");
        check("friction = 0.5", &text, range);
    }
    check(
        "friction = 0.5",
        "friction = 0.5\nneck = { rim_m = 0.05 }",
        "neck.rim_m is 0.05, needs 0.06",
    );
    check(
        "mass_kg = 0.02",
        "mass_kg = 0.01",
        "mass_kg is 0.01, needs 0.0125",
    );
    let boxed = BOX.replace(
        "friction = 0.4",
        "friction = 0.4\n    neck = { rim_m = 0.1 }",
    );
    let message = Object::parse(&boxed, "b.toml")
        .expect_err("box with a neck is rejected")
        .to_string();
    assert!(message.contains("need shape.kind"), "{message}");
}

#[test]
fn unknown_name_lists_names_and_suggests_one() {
    let check = |name: &str, suggestion: Option<&str>| {
        let message = Object::from_name_or_file(name).expect_err(name).to_string();
        assert!(message.contains("wood, slippery-200"), "{message}");
        match suggestion {
            Some(known) => assert!(
                message.contains(&format!("did you mean {known:?}?")),
                "{message}"
            ),
            None => assert!(!message.contains("did you mean"), "{message}"),
        }
    };
    check("wod", Some("wood"));
    check("slippery", Some("slippery-50"));
    check("paperbox", Some("paper-box"));
    check("Bottle", Some("bottle"));
    check("elephant", None);
    check("", None);
}

#[test]
fn missing_file_error_states_the_path() {
    let error = Object::from_name_or_file("./no/such.toml").expect_err("missing file is rejected");
    assert!(matches!(error, ObjectError::Unreadable { .. }));
    assert!(error.to_string().contains("./no/such.toml"), "{error}");
}
