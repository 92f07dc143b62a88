//! Thread that receives stop requests ([`shm_bus::stop`]).
//!
//! * **In:** datagrams on the bus's stop socket. **Out:** a signal for the next tick, an answer to
//!   the sender, a log line.
//! * **Invariants:** it shares no memory, queue or lock with ordinary clients. The log line goes
//!   through a bounded queue and never blocks.
//!
//! Recovery is a request on the control service.

use std::io;
use std::sync::Arc;
use std::thread::{Builder, JoinHandle};

use shm_bus::stop::{Listener, ReceivedStop, Signal};

use crate::config::Realtime;
use crate::realtime;

/// Stack of the thread, bytes, locked memory.
const STACK_BYTES: usize = 128 << 10;

/// The thread; it ends on drop.
#[derive(Debug)]
pub(crate) struct StopThread {
    listener: Arc<Listener>,
    thread: Option<JoinHandle<()>>,
}

impl StopThread {
    pub(crate) fn start(listener: Listener, realtime: &Realtime) -> io::Result<Self> {
        let listener = Arc::new(listener);
        let (server, realtime) = (Arc::clone(&listener), realtime.clone());
        let serve = move || {
            realtime::enter_stop_thread(&realtime);
            server.serve(log_stop);
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

    pub(crate) fn signal(&self) -> Arc<Signal> {
        self.listener.signal()
    }
}

impl Drop for StopThread {
    fn drop(&mut self) {
        self.listener.close();
        if let Some(thread) = self.thread.take() {
            // A panic of the thread has been logged.
            let _joined = thread.join();
        }
    }
}

fn log_stop(received: ReceivedStop) {
    let ReceivedStop {
        number,
        pid,
        reason,
        outcome,
    } = received;
    tracing::warn!(number, pid, %reason, %outcome, "stop requested");
}
