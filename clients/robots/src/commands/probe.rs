//! `probe`: finds the servos on a port.
//!
//! Tries each family at each of its line speeds until a servo replies. Reads only model numbers.

use std::time::Duration;

use serde_json::json;

use super::{print, print_message};
use crate::cli::Format;
use crate::drivers::wire::Wire;
use crate::drivers::{DRIVERS, Driver};
use crate::failure::Failure;

/// Timeout of a reply. Design choice: more than the latency timer of any USB adapter.
const ANSWER_WITHIN: Duration = Duration::from_millis(30);

/// Servos that reply to one family at one line speed.
struct Finding {
    driver: &'static dyn Driver,
    baud: u32,
    /// Ids and model numbers.
    servos: Vec<(u8, u16)>,
    /// The adapter echoes requests.
    echoes: bool,
}

/// Probes a port and prints the servos.
pub(super) fn run(device: &str, baud: Option<u32>, format: Format) -> Result<(), Failure> {
    let mut found = Vec::new();
    for driver in DRIVERS {
        let bauds = driver.bauds().iter().copied();
        for baud in bauds.filter(|speed| baud.is_none_or(|only| only == *speed)) {
            if format == Format::Text {
                print_message(&format!("probing {} at {baud} baud", driver.name()));
            }
            if let Some(finding) = probe_family(device, driver, baud)? {
                found.push(finding);
                break;
            }
        }
    }
    if format == Format::Json {
        let found = found.iter().map(|finding| {
            let servos = finding.servos.iter().map(|(id, number)| {
                json!({ "id": id, "model": model(finding.driver, *number), "number": number })
            });
            json!({
                "driver": finding.driver.name(),
                "baud": finding.baud,
                "servos": servos.collect::<Vec<_>>(),
                "echoes": finding.echoes,
            })
        });
        let found: Vec<_> = found.collect();
        return print(&json!({ "device": device, "found": found }).to_string());
    }
    if found.is_empty() {
        return print(&format!(
            "{device}: no servo replies; check power and cable"
        ));
    }
    for finding in found {
        let (name, baud) = (finding.driver.name(), finding.baud);
        print(&format!("{device}: {name} at {baud} baud"))?;
        for (id, number) in finding.servos {
            let model = model(finding.driver, number);
            let model = model.map_or(format!("model {number}, unknown"), str::to_owned);
            print(&format!("  id {id:<3}  {model}"))?;
        }
        if finding.echoes {
            print("  the adapter echoes requests; the echo is ignored")?;
        }
    }
    Ok(())
}

fn model(driver: &dyn Driver, number: u16) -> Option<&'static str> {
    let model = driver.models().iter().find(|model| model.number == number);
    model.map(|model| model.name)
}

fn probe_family(
    device: &str,
    driver: &'static dyn Driver,
    baud: u32,
) -> Result<Option<Finding>, Failure> {
    let mut wire =
        Wire::open(device, baud, driver.protocol(), ANSWER_WITHIN).map_err(Failure::Servos)?;
    let ids = wire
        .scan()
        .map_err(|error| Failure::Servos(format!("could not probe {device}: {error}")))?;
    let servos: Vec<(u8, u16)> = ids
        .into_iter()
        .filter_map(|id| Some((id, driver.model_number(&mut wire, id).ok()?)))
        .collect();
    Ok((!servos.is_empty()).then_some(Finding {
        driver,
        baud,
        servos,
        echoes: wire.echoes(),
    }))
}
