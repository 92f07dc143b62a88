//! Entrance of the Foxglove server: checks the head of each connection, then passes its bytes on.
//!
//! ```text
//!  viewer ─▶ 127.0.0.1:PORT ─ Host, Origin, limits ─▶ 127.x.y.z:random ─▶ the library's server
//! ```
//!
//! The library accepts every `Host` and `Origin`: a page of any site in a browser on this machine
//! could read the robot. The library's address is drawn at random from 2²² addresses.

use std::io;
use std::net::{Ipv4Addr, SocketAddr};

use axum::http::{HeaderMap, HeaderName, HeaderValue};
use tokio::io::{AsyncReadExt, AsyncWriteExt, copy_bidirectional};
use tokio::net::TcpStream;

use crate::connections::{BoundedListener, Connection};
use crate::guard::{Guard, random_bytes};

/// Largest head of a request, bytes. Design choice: several times that of a browser.
const HEAD_MAX: usize = 8 << 10;
const END: &[u8] = b"\r\n\r\n";
const REJECTED: &[u8] = b"HTTP/1.1 403 Forbidden\r\nContent-Length: 0\r\nConnection: close\r\n\r\n";

/// Draws a loopback address of the inner server.
pub(crate) fn inner_address() -> io::Result<Ipv4Addr> {
    let [a, b, c] = random_bytes()?;
    Ok(Ipv4Addr::new(127, 64 | a & 63, b, c.clamp(1, 254)))
}

/// Serves viewers for ever.
pub(crate) async fn serve(listener: BoundedListener, guard: Guard, inner: SocketAddr) {
    loop {
        let (viewer, _) = listener.next().await;
        let guard = guard.clone();
        // A failure ends this connection only.
        tokio::spawn(async move { pass(viewer, &guard, inner).await });
    }
}

async fn pass(mut viewer: Connection, guard: &Guard, inner: SocketAddr) -> io::Result<()> {
    let head = read_head(&mut viewer).await?;
    if !headers(&head).is_some_and(|headers| guard.admits_viewer(&headers)) {
        viewer.write_all(REJECTED).await?;
        return viewer.shutdown().await;
    }
    // Without a daemon there are no messages.
    viewer.permit_idleness();
    let mut server = TcpStream::connect(inner).await?;
    server.write_all(&head).await?;
    copy_bidirectional(&mut viewer, &mut server).await?;
    Ok(())
}

/// Reads up to the end of the head; may read further bytes.
async fn read_head(viewer: &mut Connection) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    while !head.windows(END.len()).any(|bytes| bytes == END) {
        if head.len() > HEAD_MAX || viewer.read_buf(&mut head).await? == 0 {
            return Err(io::ErrorKind::InvalidData.into());
        }
    }
    Ok(head)
}

/// Returns the headers of a request; `None` if one is not a header.
pub(crate) fn headers(head: &[u8]) -> Option<HeaderMap> {
    let text = std::str::from_utf8(head).ok()?;
    let (head, _) = text.split_once("\r\n\r\n")?;
    let mut headers = HeaderMap::new();
    for line in head.split("\r\n").skip(1) {
        let (name, value) = line.split_once(':')?;
        let name: HeaderName = name.parse().ok()?;
        let value: HeaderValue = value.trim().parse().ok()?;
        // A second host or origin could hide the first.
        if headers.append(&name, value) && (name == "host" || name == "origin") {
            return None;
        }
    }
    Some(headers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heads_are_parsed_strictly() {
        let parsed = |text: &str| headers(text.as_bytes());
        let one =
            parsed("GET / HTTP/1.1\r\nHost: localhost:1\r\nOrigin: x\r\n\r\nrest").expect("a head");
        assert_eq!(
            (&one["host"], &one["origin"]),
            (&"localhost:1".parse().unwrap(), &"x".parse().unwrap())
        );
        for wrong in [
            "GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n",
            "GET / HTTP/1.1\r\nHost: a\r\norigin: a\r\nOrigin: b\r\n\r\n",
            "GET / HTTP/1.1\r\nno header\r\n\r\n",
            "GET / HTTP/1.1\r\nHost : a\r\n\r\n",
            "GET / HTTP/1.1\r\n",
        ] {
            assert_eq!(parsed(wrong), None, "{wrong}");
        }
    }
}
