//! Teleoperation by keyboard: each key press moves the target by one step.

use std::io::{IsTerminal, Write};
use std::time::Duration;

use anyhow::Context;
use atas_client::{Session, TeleopHands, TeleopTarget, text};
use atas_console::arguments::Teleop;
use atas_console::{Exit, ExitError, Interrupt, Output};
use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyEventKind, KeyModifiers};
use ratatui::crossterm::terminal::{disable_raw_mode, enable_raw_mode};
use shm_schemas::{FingerReport, Hand};

use crate::keys::{self, KeyInput};

use super::{Stream, VALID_NS};

/// Pause between two targets: 20 Hz.
const PAUSE: Duration = Duration::from_millis(50);
/// Initial opening, mm. Design choice: the hand's opening at home.
const OPENING_MM: f64 = 70.0;
/// Key help above the status line.
const KEYS: &str = "arrows: forward, back, left, right   page up, page down: up, down   [ ]: turn   o c: open, close   h: hold   \
                    q: end";

#[derive(Clone, Copy, Debug, PartialEq)]
struct Jog {
    centre_m: [f64; 3],
    yaw_deg: f64,
    opening_mm: f64,
    holds: bool,
}

/// Effect of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
enum KeyEffect {
    Ignored,
    Moved,
    End,
}

/// Moves a hand until `q`, Escape or Ctrl-C.
pub(super) fn jog(
    arguments: &Teleop,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    if !(std::io::stdin().is_terminal() && std::io::stderr().is_terminal()) {
        return Err(ExitError::with_code(
            Exit::Usage,
            "could not read keys: standard input or standard error is no terminal; pass a target \
             file",
        ));
    }
    let hand = Hand::from(arguments.hand);
    let session = Session::existing(&arguments.bus.bus)?;
    let mut stream = Stream::open(&session, TeleopHands::One(hand))?;
    enable_raw_mode().context("could not prepare the terminal")?;
    let teleoperated = send_targets(arguments, hand, &mut stream, interrupt);
    let restored = disable_raw_mode().context("could not restore the terminal");
    let _written = writeln!(std::io::stderr());
    let sent = teleoperated?;
    restored?;
    stream.end(sent, interrupt.is_set(), output)
}

/// Sends the target repeatedly; returns the number of sent targets.
fn send_targets(
    arguments: &Teleop,
    hand: Hand,
    stream: &mut Stream,
    interrupt: &Interrupt,
) -> anyhow::Result<u64> {
    let place = hand.index().unwrap_or(0);
    let mut jog = Jog {
        centre_m: stream.leader.report().hands[place].centre_m,
        yaw_deg: arguments.yaw,
        opening_mm: OPENING_MM,
        holds: false,
    };
    let (step_m, turn_deg) = (arguments.step * 1e-3, arguments.turn);
    let mut screen = std::io::stderr();
    write!(screen, "{KEYS}\r\n").context("could not draw on the terminal")?;
    let mut sent = 0;
    while !interrupt.is_set() {
        for warning in stream.poll()? {
            write!(screen, "\r\x1b[K{warning}\r\n").context("could not draw on the terminal")?;
        }
        stream.leader.send(&jog.wanted(hand), VALID_NS)?;
        sent += 1;
        let report = &stream.leader.report().hands[place];
        let line = jog.line(&report.fingers[..stream.fingertips]);
        write!(screen, "\r\x1b[K{line}").context("could not draw on the terminal")?;
        screen.flush().context("could not draw on the terminal")?;
        match keys::wait(PAUSE)? {
            KeyInput::Key(key) if jog.press(key, step_m, turn_deg) == KeyEffect::End => break,
            KeyInput::Disconnected => break,
            KeyInput::Key(_) | KeyInput::Nothing => {}
        }
    }
    Ok(sent)
}

impl Jog {
    fn wanted(&self, hand: Hand) -> TeleopTarget {
        TeleopTarget {
            hand,
            centre_m: self.centre_m,
            yaw_rad: self.yaw_deg.to_radians(),
            opening_m: (!self.holds).then_some(self.opening_mm * 1e-3),
        }
    }

    fn press(&mut self, key: KeyEvent, step_m: f64, turn_deg: f64) -> KeyEffect {
        if key.kind == KeyEventKind::Release {
            return KeyEffect::Ignored;
        }
        let ends = key.code == KeyCode::Char('c') && key.modifiers.contains(KeyModifiers::CONTROL);
        let [x_m, y_m, z_m] = &mut self.centre_m;
        match key.code {
            _ if ends => return KeyEffect::End,
            KeyCode::Char('q') | KeyCode::Esc => return KeyEffect::End,
            KeyCode::Up => *x_m += step_m,
            KeyCode::Down => *x_m -= step_m,
            KeyCode::Left => *y_m += step_m,
            KeyCode::Right => *y_m -= step_m,
            KeyCode::PageUp => *z_m += step_m,
            KeyCode::PageDown => *z_m -= step_m,
            KeyCode::Char('[') => self.yaw_deg += turn_deg,
            KeyCode::Char(']') => self.yaw_deg -= turn_deg,
            KeyCode::Char('o') => {
                self.opening_mm += step_m * 1e3;
                self.holds = false;
            }
            KeyCode::Char('c') => {
                self.opening_mm = (self.opening_mm - step_m * 1e3).max(0.0);
                self.holds = false;
            }
            KeyCode::Char('h') => self.holds = true,
            _ => return KeyEffect::Ignored,
        }
        KeyEffect::Moved
    }

    fn line(&self, fingers: &[FingerReport]) -> String {
        let [x_m, y_m, z_m] = self.centre_m;
        let grip = if self.holds {
            "hold".to_owned()
        } else {
            format!("open {:.0} mm", self.opening_mm)
        };
        let pressed_n: Vec<f32> = fingers.iter().map(|finger| finger.normal_n).collect();
        let pressed = text::newtons(&pressed_n);
        format!(
            "x {x_m:.3}  y {y_m:.3}  z {z_m:.3} m   yaw {:.0}°   {grip}   F_n {pressed} N",
            self.yaw_deg
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Jog = Jog {
        centre_m: [0.3, -0.2, 0.1],
        yaw_deg: 90.0,
        opening_mm: 3.0,
        holds: false,
    };

    #[test]
    fn each_key_changes_one_value_by_one_step() {
        let check = |code: KeyCode, change: fn(&mut Jog)| {
            let (mut jog, mut expected) = (START, START);
            let asked = jog.press(KeyEvent::new(code, KeyModifiers::NONE), 0.005, 10.0);
            change(&mut expected);
            assert_eq!((jog, asked), (expected, KeyEffect::Moved), "{code:?}");
        };
        check(KeyCode::Up, |j| j.centre_m[0] += 0.005);
        check(KeyCode::Down, |j| j.centre_m[0] -= 0.005);
        check(KeyCode::Left, |j| j.centre_m[1] += 0.005);
        check(KeyCode::Right, |j| j.centre_m[1] -= 0.005);
        check(KeyCode::PageUp, |j| j.centre_m[2] += 0.005);
        check(KeyCode::PageDown, |j| j.centre_m[2] -= 0.005);
        check(KeyCode::Char('['), |j| j.yaw_deg = 100.0);
        check(KeyCode::Char(']'), |j| j.yaw_deg = 80.0);
        check(KeyCode::Char('o'), |j| j.opening_mm = 8.0);
        check(KeyCode::Char('c'), |j| j.opening_mm = 0.0);
        check(KeyCode::Char('h'), |j| j.holds = true);
    }

    #[test]
    fn quit_keys_end_and_other_keys_are_ignored() {
        let press = |code, modifiers| {
            START
                .clone()
                .press(KeyEvent::new(code, modifiers), 0.005, 10.0)
        };
        for code in [KeyCode::Char('q'), KeyCode::Esc] {
            assert_eq!(press(code, KeyModifiers::NONE), KeyEffect::End);
        }
        assert_eq!(
            press(KeyCode::Char('c'), KeyModifiers::CONTROL),
            KeyEffect::End
        );
        assert_eq!(
            press(KeyCode::Char('x'), KeyModifiers::NONE),
            KeyEffect::Ignored
        );
    }
}
