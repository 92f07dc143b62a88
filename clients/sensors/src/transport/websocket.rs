//! Text messages of a WebSocket server, by `tungstenite`.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use rustix::io::Errno;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use super::{Input, READ_BYTES, Transport, wait_readable, with_port};

/// Timeout of the connection and of the handshake, each. Design choice: for a server on the same
/// machine or in the same room.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(2);

/// Connection to one server.
#[derive(Debug)]
pub struct Client(WebSocket<TcpStream>);

impl Client {
    /// Connects to `ws://HOST[:PORT]`; `ws://` may be missing.
    ///
    /// # Errors
    /// Cause and remedy as text.
    pub fn open(address: &str, port: u16) -> Result<Self, String> {
        let rest = address.strip_prefix("ws://").unwrap_or(address);
        let (host, path) = rest.split_once('/').unwrap_or((rest, ""));
        let host = with_port(host, port);
        let stream = connect(&host).map_err(|error| {
            format!("{error}; start the sensor's server and give ws://HOST:PORT")
        })?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(READ_BYTES))
            .max_frame_size(Some(READ_BYTES));
        let url = format!("ws://{host}/{path}");
        let (socket, _) = tungstenite::client::client_with_config(url, stream, Some(config))
            .map_err(|error| format!("{error}; not a WebSocket server"))?;
        socket
            .get_ref()
            .set_nonblocking(true)
            .map_err(|error| error.to_string())?;
        Ok(Self(socket))
    }
}

fn connect(host: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "no address found");
    for peer in host.to_socket_addrs()? {
        match TcpStream::connect_timeout(&peer, CONNECT_TIMEOUT) {
            Ok(stream) => {
                stream.set_read_timeout(Some(CONNECT_TIMEOUT))?;
                stream.set_write_timeout(Some(CONNECT_TIMEOUT))?;
                stream.set_nodelay(true)?;
                return Ok(stream);
            }
            Err(error) => last = error,
        }
    }
    Err(last)
}

impl Transport for Client {
    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Input {
        // Messages may already be buffered, so the socket is read before waiting.
        for waited in [false, true] {
            match self.0.read() {
                Ok(Message::Text(text)) => return copy(text.as_bytes(), buffer),
                Ok(Message::Binary(bytes)) => return copy(&bytes, buffer),
                // The library answers pings.
                Ok(_) => return Input::Silence,
                Err(Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(error) => return Input::Gone(io::Error::other(error)),
            }
            if waited {
                break;
            }
            match wait_readable(self.0.get_ref(), timeout) {
                Ok(true) => {}
                Ok(false) | Err(Errno::INTR) => break,
                Err(error) => return Input::Gone(error.into()),
            }
        }
        Input::Silence
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        let text = String::from_utf8_lossy(bytes).into_owned();
        self.0.send(Message::text(text)).map_err(io::Error::other)
    }
}

fn copy(message: &[u8], buffer: &mut [u8]) -> Input {
    match buffer.get_mut(..message.len()) {
        Some(room) if !message.is_empty() => {
            room.copy_from_slice(message);
            Input::Bytes(message.len())
        }
        _ => Input::Silence,
    }
}
