//! Text messages of a WebSocket server, by `tungstenite`.

use std::io;
use std::net::{TcpStream, ToSocketAddrs};
use std::time::Duration;

use rustix::io::Errno;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use super::{Input, READ_BYTES, Transport, wait_readable, with_port};

/// How long connecting and the first handshake may take each. Ours: a server on the same machine or in the same room.
const PATIENCE: Duration = Duration::from_secs(2);

/// A connection to one server.
#[derive(Debug)]
pub struct Client(WebSocket<TcpStream>);

impl Client {
    /// Connects to `ws://HOST[:PORT]`, or the same without `ws://`.
    ///
    /// # Errors
    /// A sentence that says what is wrong and what to do.
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
            .map_err(|error| format!("{error}; it is no WebSocket server"))?;
        socket
            .get_ref()
            .set_nonblocking(true)
            .map_err(|error| error.to_string())?;
        Ok(Self(socket))
    }
}

fn connect(host: &str) -> io::Result<TcpStream> {
    let mut last = io::Error::new(io::ErrorKind::NotFound, "it has no address");
    for peer in host.to_socket_addrs()? {
        match TcpStream::connect_timeout(&peer, PATIENCE) {
            Ok(stream) => {
                stream.set_read_timeout(Some(PATIENCE))?;
                stream.set_write_timeout(Some(PATIENCE))?;
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
        // Messages may already be here, so the socket is asked before it is waited for.
        for waited in [false, true] {
            match self.0.read() {
                Ok(Message::Text(text)) => return copy(text.as_bytes(), buffer),
                Ok(Message::Binary(bytes)) => return copy(&bytes, buffer),
                // Pings are answered by the library.
                Ok(_) => return Input::Quiet,
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
        Input::Quiet
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
        _ => Input::Quiet,
    }
}
