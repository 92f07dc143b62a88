//! Last words of a process: a fatal signal leaves its cause before it ends the process.
//!
//! ```text
//!  SIGSEGV, SIGBUS, SIGXCPU, … ─▶ one line on standard error and in a record ─▶ usual end
//! ```
//!
//! * **Invariants:** the handler only calls functions that are safe in a signal handler, and never
//!   waits for a reader of standard error. Core dumps and the message about an overflowed stack
//!   stay as without it.
//! * **Not included:** `SIGKILL`, which no process sees.

use std::ffi::c_int;
use std::io;
use std::mem::MaybeUninit;
use std::os::fd::{IntoRawFd, OwnedFd, RawFd};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicI32, Ordering};

/// Fatal signals with their last words.
const WORDS: [(c_int, &str); 8] = [
    (
        libc::SIGABRT,
        "ended by SIGABRT: a fault in the program, see above\n",
    ),
    (
        libc::SIGBUS,
        "ended by SIGBUS: a file in use was truncated, or memory failed\n",
    ),
    (libc::SIGFPE, "ended by SIGFPE: a fault in the program\n"),
    (
        libc::SIGILL,
        "ended by SIGILL: a fault in the program, or a wrong processor\n",
    ),
    (libc::SIGSEGV, "ended by SIGSEGV: a fault in the program\n"),
    (
        libc::SIGSYS,
        "ended by SIGSYS: a system call is forbidden here\n",
    ),
    (
        libc::SIGXCPU,
        "ended by SIGXCPU: a thread computed beyond its limit (real time, RLIMIT_CPU)\n",
    ),
    (
        libc::SIGXFSZ,
        "ended by SIGXFSZ: a file exceeded its limit (RLIMIT_FSIZE)\n",
    ),
];

/// Handlers before [`install`], in the order of [`WORDS`].
static BEFORE: OnceLock<[libc::sigaction; WORDS.len()]> = OnceLock::new();
/// File of the record; negative for none.
static RECORD: AtomicI32 = AtomicI32::new(-1);

/// Installs the handlers, once per process.
///
/// # Errors
/// [`io::Error`] if the kernel refuses a handler.
pub fn install() -> io::Result<()> {
    let mut before = [MaybeUninit::<libc::sigaction>::uninit(); WORDS.len()];
    for ((signal, _), before) in WORDS.iter().zip(&mut before) {
        // SAFETY: the call writes the present handler of this signal to `before`.
        check(unsafe { libc::sigaction(*signal, std::ptr::null(), before.as_mut_ptr()) })?;
    }
    // SAFETY: the loop has initialised all elements.
    let before = before.map(|before| unsafe { before.assume_init() });
    let is_first = BEFORE.set(before).is_ok();
    for ((signal, _), before) in WORDS.iter().zip(before) {
        // A parent may have set signals to be ignored.
        if !is_first || before.sa_sigaction == libc::SIG_IGN {
            continue;
        }
        // SAFETY: zero is a valid value of all fields; `speak` is safe in a signal handler and has
        // the signature that SA_SIGINFO requires.
        check(unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = speak as *const () as usize;
            action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
            libc::sigaction(*signal, &raw const action, std::ptr::null_mut())
        })?;
    }
    Ok(())
}

/// Also appends the last words to this file, which stays open until the process ends.
pub fn record_to(file: OwnedFd) {
    RECORD.store(file.into_raw_fd(), Ordering::Release);
}

fn check(result: c_int) -> io::Result<()> {
    if result == 0 {
        Ok(())
    } else {
        Err(io::Error::last_os_error())
    }
}

/// Writes the words of a signal. A fault of this thread goes to the former handler, which knows
/// overflowed stacks; another signal ends the process.
extern "C" fn speak(signal: c_int, info: *mut libc::siginfo_t, _context: *mut libc::c_void) {
    let known = WORDS.iter().position(|(number, _)| *number == signal);
    let Some((index, before)) = known.zip(BEFORE.get()) else {
        return;
    };
    write(libc::STDERR_FILENO, WORDS[index].1);
    write(RECORD.load(Ordering::Acquire), WORDS[index].1);
    // SAFETY: `before` was a handler of this signal, zero is the usual action, and the kernel passes
    // a valid `info`.
    unsafe {
        let sent = (*info).si_code <= 0;
        if sent || ![libc::SIGBUS, libc::SIGFPE, libc::SIGILL, libc::SIGSEGV].contains(&signal) {
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

/// Writes to a file unless that would wait.
fn write(file: RawFd, words: &str) {
    let mut ready = libc::pollfd {
        fd: file,
        events: libc::POLLOUT,
        revents: 0,
    };
    // SAFETY: both calls access only living local data and are safe in a signal handler.
    unsafe {
        if libc::poll(&raw mut ready, 1, 0) == 1 && ready.revents & libc::POLLOUT != 0 {
            // Nothing can be done about an error.
            let _ = libc::write(file, words.as_ptr().cast(), words.len());
        }
    }
}
