//! Checks of processor frequency, idle states and power mode.

use std::collections::BTreeMap;
use std::io;

use crate::doctor::finding::Finding;

/// Probe of the frequency governors.
pub(in crate::doctor) const GOVERNOR: &str = "frequency governor";
/// Platform profiles that limit the power of the processor.
const SLOW_PROFILES: [&str; 3] = ["low-power", "quiet", "cool"];
/// Energy preferences of the processor that prefer low power.
const SLOW_PREFERENCES: [&str; 2] = ["power", "balance_power"];

/// Settings that limit the power of the processor.
#[derive(Clone, Debug, Default)]
pub(in crate::doctor) struct PowerMode {
    /// `/sys/firmware/acpi/platform_profile`.
    pub(in crate::doctor) profile: String,
    /// `energy_performance_preference` of all cores.
    pub(in crate::doctor) preferences: Vec<String>,
    /// A battery supplies the computer.
    pub(in crate::doctor) is_on_battery: bool,
}

/// Checks the power mode.
pub(in crate::doctor) fn power_mode(mode: &PowerMode) -> Finding {
    const PROBE: &str = "power mode";
    const COST: &str = "the processor lowers its frequency under load: ticks take longer";
    let profile = mode.profile.trim();
    let mut preferences = mode.preferences.iter().map(|text| text.trim());
    let slow = preferences.find(|preference| SLOW_PREFERENCES.contains(preference));
    if SLOW_PROFILES.contains(&profile) {
        Finding::warn(
            PROBE,
            format!("platform profile {profile}"),
            "run `echo performance | sudo tee /sys/firmware/acpi/platform_profile`, or \
             `powerprofilesctl set performance`",
            COST,
        )
    } else if let Some(slow) = slow {
        Finding::warn(
            PROBE,
            format!("energy preference {slow}"),
            "run `echo performance | sudo tee \
             /sys/devices/system/cpu/cpu*/cpufreq/energy_performance_preference`",
            COST,
        )
    } else if mode.is_on_battery {
        Finding::warn(
            PROBE,
            "the computer runs on battery",
            "connect the power supply",
            "the firmware can limit the frequency, and the computer can switch off during a goal",
        )
    } else if profile.is_empty() {
        Finding::ok(PROBE, "no limit known to this kernel")
    } else {
        Finding::ok(PROBE, format!("platform profile {profile}"))
    }
}

/// Checks the frequency governors of all cores.
pub(in crate::doctor) fn governor(governors: &[String]) -> Finding {
    let mut cores = BTreeMap::<&str, usize>::new();
    for governor in governors {
        *cores.entry(governor.trim()).or_default() += 1;
    }
    let found: Vec<String> = cores
        .iter()
        .map(|(name, count)| {
            format!(
                "{name} ({count} core{})",
                if *count == 1 { "" } else { "s" }
            )
        })
        .collect();
    if cores.is_empty() {
        Finding::ok(GOVERNOR, "none: this kernel does not control the frequency")
    } else if cores.keys().all(|name| *name == "performance") {
        Finding::ok(GOVERNOR, found.join(", "))
    } else {
        let cure =
            "run `sudo cpupower frequency-set -g performance`, or `atas doctor --fix` as root";
        Finding::warn(
            GOVERNOR,
            format!("{}: cores slow down between ticks", found.join(", ")),
            cure,
            "the first work after a sleep runs slower: ticks take longer and vary more",
        )
    }
}

/// Checks whether cores can be kept out of deep idle states: idle driver, and result of opening
/// `/dev/cpu_dma_latency`.
pub(in crate::doctor) fn idle_states(driver: &str, opened: &io::Result<()>) -> Finding {
    const PROBE: &str = "idle states";
    match (driver.trim(), opened) {
        ("" | "none", _) => Finding::ok(PROBE, "none controlled by this kernel"),
        (driver, Ok(())) => Finding::ok(
            PROBE,
            format!("{driver}; the daemon can keep the cores awake"),
        ),
        (driver, Err(error)) => Finding::warn(
            PROBE,
            format!(
                "{driver}; could not open /dev/cpu_dma_latency ({error}): ticks wake up tens of µs \
                 later"
            ),
            "install daemon/systemd/60-atas.rules, which permits this to the group atas, and join \
             the group",
            "every tick starts tens of µs late, with more jitter",
        ),
    }
}
