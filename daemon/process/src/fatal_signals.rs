//! Fatal signals: the handler writes the cause of the end before it ends the process.
//!
//! ```text
//!  SIGSEGV, SIGBUS, SIGXCPU, … ─▶ one line in a record and on standard error ─▶ usual end
//! ```
//!
//! * **Invariants:** the handler only calls functions that are safe in a signal handler, and does
//!   not write to a full pipe. Core dumps and the message about an overflowed stack stay as without
//!   it. Ignored signals stay ignored.
//! * **Not included:** `SIGKILL`, which no process receives.

use std::ffi::c_int;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::{IntoRawFd, OwnedFd, RawFd};
use std::sync::atomic::{AtomicBool, AtomicI32, Ordering};
use std::sync::{Arc, OnceLock};

/// Text about a signal: if the kernel or the program caused it, and if another process sent it.
struct Cause {
    signal: c_int,
    fault: &'static str,
    sent: &'static str,
}

macro_rules! cause {
    ($signal:ident, $fault:literal) => {
        Cause {
            signal: libc::$signal,
            fault: concat!("ended by ", stringify!($signal), ": ", $fault),
            sent: concat!(
                "ended by ",
                stringify!($signal),
                ", which another process sent"
            ),
        }
    };
}

const CAUSES: [Cause; 10] = [
    cause!(SIGABRT, "the program found a fault in itself"),
    cause!(
        SIGBUS,
        "a file in use was truncated, or memory is full or broken"
    ),
    cause!(SIGFPE, "a fault in the program"),
    cause!(SIGILL, "a fault in the program, or a wrong processor"),
    cause!(SIGQUIT, "the terminal requested it"),
    cause!(SIGSEGV, "a fault in the program"),
    cause!(SIGSYS, "a system call is forbidden here"),
    cause!(SIGTRAP, "a fault in the program"),
    cause!(
        SIGXCPU,
        "a thread computed longer than RLIMIT_RTTIME or RLIMIT_CPU allows"
    ),
    cause!(SIGXFSZ, "a file exceeded RLIMIT_FSIZE"),
];
/// Cause of an end by the second SIGINT or SIGTERM.
const SECOND_SIGNAL: &str = "ended at once, as a second signal requested";

/// Handlers before [`install`], in the order of [`CAUSES`].
static BEFORE: OnceLock<[libc::sigaction; CAUSES.len()]> = OnceLock::new();
/// File of the record; negative for none.
static RECORD: AtomicI32 = AtomicI32::new(-1);
/// True if standard error has one JSON object per line.
static IS_JSON: AtomicBool = AtomicBool::new(false);

/// Installs the handlers, once per process.
///
/// # Errors
/// [`io::Error`] if the kernel refuses a handler.
pub fn install(json: bool) -> io::Result<()> {
    IS_JSON.store(json, Ordering::Relaxed);
    let mut before = [MaybeUninit::<libc::sigaction>::uninit(); CAUSES.len()];
    for (cause, before) in CAUSES.iter().zip(&mut before) {
        // SAFETY: the call writes the present handler of this signal to `before`.
        check(unsafe { libc::sigaction(cause.signal, std::ptr::null(), before.as_mut_ptr()) })?;
    }
    // SAFETY: the loop has initialised all elements.
    let before = before.map(|before| unsafe { before.assume_init() });
    let is_first = BEFORE.set(before).is_ok();
    for (cause, before) in CAUSES.iter().zip(before) {
        // A parent may have set signals to be ignored.
        if !is_first || before.sa_sigaction == libc::SIG_IGN {
            continue;
        }
        // SAFETY: zero is a valid value of all fields; `handle` is safe in a signal handler and has
        // the signature that SA_SIGINFO requires.
        check(unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = handle as *const () as usize;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(cause.signal, &raw const action, std::ptr::null_mut())
        })?;
    }
    Ok(())
}

/// Also appends the cause to this file, which stays open until the process ends.
pub fn record_to(file: OwnedFd) {
    RECORD.store(file.into_raw_fd(), Ordering::Release);
}

/// Writes the cause of an end by a second signal: one that arrives while `stops` is set. Call it
/// before the handler that ends the process is registered.
///
/// # Errors
/// [`io::Error`] if the kernel does not install the handler.
pub fn report_second(signal: c_int, stops: Arc<AtomicBool>) -> io::Result<()> {
    let action = move || {
        if stops.load(Ordering::Relaxed) {
            report(SECOND_SIGNAL);
        }
    };
    // SAFETY: the action is safe in a signal handler.
    unsafe { signal_hook::low_level::register(signal, action) }.map(|_| ())
}

fn check(result: c_int) -> io::Result<()> {
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

/// Writes the cause. A fault of this thread goes to the former handler, which knows overflowed
/// stacks; another signal ends the process.
extern "C" fn handle(signal: c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    let known = CAUSES.iter().position(|cause| cause.signal == signal);
    let Some((index, before)) = known.zip(BEFORE.get()) else {
        return;
    };
    // SAFETY: `before` was a handler of this signal, zero is the usual action, and the kernel
    // passes a valid `info`.
    unsafe {
        let is_sent = (*info).si_code <= 0;
        let is_foreign = is_sent && (*info).si_pid() != libc::getpid();
        let cause = &CAUSES[index];
        report(if is_foreign { cause.sent } else { cause.fault });
        let faults = [
            libc::SIGBUS,
            libc::SIGFPE,
            libc::SIGILL,
            libc::SIGSEGV,
            libc::SIGTRAP,
        ];
        if is_sent || !faults.contains(&signal) {
            let usual: libc::sigaction = std::mem::zeroed();
            libc::sigaction(signal, &raw const usual, std::ptr::null_mut());
            // Waits until this handler returns.
            libc::raise(signal);
        } else {
            // The faulty instruction repeats.
            libc::sigaction(signal, &raw const before[index], std::ptr::null_mut());
        }
    }
}

/// Writes a cause to the record and to standard error.
fn report(cause: &str) {
    write(RECORD.load(Ordering::Acquire), ["", cause, "\n"]);
    let line = if IS_JSON.load(Ordering::Relaxed) {
        [
            "{\"level\":\"ERROR\",\"fields\":{\"message\":\"",
            cause,
            "\"}}\n",
        ]
    } else {
        ["", cause, "\n"]
    };
    write(libc::STDERR_FILENO, line);
}

/// Writes one line unless the file is a full pipe.
fn write(file: RawFd, line: [&str; 3]) {
    let mut ready = libc::pollfd {
        fd: file,
        events: libc::POLLOUT,
        revents: 0,
    };
    let parts = line.map(|part| libc::iovec {
        iov_base: part.as_ptr().cast_mut().cast(),
        iov_len: part.len(),
    });
    // SAFETY: both calls access only living local data and are safe in a signal handler; `writev`
    // only reads the parts.
    unsafe {
        if libc::poll(&raw mut ready, 1, 0) == 1 && ready.revents & libc::POLLOUT != 0 {
            // Nothing can be done about an error.
            let _ = libc::writev(file, parts.as_ptr(), parts.len() as c_int);
        }
    }
}
