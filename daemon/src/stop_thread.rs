//! The thread that receives stops and does nothing else ([`shm_bus::stop`]).
//!
//! * **In:** datagrams on the bus's stop socket. **Out:** a signal that the next tick takes, an answer to who asked, a line
//!   in the log.
//! * **Invariants:** it shares nothing with ordinary clients: no shared memory, no queue, no lock. Its log line goes through
//!   the bounded queue of the log and cannot hold it up.
//! * **Absent on purpose:** recovering. That is asked for on the control service.

use std::io;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use shm_bus::stop::{Heard, Listener, Signal};

use crate::config::Realtime;
use crate::realtime;

/// Stack of the thread, bytes: it is locked memory.
const STACK_BYTES: usize = 128 << 10;

/// The thread; ends when this is dropped.
#[derive(Debug)]
pub(crate) struct StopThread {
    listener: Arc<Listener>,
    thread: Option<JoinHandle<()>>,
}

impl StopThread {
    /// Begins to listen.
    pub(crate) fn start(listener: Listener, realtime: &Realtime) -> io::Result<Self> {
        let listener = Arc::new(listener);
        let (server, realtime) = (Arc::clone(&listener), realtime.clone());
        let serve = move || {
            realtime::enter_below_the_tick(&realtime);
            server.serve(tell);
        };
        let thread = Builder::new()
            .name("atasd-stop".to_owned())
            .stack_size(STACK_BYTES)
            .spawn(serve)?;
        Ok(Self {
            listener,
            thread: Some(thread),
        })
    }

    /// What the tick looks at.
    pub(crate) fn signal(&self) -> Arc<Signal> {
        self.listener.signal()
    }
}

impl Drop for StopThread {
    fn drop(&mut self) {
        self.listener.close();
        if let Some(thread) = self.thread.take() {
            // A panic there has been logged.
            let _joined = thread.join();
        }
    }
}

fn tell(heard: Heard) {
    let Heard {
        number,
        pid,
        reason,
        outcome,
    } = heard;
    tracing::warn!(number, pid, %reason, %outcome, "asked to stop at once");
}
