//! Foreign bytes of the servers without sockets: requests of a page, heads of viewers, target
//! files.
//!
//! The fuzz targets use this module. It serves the code of the real servers.

use std::future::{IntoFuture, pending, poll_fn};
use std::io;
use std::pin::Pin;
use std::task::Poll;
use std::time::Duration;

use anyhow::Context as _;
use axum::Router;
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, DuplexStream, ReadBuf, duplex};
use tokio::runtime::Runtime;
use tokio::time::timeout;

use crate::entrance;
use crate::guard::Guard;
use crate::server::{runtime, unconnected_router};
use crate::teleop;

/// Port that requests must name as their host.
pub const PORT: u16 = 8470;
/// Most bytes in flight in each direction. Design choice: as a socket.
const BUFFER_BYTES: usize = 64 << 10;
/// Rounds of the event loop without a byte after which the server waits for the viewer. Design
/// choice: several times those of an answer.
const QUIET_ROUNDS: u32 = 32;
/// Longest life of a connection after its last byte.
const END_TIMEOUT: Duration = Duration::from_secs(2);

/// Server of the dashboard without a socket and without a daemon.
#[derive(Debug)]
pub struct Dashboard {
    runtime: Runtime,
    router: Router,
}

impl Dashboard {
    /// Creates the server.
    ///
    /// # Errors
    /// No random bytes or no event queue of the operating system.
    pub fn new() -> anyhow::Result<Self> {
        Ok(Self {
            runtime: runtime()?,
            router: unconnected_router(PORT)?,
        })
    }

    /// Serves the bytes of one connection that then closes; returns all bytes of the answers.
    ///
    /// # Errors
    /// The server does not close the connection.
    pub fn answer(&self, connection: &[u8]) -> anyhow::Result<Vec<u8>> {
        self.runtime.block_on(async {
            let (mut viewer, server) = duplex(BUFFER_BYTES);
            let served = axum::serve(OneConnection(Some(server)), self.router.clone());
            let served = tokio::spawn(served.into_future());
            let mut answer = Vec::new();
            let exchange = async {
                // The server may close early: that is an answer too.
                let _sent = viewer.write_all(connection).await;
                read_until_quiet(&mut viewer, &mut answer).await;
                // The server drops the requests of a viewer that closes earlier.
                let _closed = viewer.shutdown().await;
                viewer.read_to_end(&mut answer).await
            };
            let ended = timeout(END_TIMEOUT, exchange).await;
            served.abort();
            let _aborted = served.await;
            ended.context("the connection stays open")??;
            Ok(answer)
        })
    }
}

/// Reads until the server has nothing more to do.
async fn read_until_quiet(viewer: &mut DuplexStream, answer: &mut Vec<u8>) {
    let mut buffer = [0; 4096];
    let mut quiet = 0;
    while quiet < QUIET_ROUNDS {
        let polled = poll_fn(|context| {
            let mut buffer = ReadBuf::new(&mut buffer);
            let read = Pin::new(&mut *viewer).poll_read(context, &mut buffer);
            Poll::Ready(read.map_ok(|()| buffer.filled().len()))
        });
        match polled.await {
            Poll::Ready(Ok(count @ 1..)) => {
                answer.extend_from_slice(&buffer[..count]);
                quiet = 0;
            }
            Poll::Ready(_) => return,
            Poll::Pending => {
                quiet += 1;
                tokio::task::yield_now().await;
            }
        }
    }
}

/// Listener with a single connection.
struct OneConnection(Option<DuplexStream>);

impl axum::serve::Listener for OneConnection {
    type Io = DuplexStream;
    type Addr = ();

    async fn accept(&mut self) -> (DuplexStream, ()) {
        match self.0.take() {
            Some(connection) => (connection, ()),
            None => pending().await,
        }
    }

    fn local_addr(&self) -> io::Result<()> {
        Ok(())
    }
}

/// Returns true if the entrance of the Foxglove server on [`PORT`] admits a viewer with this head.
///
/// # Errors
/// No random bytes.
pub fn is_admitted(head: &[u8]) -> io::Result<bool> {
    let guard = Guard::new(PORT)?;
    Ok(entrance::headers(head).is_some_and(|headers| guard.admits_viewer(&headers)))
}

/// Returns the number of teleoperation targets in the text of a file.
///
/// # Errors
/// All findings with their lines.
pub fn count_targets(text: &str) -> Result<usize, Vec<String>> {
    teleop::count_targets(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connection_is_answered_without_a_socket() {
        let dashboard = Dashboard::new().expect("a server");
        let check = |request: &str, status: &str| {
            let answer = dashboard.answer(request.as_bytes()).expect("an answer");
            let answer = String::from_utf8_lossy(&answer).into_owned();
            assert!(answer.starts_with(status), "{request:?}: {answer:?}");
        };
        let ours = "Host: 127.0.0.1:8470";
        check(
            &format!("GET /scene.json HTTP/1.1\r\n{ours}\r\n\r\n"),
            "HTTP/1.1 200",
        );
        check(
            &format!("POST /stop HTTP/1.1\r\n{ours}\r\n\r\n"),
            "HTTP/1.1 403",
        );
        check(
            "GET / HTTP/1.1\r\nHost: other.example\r\n\r\n",
            "HTTP/1.1 403",
        );
        check("", "");
        assert!(!is_admitted(b"").expect("random bytes"));
        assert!(count_targets("").is_err());
    }
}
