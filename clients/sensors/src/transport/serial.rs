//! Serial device as a byte stream: opened, locked, read with a timeout, written if it accepts data.
//!
//! A terminal (serial port, USB adapter, pseudo-terminal) is set to raw mode and locked, so that no
//! second process reads its bytes. A FIFO is a stream without configuration, a regular file a
//! recording to decode. Bytes that the kernel buffered before opening are kept: a decoder
//! resynchronises, and a discarded acknowledgement would be missed.

use std::fs::File;
use std::io;
use std::os::fd::{AsFd, BorrowedFd};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

use rustix::fs::FlockOperation;
use rustix::io::Errno;
use serial2::{CharSize, FlowControl, Parity, SerialPort, Settings, StopBits};

use super::{Input, Transport, wait_readable};

/// Timeout of a write: nine bytes take 0.1 ms at 1 MBd, so a longer write means that the device
/// does not read. Design choice.
const WRITE_TIMEOUT: Duration = Duration::from_millis(200);

/// Open device.
#[derive(Debug)]
pub struct Device(Source);

#[derive(Debug)]
enum Source {
    Terminal(SerialPort),
    Fifo(File),
    Recording(File),
}

impl Device {
    /// Opens a terminal, a FIFO or a regular file.
    ///
    /// # Errors
    /// Cause and remedy as text.
    pub fn open(path: &Path, baud: u32) -> Result<Self, String> {
        let kind = std::fs::metadata(path)
            .map_err(|error| remedy(&error))?
            .file_type();
        let source = if kind.is_char_device() {
            open_terminal(path, baud).map(Source::Terminal)
        } else if kind.is_fifo() {
            open_stream(path).map(Source::Fifo)
        } else if kind.is_file() {
            open_stream(path).map(Source::Recording)
        } else {
            return Err(
                "not a terminal, FIFO or regular file; give the path of a serial port".to_owned(),
            );
        };
        let device = Self(source.map_err(|error| remedy(&error))?);
        device.lock()?;
        Ok(device)
    }

    /// Two readers of a device would each receive a part of the bytes.
    fn lock(&self) -> Result<(), String> {
        if self.is_recording() {
            return Ok(());
        }
        rustix::fs::flock(self, FlockOperation::NonBlockingLockExclusive)
            .map_err(|_| "another process uses it; stop that process (`fuser` names it)".to_owned())
    }
}

impl Transport for Device {
    fn accepts_messages(&self) -> bool {
        matches!(self.0, Source::Terminal(_))
    }

    fn is_recording(&self) -> bool {
        matches!(self.0, Source::Recording(_))
    }

    fn read(&mut self, buffer: &mut [u8], timeout: Duration) -> Input {
        // Size of the kernel's terminal buffer.
        let room = buffer.len().min(4096);
        let buffer = &mut buffer[..room];
        let outcome = match wait_readable(self, timeout) {
            Ok(false) => return Input::Silence,
            Ok(true) => rustix::io::read(self.as_fd(), buffer),
            Err(error) => Err(error),
        };
        match outcome {
            Ok(0) if self.is_recording() => Input::End,
            Ok(0) => Input::Gone(io::Error::new(
                io::ErrorKind::UnexpectedEof,
                "the stream ended",
            )),
            Ok(length) => Input::Bytes(length),
            Err(Errno::INTR | Errno::AGAIN) => Input::Silence,
            Err(error) => Input::Gone(error.into()),
        }
    }

    fn write(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let Source::Terminal(port) = &self.0 else {
            return Err(io::Error::new(
                io::ErrorKind::Unsupported,
                "only a terminal can be written to",
            ));
        };
        while !bytes.is_empty() {
            match port.write(bytes) {
                Ok(written) => bytes = &bytes[written..],
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

impl AsFd for Device {
    fn as_fd(&self) -> BorrowedFd<'_> {
        match &self.0 {
            Source::Terminal(port) => port.as_fd(),
            Source::Fifo(file) | Source::Recording(file) => file.as_fd(),
        }
    }
}

fn open_terminal(path: &Path, baud: u32) -> io::Result<SerialPort> {
    let mut port = SerialPort::open(path, |mut settings: Settings| {
        settings.set_raw();
        settings.set_baud_rate(baud)?;
        settings.set_char_size(CharSize::Bits8);
        settings.set_parity(Parity::None);
        settings.set_stop_bits(StopBits::One);
        settings.set_flow_control(FlowControl::None);
        Ok(settings)
    })?;
    port.set_write_timeout(WRITE_TIMEOUT)?;
    Ok(port)
}

fn open_stream(path: &Path) -> io::Result<File> {
    // Non-blocking: opening a FIFO would otherwise wait for its writer and ignore signals.
    std::fs::OpenOptions::new()
        .read(true)
        .custom_flags(rustix::fs::OFlags::NONBLOCK.bits().cast_signed())
        .open(path)
}

/// Returns the remedy for an error on opening.
fn remedy(error: &io::Error) -> String {
    let advice = match error.kind() {
        io::ErrorKind::NotFound => {
            "check the path and that the device is plugged in (ls /dev/serial/by-id)"
        }
        io::ErrorKind::PermissionDenied => "add the user to the group that owns it (often dialout)",
        _ if error.raw_os_error() == Some(Errno::NOTTY.raw_os_error()) => {
            "not a terminal; give a serial port"
        }
        _ => "check the device and its cable",
    };
    format!("{error}; {advice}")
}
