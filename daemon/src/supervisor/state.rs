//! What the supervisor knows, and how the configuration changes while the daemon runs.

use atas_core::{Order, Settings, Wiring};
use robot_model::{RobotModel, RobotVector};
use shm_schemas::{Mode, StatusFlags};

use crate::config::{Config, Source};
use crate::link::{SupervisorEnd, TickRecord};

/// What the parts of the supervisor share.
#[derive(Debug)]
pub struct SupervisorState {
    /// Where the configuration came from.
    pub source: Source,
    /// The configuration in force, settings included.
    pub config: Config,
    /// Its hash.
    pub config_hash: u64,
    /// The robot.
    pub robot: RobotModel,
    /// What the controller is wired to.
    pub wiring: Wiring,
    /// [`shm_schemas::StatusFlags`].
    pub flags: u32,
    /// When the daemon started, ns.
    pub started_ns: u64,
    /// The same on the clock that stamps the ticks: virtual time begins with its first tick, and is 0 before.
    pub stamps_from_ns: u64,
    /// Mode after the last tick.
    pub mode: Mode,
    /// Index of the last tick.
    pub tick: u64,
    /// Positions that the last tick commanded, rad, if it commanded any.
    pub commanded_rad: Option<RobotVector>,
    /// The settings of `config`.
    pub settings: Settings,
    /// Ticks whose records have been seen.
    pub ticks_seen: u64,
}

impl SupervisorState {
    /// What is known before the first tick.
    #[must_use]
    pub fn new(
        source: Source,
        config: Config,
        robot: RobotModel,
        wiring: Wiring,
        flags: u32,
    ) -> Self {
        let started_ns = shm_bus::now_ns();
        Self {
            config_hash: config.hash(),
            settings: config.settings(),
            source,
            config,
            robot,
            wiring,
            flags,
            started_ns,
            stamps_from_ns: match flags & StatusFlags::LOCKSTEP {
                0 => started_ns,
                _ => 0,
            },
            mode: Mode::INIT,
            tick: 0,
            commanded_rad: None,
            ticks_seen: 0,
        }
    }

    /// Learns from a tick.
    pub(super) fn learn(&mut self, record: &TickRecord) {
        self.learn_clock(record.report.stamp.captured_ns);
        self.mode = record.report.mode;
        self.tick = record.report.tick;
        self.commanded_rad = record.commanded_rad;
        self.ticks_seen += 1;
        if record.phase_locked {
            self.flags |= StatusFlags::PHASE_LOCKED;
        } else {
            self.flags &= !StatusFlags::PHASE_LOCKED;
        }
    }

    /// Where virtual time began. Another simulator begins it anew.
    fn learn_clock(&mut self, tick_ns: u64) {
        let is_virtual = self.flags & StatusFlags::LOCKSTEP != 0;
        let is_first = self.ticks_seen == 0 || tick_ns < self.stamps_from_ns;
        if is_virtual && is_first {
            self.stamps_from_ns = tick_ns;
        }
    }

    /// Changes one parameter: checks it, queues the order, remembers it.
    pub(super) fn set_parameter(
        &mut self,
        index: usize,
        value: f64,
        link: &mut SupervisorEnd,
    ) -> Result<u64, String> {
        let mut settings = self.config.settings();
        let parameter = &atas_core::settings::PARAMETERS[index];
        settings
            .set(parameter.name, value)
            .map_err(|e| e.to_string())?;
        let config = self.config.with_settings(&settings);
        self.adopt(config, Order::SetParameter { index, value }, link)
    }

    /// Reads the configuration again. Either everything changes, the settings in one tick, or nothing does. A goal that was
    /// taken keeps its task.
    pub(super) fn reload(&mut self, link: &mut SupervisorEnd) -> Result<u64, String> {
        let config = self.source.load().map_err(|e| e.to_string())?;
        let fixed = self.config.fixed_differences(&config);
        if !fixed.is_empty() {
            let keys = fixed.join(", ");
            return Err(format!(
                "could not change {keys} while running; restart the daemon for that"
            ));
        }
        let safety = self.config.safety_differences(&config);
        if !safety.is_empty() && !self.is_stopped() {
            return Err(format!(
                "could not change {} because the mode was {}, needs a stopped robot; `atas estop` first, `atas recover` after",
                safety.join(", "),
                self.mode
            ));
        }
        let order = Order::Configure(config.settings());
        self.adopt(config, order, link)
    }

    /// Whether nothing moves before a person says so: only then what keeps the robot safe may change.
    pub(super) fn is_stopped(&self) -> bool {
        matches!(self.mode, Mode::INIT | Mode::SAFE_STOP)
    }

    fn adopt(
        &mut self,
        config: Config,
        order: Order,
        link: &mut SupervisorEnd,
    ) -> Result<u64, String> {
        config.check().map_err(|e| e.to_string())?;
        let ticket = link
            .order(order)
            .ok_or("the queue of orders is full; try again")?;
        self.config_hash = config.hash();
        self.settings = config.settings();
        self.config = config;
        Ok(ticket)
    }
}
