//! Processes of the swarm demo on a separate bus, supervised until every goal has been tried.

use std::path::Path;

use anyhow::Context;
use atas_client::POLL;
use atas_console::arguments::DemoSwarm;
use atas_console::{Interrupt, Progress};
use ebts::condition::GOALS;
use ebts::table_file::TableFile;
use shm_bus::{Bus, FreshBus, Realtime};
use shm_schemas::{AgentSensors, service};
use sim_backend::swarm::TrialReport;

use atas_demo::page::Page;
use atas_processes::child::Child;
use atas_processes::logs::{self, Logs};

/// Field process, agents and dashboard. Fields are dropped in this order.
pub(super) struct Arena {
    page: Option<Page>,
    field: Child,
    agents: Child,
    bus: FreshBus,
    logs: Logs,
}

impl Arena {
    /// Starts the field for which the table was evolved, then the agents; with a dashboard, waits
    /// until its page is open.
    pub(super) fn start(
        arguments: &DemoSwarm,
        file: &TableFile,
        interrupt: &Interrupt,
        progress: &mut Progress,
    ) -> anyhow::Result<Self> {
        logs::remove_stale();
        let bus = FreshBus::new("demo");
        let logs = Logs::new(&bus)?;
        let field = start_field(arguments, file, &bus, &logs.folder)?;
        // The field waits for its agents, and the agents start after the page is open.
        let mut page = arguments
            .dashboard
            .then(|| Page::serve(&bus, &logs.folder))
            .transpose()?;
        if let Some(page) = &mut page {
            page.wait_until_open(progress, interrupt)?;
        }
        let drive = ["agents", "--bus", bus.as_str(), "--table", &arguments.table];
        let agents = Child::start("ebts", &drive, &logs.folder)?;
        Ok(Self {
            page,
            field,
            agents,
            bus,
            logs,
        })
    }

    pub(super) fn watch(
        mut self,
        interrupt: &Interrupt,
        progress: &mut Progress,
    ) -> anyhow::Result<Vec<TrialReport>> {
        let watched = self.trials(interrupt, progress);
        self.logs.keep |= watched.is_err() && !interrupt.is_set();
        if let (Some(page), Ok(_)) = (&mut self.page, &watched) {
            page.keep_running(progress, interrupt)?;
        }
        watched
    }

    fn trials(
        &mut self,
        interrupt: &Interrupt,
        progress: &mut Progress,
    ) -> anyhow::Result<Vec<TrialReport>> {
        let bus = Bus::open(&self.bus, "atas-demo", Realtime::No)?;
        let mut frames = bus.subscriber::<AgentSensors>(service::AGENT_SENSORS)?;
        let (mut frame, mut reported) = (AgentSensors::default(), 0);
        loop {
            interrupt.check("the demo terminated its processes and removed its bus")?;
            // The field ends after its last trial: read its output before its exit is treated as an
            // error.
            let (field, agents) = (self.field.check(), self.agents.check());
            let trials = self.reports()?;
            for trial in &trials[reported..] {
                progress.show_activity(&trial_text(trial));
            }
            reported = trials.len();
            if reported == GOALS {
                return Ok(trials);
            }
            field.and(agents)?;
            if frames.newest(&mut frame)? {
                progress.show_live(&format!("goal {}: frame {}", frame.trial + 1, frame.frame));
            }
            std::thread::sleep(POLL);
        }
    }

    fn reports(&self) -> anyhow::Result<Vec<TrialReport>> {
        let lines = self.field.results();
        let parse = |line: &String| {
            serde_json::from_str(line).context(
                "could not parse the output \
            of atas-sim as JSON",
            )
        };
        lines.iter().map(parse).collect()
    }
}

/// Starts the field for which a table was evolved, in lock-step or at the requested frame rate.
fn start_field(
    arguments: &DemoSwarm,
    file: &TableFile,
    bus: &FreshBus,
    logs: &Path,
) -> anyhow::Result<Child> {
    let preset = logs.join("preset.toml");
    std::fs::write(&preset, toml::to_string(file.condition.model.preset())?)
        .with_context(|| format!("could not write {}", preset.display()))?;
    let (preset, team, rate) = (
        preset.to_string_lossy(),
        file.condition.team.get().to_string(),
        arguments.frame_rate_hz.to_string(),
    );
    let mut words = vec!["field", "--bus", bus.as_str(), "--format", "json"];
    words.extend(["--preset", &*preset, "--agents", &*team]);
    match arguments.lockstep {
        true => words.push("--lockstep"),
        false => words.extend(["--frame-rate-hz", &*rate]),
    }
    Child::start("atas-sim", &words, logs)
}

fn trial_text(trial: &TrialReport) -> String {
    let px = trial.outcomes[0].evaluated.goal_px;
    match trial.solved() {
        0 => format!("goal {}: missed, the object is {px:.0} px away", trial.goal),
        _ => format!("goal {}: reached, {px:.0} px from its centre", trial.goal),
    }
}
