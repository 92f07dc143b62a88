//! State of the supervisor, and changes of the configuration at run time.

use atas_core::{OperatorRequest, SensorSetup, Settings};
use robot_model::{RobotModel, RobotVector};
use shm_schemas::{Mode, StatusFlags};

use crate::config::{Config, Source};
use crate::link::{SupervisorSide, TickRecord};

/// State shared by the parts of the supervisor.
#[derive(Debug)]
pub struct SupervisorState {
    /// Source of the configuration.
    pub source: Source,
    /// Effective configuration, settings included.
    pub config: Config,
    /// Its hash.
    pub config_hash: u64,
    /// The robot.
    pub robot: RobotModel,
    /// Sensor set-up of the controller.
    pub sensor_setup: SensorSetup,
    /// [`shm_schemas::StatusFlags`].
    pub flags: u32,
    /// Start time of the daemon, ns.
    pub started_ns: u64,
    /// Start time on the clock of the tick stamps, ns: in virtual time the first tick, and 0
    /// before.
    pub clock_start_ns: u64,
    /// Mode after the last tick.
    pub mode: Mode,
    /// Index of the last tick.
    pub tick: u64,
    /// Positions commanded by the last tick, rad, if any.
    pub commanded_position: Option<RobotVector>,
    /// The settings of `config`.
    pub settings: Settings,
    /// Number of records read.
    pub record_count: u64,
}

impl SupervisorState {
    /// State before the first tick.
    #[must_use]
    pub fn new(
        source: Source,
        config: Config,
        robot: RobotModel,
        wiring: SensorSetup,
        flags: u32,
    ) -> Self {
        let started_ns = shm_bus::now_ns();
        Self {
            config_hash: config.hash(),
            settings: config.settings(),
            source,
            config,
            robot,
            sensor_setup: wiring,
            flags,
            started_ns,
            clock_start_ns: match flags & StatusFlags::LOCKSTEP {
                0 => started_ns,
                _ => 0,
            },
            mode: Mode::INIT,
            tick: 0,
            commanded_position: None,
            record_count: 0,
        }
    }

    pub(super) fn update(&mut self, record: &TickRecord) {
        self.update_clock_start(record.report.stamp.captured_ns);
        self.mode = record.report.mode;
        self.tick = record.report.tick;
        self.commanded_position = record.commanded_position;
        self.record_count += 1;
        if record.phase_locked {
            self.flags |= StatusFlags::PHASE_LOCKED;
        } else {
            self.flags &= !StatusFlags::PHASE_LOCKED;
        }
    }

    /// Start of virtual time; another simulator restarts it.
    fn update_clock_start(&mut self, tick_ns: u64) {
        let is_virtual = self.flags & StatusFlags::LOCKSTEP != 0;
        let is_first = self.record_count == 0 || tick_ns < self.clock_start_ns;
        if is_virtual && is_first {
            self.clock_start_ns = tick_ns;
        }
    }

    /// Sets one parameter: checks it, queues the request, stores it.
    pub(super) fn set_parameter(
        &mut self,
        index: usize,
        value: f64,
        link: &mut SupervisorSide,
    ) -> Result<u64, String> {
        let mut settings = self.config.settings();
        let parameter = &atas_core::settings::PARAMETERS[index];
        settings
            .set(parameter.name, value)
            .map_err(|e| e.to_string())?;
        let config = self.config.with_settings(&settings);
        self.apply(config, OperatorRequest::SetParameter { index, value }, link)
    }

    /// Reloads the configuration: all of it, with the settings in one tick, or nothing. A running
    /// goal keeps its task.
    pub(super) fn reload(&mut self, link: &mut SupervisorSide) -> Result<u64, String> {
        let config = self.source.load().map_err(|e| e.to_string())?;
        let fixed = self.config.fixed_differences(&config);
        if !fixed.is_empty() {
            let keys = fixed.join(", ");
            return Err(format!(
                "could not change {keys} while running: these keys are fixed; restart the daemon"
            ));
        }
        let safety = self.config.safety_differences(&config);
        if !safety.is_empty() && !self.is_stopped() {
            return Err(format!(
                "could not change {}: the mode is {}, but the change needs a stopped robot; run `atas \
                 estop` before and `atas recover` after",
                safety.join(", "),
                self.mode
            ));
        }
        let order = OperatorRequest::Configure(config.settings());
        self.apply(config, order, link)
    }

    /// Returns true if nothing moves without a recovery by a person; only then may safety values
    /// change.
    pub(super) fn is_stopped(&self) -> bool {
        matches!(self.mode, Mode::INIT | Mode::SAFE_STOP)
    }

    fn apply(
        &mut self,
        config: Config,
        order: OperatorRequest,
        link: &mut SupervisorSide,
    ) -> Result<u64, String> {
        config.check().map_err(|e| e.to_string())?;
        let ticket = link
            .request(order)
            .ok_or("the queue of requests is full; try again")?;
        self.config_hash = config.hash();
        self.settings = config.settings();
        self.config = config;
        Ok(ticket)
    }
}
