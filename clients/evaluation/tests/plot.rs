//! Tests of figures: content and reproducibility.

use std::path::Path;

use atas_evaluation::Task;
use atas_evaluation::figures::draw;
use sim_backend::Object;

fn drawn(task: Task, object: &str, seed: u64) -> String {
    let object = Object::built_in(object).expect("built in");
    draw(task, &object, seed).expect("it can be drawn")
}

#[test]
fn every_task_has_a_figure() {
    let check = |task: Task, object: &str, words: &[&str], lines: usize| {
        let svg = drawn(task, object, 1);
        for word in words {
            assert!(
                svg.contains(word),
                "{word:?} is missing from {}",
                task.name()
            );
        }
        assert!(svg.starts_with("<svg") && svg.trim_end().ends_with("</svg>"));
        assert_eq!(svg.matches("<text").count(), svg.matches("</text>").count());
        let drawn = svg.matches("<polyline").count();
        assert!(drawn >= lines, "{drawn} lines in {}", task.name());
        assert!(
            !svg.contains("NaN") && !svg.contains("inf"),
            "{}",
            task.name()
        );
        assert!(svg.len() < 400_000, "{} bytes", svg.len());
    };
    let modules = [
        "1 first touch",
        "2 slip",
        "3 force limit",
        "stiffness probe",
    ];
    let forces = [
        "F_n finger 1",
        "F_n finger 2",
        "F_t",
        ">\nF_1",
        ">\nF_2",
        "Force (N)",
        "Lift (mm)",
        "Time (s)",
    ];
    check(
        Task::Grasp,
        "bottle",
        &[modules.as_slice(), &forces].concat(),
        5,
    );
    let moments = ["support carries", "Module 4: hand opens", "fingertips off"];
    check(Task::PickPlace, "wood", &moments, 7);
    let turns = [
        "initial square",
        "cycles 1 to",
        "Angle (°)",
        "Torque (mN·m)",
        "Module 4",
    ];
    check(Task::Screw, "cap", &turns, 6);
    let hands = [
        "right hand",
        "left hand",
        "screw",
        "hold",
        "Grip (N)",
        "Module 4",
    ];
    check(Task::Assembly, "cap", &hands, 6);
}

/// Recovery steps, which the task's definition does not list, are labelled too.
#[test]
fn recovery_steps_are_labelled() {
    let svg = drawn(Task::Grasp, "heavy-block", 1);
    for step in ["lift", "open", "leave"] {
        assert!(svg.contains(&format!(">\n{step}\n<")), "{step} is missing");
    }
}

/// The needed force is drawn on the scale of the force axis, even above the hand's limit.
#[test]
fn needed_force_is_drawn_to_scale() {
    /// Returns the smallest y (upwards) of the lines with one colour and width, px.
    fn top(svg: &str, colour: &str, width: u32) -> f64 {
        let drawn = format!("stroke=\"{colour}\" stroke-width=\"{width}\" points=\"");
        let lines = svg
            .split(&drawn)
            .skip(1)
            .filter_map(|l| l.split('"').next());
        let points = lines.flat_map(str::split_whitespace);
        let y = points.filter_map(|point| point.split_once(',')?.1.parse().ok());
        y.fold(f64::INFINITY, f64::min)
    }
    // F_2 of a rigid object, N.
    const F2_N: f64 = 8.0;
    for object in ["wood", "bottle", "heavy-block"] {
        let svg = drawn(Task::Grasp, object, 1);
        let (_, title) = svg
            .split_once(&format!("Grasp of {object}: "))
            .expect(object);
        let (mass_g, rest) = title.split_once(" g, μ ").expect("a mass");
        let friction = rest.split_whitespace().next().expect("a friction");
        let number = |text: &str| text.parse::<f64>().expect("a number");
        let needed_n = number(mass_g) * 9.81e-3 / (2.0 * number(friction));
        // The first axis left of the panels belongs to the forces.
        let axis = svg.split("points=\"219,").nth(1).expect("an axis");
        let bottom = axis.split([',', ' ']).nth(2).map(number).expect("an end");
        let height = |colour| bottom - top(&svg, colour, 3);
        let ratio = height("#787878") / height("#D55E00");
        assert!(
            (ratio / (needed_n / F2_N) - 1.0).abs() < 0.03,
            "{object} needs {needed_n:.2} N, drawn as {:.2} N",
            ratio * F2_N
        );
    }
}

#[test]
fn forces_and_thresholds_have_distinct_colours() {
    let svg = drawn(Task::Grasp, "wood", 1);
    // The legend alone has one line, or three dashes.
    let least = [
        ("#0072B2", 2),
        ("#56B4E9", 2),
        ("#E69F00", 4),
        ("#D55E00", 4),
    ];
    for (colour, least) in least {
        let lines = svg.split("<polyline").skip(1);
        let drawn = lines.filter(|line| line.split('>').next().is_some_and(|l| l.contains(colour)));
        assert!(drawn.count() >= least, "no line in {colour}");
    }
}

#[test]
fn same_seed_draws_same_bytes() {
    let [first, again, other] = [1, 1, 2].map(|seed| drawn(Task::Grasp, "sponge", seed));
    assert_eq!(first, again);
    assert_ne!(first, other);
}

#[test]
fn release_of_refused_object_is_not_drawn() {
    let heavy = Object::built_in("heavy-block").expect("built in");
    let error = draw(Task::PickPlace, &heavy, 1).expect_err("it is refused");
    assert!(error.to_string().contains("never stood"), "{error}");
}

/// The documentation shows these files; they must equal the output of `atas plot`.
#[test]
fn stored_figures_are_up_to_date() {
    let check = |file: &str, task: Task, object: &str, seed: u64| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("figures")
            .join(file);
        let kept = std::fs::read_to_string(path).expect("readable");
        assert!(
            kept == drawn(task, object, seed),
            "{file} differs from the output of `atas plot {}`; draw it again",
            task.name()
        );
    };
    check("grasp.svg", Task::Grasp, "wood", 1);
    check("placing.svg", Task::PickPlace, "wood", 1);
    check("screwing.svg", Task::Screw, "cap", 2);
    check("assembly.svg", Task::Assembly, "cap", 2);
}
