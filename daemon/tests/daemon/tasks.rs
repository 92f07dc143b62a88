//! User tasks: read, or rejected with task and step; a reload replaces them, but not in a running
//! goal.

use std::fs;

use atas_core::tasks::BUILT_IN;
use atasd::config::Tasks;
use rustix::process::Signal;
use shm_bus::FreshBus;
use shm_schemas::{Cause, GoalKind, GoalPolicy, GoalRequest, GoalState, Hand, Text};

use crate::config::{check_rejected, source};
use crate::goals::LockStep;
use crate::support::Daemon;

/// Task without an object: there, up.
fn reach_task(step: &str) -> String {
    format!(
        "[tasks.nod]\nacting = [\n\
         {{ step = \"{step}\", motion = \"reach\", waypoint = \"before-source\", modules = [\"carry\"], transition = \"arrived\", timeout_s = 20.0 }},\n\
         {{ step = \"up\", motion = \"reach\", waypoint = \"above\", modules = [\"carry\"], transition = \"arrived\", timeout_s = 20 }},\n\
         ]\n"
    )
}

fn goal(goal_id: u64, task: &str) -> GoalRequest {
    GoalRequest {
        goal_id,
        kind: GoalKind::CUSTOM,
        hand: Hand::RIGHT,
        policy: GoalPolicy::DETACHED,
        from_m: [0.3, -0.1, 0.08],
        width_m: 0.05,
        lift_m: 0.03,
        task: Text::new(task),
        ..GoalRequest::default()
    }
}

/// The output of `atasd --print-tasks` is an equivalent configuration.
#[test]
fn printed_built_in_tasks_read_back() {
    let (_folder, source) = source(&[&Tasks::built_in_text()], &[]);
    let config = source.load().expect("valid");
    // Users cannot define teleoperation tasks.
    let written: Vec<_> = BUILT_IN
        .into_iter()
        .filter(|task| !task.name.starts_with("teleop"))
        .collect();
    assert_eq!(config.tasks.as_slice().len(), written.len());
    for task in written {
        let own = format!("my-{}", task.name);
        let read = config
            .tasks
            .as_slice()
            .iter()
            .find(|t| t.name == own.as_str());
        let read = read.unwrap_or_else(|| panic!("{own} is missing"));
        assert_eq!((read.acting, read.helping), (task.acting, task.helping));
    }
    let (_folder, again) = crate::config::source(&[&config.text()], &[]);
    assert_eq!(again.load().expect("valid"), config);
}

#[test]
fn later_task_wins_and_short_names_work() {
    let texts = [reach_task("there"), reach_task("somewhere")];
    let (_folder, source) = source(&[&texts[0], &texts[1]], &[]);
    let config = source.load().expect("valid");
    assert_eq!(config.tasks.as_slice()[0].acting[0].name, "somewhere");
    assert_ne!(config.hash(), atasd::config::Config::default().hash());
    let long = "\"module 1, first touch\", \"module 3, force limit\"";
    let grip = |modules: &str| {
        let text = format!(
            "[tasks.squeeze]\nacting = [{{ step = \"grip\", motion = \"stay\", modules = [{modules}], \
             transition = \"gripped\", timeout_s = 5.0 }}]"
        );
        let (_folder, source) = crate::config::source(&[&text], &[]);
        source.load().expect("valid").tasks
    };
    assert_eq!(grip(long), grip("\"first touch\", \"force limit\""));
}

#[test]
fn invalid_task_is_reported_with_its_step() {
    let check = |steps: &str, wanted: &str| {
        let text = format!("\n[tasks.own]\nacting = [{steps}]");
        check_rejected(&[&text], &[], &format!("0.toml:2: tasks.own: {wanted}"));
    };
    let step = |rest: &str| format!("{{ step = \"go\", {rest} }}");
    let with = |motion: &str, rest: &str| step(&format!("motion = \"{motion}\", {rest}"));
    let ends = "transition = \"arrived\", timeout_s = 5.0";
    // Keywords.
    check(
        &with("reech", ends),
        "step 1 (go): \"reech\" is no motion; did you mean \"reach\"?",
    );
    check(
        &with("reach", &format!("waypoint = \"befor-source\", {ends}")),
        "step 1 (go): \"befor-source\" is no waypoint; did you mean \"before-source\"?",
    );
    check(
        &with("reach", ends),
        "step 1 (go): motion \"reach\" has no waypoint, needs one of tilted, before-source, around, source, lifted, \
         over-target, turn-start, above, home",
    );
    check(
        &with("stay", &format!("waypoint = \"home\", {ends}")),
        "step 1 (go): motion \"stay\" goes to no waypoint; leave waypoint out",
    );
    check(
        &with("stay", "transition = \"arived\""),
        "step 1 (go): \"arived\" is no transition; did you mean \"arrived\"?",
    );
    check(
        &with("stay", &format!("modules = [\"module 2, slips\"], {ends}")),
        "step 1 (go): \"module 2, slips\" is no module; did you mean \"module 2, slip\"?",
    );
    check(
        &with("stay", &format!("modules = \"slip\", {ends}")),
        "step 1 (go): modules is \"slip\", needs a list of names in quotes",
    );
    check(
        &step(&format!("motoin = \"stay\", {ends}")),
        "step 1 (go): \"motoin\" is no key; did you mean \"motion\"?",
    );
    check(&step(ends), "step 1 (go): has no motion");
    check("{ motion = \"stay\" }", "step 1 (?): has no step");
    check(
        "5",
        "step 1 (?): is 5, needs { step = …, motion = …, transition = …, … }",
    );
    // Meeting points and times.
    check(
        &with("stay", "transition = \"met\""),
        "step 1 (go): transition \"met\" has no point, needs 1 to 254",
    );
    check(
        &with("stay", "transition = \"met\", point = 255"),
        "step 1 (go): point is 255, needs a whole number from 1 to 254",
    );
    check(
        &with("stay", "transition = \"met\", point = 1"),
        "step 1 (go): waits for the other hand, which has no steps",
    );
    let carry = "waypoint = \"home\", modules = [\"carry\"], transition = \"arrived\"";
    for (timeout, message) in [("0", "0"), ("-2.5", "-2.5"), ("4000", "4000")] {
        check(
            &with("reach", &format!("{carry}, timeout_s = {timeout}")),
            &format!("step 1 (go): timeout_s is {message}, needs more than 0 and at most 3600"),
        );
    }
    for timeout in ["inf", "nan"] {
        check(
            &with("reach", &format!("{carry}, timeout_s = {timeout}")),
            &format!("step 1 (go): timeout_s is {timeout}, needs a number of seconds"),
        );
    }
    check(
        &with("reach", carry),
        "step 1 (go): has no timeout_s, needs one unless its transition is held or met",
    );
    // Rules.
    check("", "has no steps, needs at least one");
    let good = with("reach", &format!("{carry}, timeout_s = 5.0"));
    check(
        &[&good[..]; 33].join(", "),
        "has 33 steps, needs at most 32",
    );
    check(
        &with(
            "stay",
            "modules = [\"first touch\"], transition = \"gripped\", timeout_s = 5.0",
        ),
        "step 1 (go): presses an object, needs \"module 3, force limit\" among its modules",
    );
    check(
        &format!(
            "{good}, {}",
            with("carry", &format!("{carry}, timeout_s = 5.0"))
        ),
        "step 2 (go): presses an object, needs \"module 3, force limit\" among its modules",
    );
    check(
        &with(
            "lower",
            "modules = [\"transfer\", \"force limit\"], transition = \"concluded\", timeout_s = 5.0",
        ),
        "step 1 (go): needs \"module 4, release\" and transition = \"concluded\": no other transition ends this motion",
    );
    check(
        &with("reach", &format!("{carry}, timeout_s = 5.0"))
            .replace("\"go\"", "\"a name too long!!\""),
        "step 1 (a name too long!!): needs a step name of 1 to 16 lowercase letters, digits, spaces and hyphens",
    );
    let text = format!("[tasks.grasp]\nacting = [{good}]");
    check_rejected(
        &[&text],
        &[],
        "0.toml:1: tasks.grasp: is the name of a built-in task; choose another one",
    );
    let wait = with("stay", "transition = \"met\", point = 2");
    let text = format!("[tasks.two]\nacting = [{wait}]\nhelping = [{good}]");
    check_rejected(
        &[&text],
        &[],
        "0.toml:1: tasks.two: step 1 (go): waits at meeting point 2, which the other hand never reaches",
    );
    let text = format!(
        "[tasks.two]\nacting = [{good}]\nhelping = [{good}, {}]",
        with("squar", ends)
    );
    check_rejected(
        &[&text],
        &[],
        "0.toml:1: tasks.two: helping step 2 (go): \"squar\" is no motion; did you mean \"square\"?",
    );
    check_rejected(
        &["tasks.own = 5"],
        &[],
        "0.toml:1: tasks.own: is 5, needs to be a section with acting = [ steps ]",
    );
    check_rejected(
        &["tasks = 5"],
        &[],
        "0.toml:1: tasks is 5, needs to be a section with keys",
    );
}

fn behaviour_table_task(table: &str) -> String {
    format!(
        "[tasks.own]\nacting = [{{ step = \"lift\", motion = \"carry\", waypoint = \"lifted\", modules = [\"carry\", \
         \"force limit\", \"behaviour table\"], transition = \"arrived\", timeout_s = 20.0 }}]\ntable = {{ {table} }}"
    )
}

#[test]
fn behaviour_table_reads_back_or_is_rejected() {
    let bits = "bits = [\"slipping\", \"above-f2\"]";
    let levels = "fingers_m_s = [0.0, 0.002], hand = [0.0, -0.1, 0.1, 1]";
    let rows = "rows = \"03 12 00 01\"";
    let whole = format!("{bits}, {levels}, {rows}");
    let (_folder, source) = source(&[&behaviour_table_task(&whole)], &[]);
    let config = source.load().expect("valid");
    let table = config.tasks.as_slice()[0].table.expect("it has one");
    assert_eq!(table.levels(1), [1, 2]);
    let (_folder, again) = crate::config::source(&[&config.text()], &[]);
    assert_eq!(again.load().expect("valid"), config);
    let check = |table: String, wanted: &str| {
        let wanted = format!("0.toml:1: tasks.own: table: {wanted}");
        check_rejected(&[&behaviour_table_task(&table)], &[], &wanted);
    };
    check(
        format!("bits = [\"slipping\", \"above-f3\"], {levels}, {rows}"),
        "\"above-f3\" is no sensor bit; did you mean \"above-f2\"?",
    );
    check(
        format!("bits = [\"slipping\"], {levels}, {rows}"),
        "has 4 rows, needs 2: one per combination of its sensor bits",
    );
    check(
        format!("{bits}, {levels}, rows = \"03 12 00 21\""),
        "names an unknown level in row 3",
    );
    check(
        format!("{bits}, fingers_m_s = [0.5], hand = [1.0], rows = \"00 00 00 00\""),
        "has level 0.5 for fingers_m_s, needs a number from -0.02 to 0.02",
    );
    check(
        format!("{whole}, hash = \"00\""),
        &format!(
            "has hash = \"00\", but its content has {:016x}; leave the hash out after changing a \
             table",
            table.hash()
        ),
    );
}

/// Runs a goal; returns its steps and its end.
fn run_goal(
    world: &mut LockStep,
    goal: &GoalRequest,
    mut meanwhile: impl FnMut(&mut LockStep),
) -> (Vec<String>, GoalState, Cause) {
    let goals = world.world.bus.goal_client().expect("there is room");
    let mut pending = world.send(&goals, goal);
    let mut steps = Vec::<String>::new();
    loop {
        let update = world.until_update(&mut pending, |_| true);
        let step = update.step.as_str().to_owned();
        if steps.last() != Some(&step) {
            meanwhile(world);
            steps.push(step);
        }
        if update.state.is_final() {
            return (steps, update.state, update.reason.cause);
        }
    }
}

#[test]
fn reload_keeps_the_running_task() {
    let bus = FreshBus::new("tasks");
    let mut world = LockStep::open(&bus);
    let daemon = Daemon::start_with(&bus, &reach_task("there"), &["--lockstep"], |_| ());
    let named = |steps: &[&str]| steps.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();

    let rejected = run_goal(&mut world, &goal(1, "nodd"), |_| ());
    let expected = (named(&["nodd"]), GoalState::REJECTED, Cause::UNKNOWN_TASK);
    assert_eq!(rejected, expected, "named in the answer");

    let mut reloaded = false;
    let done = run_goal(&mut world, &goal(2, "nod"), |world| {
        if !std::mem::replace(&mut reloaded, true) {
            let before = world.world.newest.config_hash;
            fs::write(daemon.config_file(), reach_task("elsewhere")).expect("writable");
            daemon.signal(Signal::HUP);
            world.until("the reload", |status| status.config_hash != before);
        }
    });
    assert_eq!(
        done.0,
        named(&["there", "up", ""]),
        "unchanged during the goal"
    );
    assert_eq!(done.1, GoalState::SUCCEEDED);

    let done = run_goal(&mut world, &goal(3, "nod"), |_| ());
    assert_eq!(done.0, named(&["elsewhere", "up", ""]), "after the reload");

    fs::write(daemon.config_file(), reach_task("Nowhere")).expect("writable");
    daemon.signal(Signal::HUP);
    world.wait_for("the refusal", || {
        daemon
            .log()
            .contains("tasks.nod: step 1 (Nowhere): needs a step name of")
    });
    let done = run_goal(&mut world, &goal(4, "nod"), |_| ());
    assert_eq!(done.0, named(&["elsewhere", "up", ""]), "kept");
}
