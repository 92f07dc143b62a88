//! Reads a plan's devices until they end or a signal arrives.
//!
//! One device is read on this thread. Several have a thread each, because a slow connection must
//! not delay the others; this thread publishes.

use std::io::{self, Write};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use super::stop_on_signal;
use crate::failure::Failure;
use crate::hand::HandOutput;
use crate::plan::{Plan, Port};
use crate::port;
use crate::reading::{Batch, Health, Output};
use crate::table::Table;

/// Queued batches. Design choice: a second of the fastest device exceeds any pause.
const QUEUE_BATCHES: usize = 1024;

pub(super) fn run(plan: Plan) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let seats = plan.slots();
    let Some(place) = plan.destination else {
        return plan
            .ports
            .into_iter()
            .try_for_each(|port| print_table(port, &stop));
    };
    let mut output = HandOutput::open(&place, seats)?;
    let mut ports = plan.ports;
    match (ports.pop(), ports.is_empty()) {
        (Some(port), true) => read(port, &mut output, &stop),
        (last, _) => {
            ports.extend(last);
            read_all(ports, &mut output, &stop)
        }
    }
}

fn print_table(port: Port, stop: &AtomicBool) -> Result<(), Failure> {
    let mut table = Table::new(io::stdout(), port.shape(), port.newtons.clone())?;
    read(port, &mut table, stop)
}

fn read(port: Port, output: &mut dyn Output, stop: &AtomicBool) -> Result<(), Failure> {
    let Port {
        sensor,
        settings,
        driver,
        ..
    } = port;
    let (health, outcome) = port::run(&settings, driver, output, shm_bus::now_ns, stop);
    let _ = writeln!(
        io::stderr(),
        "{} {}: {health}",
        sensor.name,
        settings.device
    );
    outcome
}

/// Message of a port thread.
enum PortMessage {
    Readings(usize, Batch),
    Health(usize, Health),
}

struct Sender {
    port: usize,
    to: SyncSender<PortMessage>,
}

impl Sender {
    /// Ignores a closed queue; the publisher then stops all ports.
    fn send(&self, parcel: PortMessage) {
        let _ = self.to.send(parcel);
    }
}

impl Output for Sender {
    fn readings(&mut self, batch: &Batch) -> Result<(), Failure> {
        if !batch.is_empty() {
            self.send(PortMessage::Readings(self.port, batch.clone()));
        }
        Ok(())
    }

    fn health(&mut self, health: &Health) -> Result<(), Failure> {
        self.send(PortMessage::Health(self.port, *health));
        Ok(())
    }
}

/// Reads several devices. The first failure stops all.
fn read_all(ports: Vec<Port>, output: &mut HandOutput, stop: &AtomicBool) -> Result<(), Failure> {
    let (to, from) = sync_channel(QUEUE_BATCHES);
    thread::scope(|scope| {
        let threads: Vec<_> = ports
            .into_iter()
            .enumerate()
            .map(|(n, port)| {
                let mut sender = Sender {
                    port: n,
                    to: to.clone(),
                };
                scope.spawn(move || {
                    let outcome = read(port, &mut sender, stop);
                    // A hand must be complete, so all ports stop.
                    stop.store(true, Ordering::Relaxed);
                    outcome
                })
            })
            .collect();
        drop(to);
        let published = publish(&from, output);
        stop.store(true, Ordering::Relaxed);
        drop(from);
        let panicked = || Failure::Usage("a port's thread panicked".to_owned());
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap_or_else(|_| Err(panicked())))
            .fold(published, Result::and)
    })
}

fn publish(from: &Receiver<PortMessage>, output: &mut HandOutput) -> Result<(), Failure> {
    for parcel in from {
        match parcel {
            PortMessage::Readings(port, batch) => output.readings(port, &batch)?,
            PortMessage::Health(port, health) => output.health(port, &health)?,
        }
    }
    Ok(())
}
