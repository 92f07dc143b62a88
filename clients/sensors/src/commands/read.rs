//! Reads the devices of a plan until they end or a signal comes.
//!
//! One device is read on this thread. Several have a thread each, because a device that connects slowly must not hold
//! up the others, and this thread publishes what they bring.

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

/// Batches that may wait for the publisher. Ours: a second of the fastest device would be more than any pause.
const WAITING: usize = 1024;

/// Reads.
pub(super) fn run(plan: Plan) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let seats = plan.seats();
    let Some(place) = plan.place else {
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

/// What a port's thread hands over.
enum Parcel {
    Readings(usize, Batch),
    Health(usize, Health),
}

/// The output of one of several ports.
struct Sender {
    port: usize,
    to: SyncSender<Parcel>,
}

impl Sender {
    /// A publisher that is gone stops all ports itself; until then their parcels are worth nothing.
    fn send(&self, parcel: Parcel) {
        let _ = self.to.send(parcel);
    }
}

impl Output for Sender {
    fn readings(&mut self, batch: &Batch) -> Result<(), Failure> {
        if !batch.is_empty() {
            self.send(Parcel::Readings(self.port, batch.clone()));
        }
        Ok(())
    }

    fn health(&mut self, health: &Health) -> Result<(), Failure> {
        self.send(Parcel::Health(self.port, *health));
        Ok(())
    }
}

/// Reads several devices. The first failure ends all.
fn read_all(ports: Vec<Port>, output: &mut HandOutput, stop: &AtomicBool) -> Result<(), Failure> {
    let (to, from) = sync_channel(WAITING);
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
                    // One finger less is another hand: the others end too.
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

/// Publishes until all ports have ended.
fn publish(from: &Receiver<Parcel>, output: &mut HandOutput) -> Result<(), Failure> {
    for parcel in from {
        match parcel {
            Parcel::Readings(port, batch) => output.readings(port, &batch)?,
            Parcel::Health(port, health) => output.health(port, &health)?,
        }
    }
    Ok(())
}
