//! Response of the grip to a disturbance: time from the onset of slip to the first closing command.

/// Sliding distance of a fingertip that counts as slip, m (acceptance criterion).
const SLIP_M: f64 = 1e-4;
/// Closing beyond the opening at the disturbance that counts as a response, m. Design choice: one
/// tick at the closing speed of both sides.
const CLOSED_M: f64 = 4e-6;

/// Progress of the response; times are since the disturbance, s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    slid_before_m: f64,
    opening_before_m: f64,
    onset_s: Option<f64>,
    command_s: Option<f64>,
}

impl Response {
    /// Begins with the fingertips' sliding distance and the commanded opening at the disturbance.
    pub(super) fn new(slid_m: f64, opening_m: f64) -> Self {
        Self {
            slid_before_m: slid_m,
            opening_before_m: opening_m,
            onset_s: None,
            command_s: None,
        }
    }

    /// Processes a tick.
    pub(super) fn update(&mut self, since_s: f64, slid_m: f64, opening_m: f64) {
        if slid_m - self.slid_before_m > SLIP_M {
            self.onset_s.get_or_insert(since_s);
        }
        let is_closed = opening_m < self.opening_before_m - CLOSED_M;
        if self.onset_s.is_some() && is_closed {
            self.command_s.get_or_insert(since_s);
        }
    }

    /// Returns true if a fingertip slipped.
    pub(super) fn has_slipped(&self) -> bool {
        self.onset_s.is_some()
    }

    /// Returns the time from the slip to the command, ms: 0 if the command came before; `None`
    /// without slip or command.
    pub(super) fn latency_ms(&self) -> Option<f64> {
        Some((self.command_s? - self.onset_s?) * 1e3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slides from 0.5 s on; the command closes from `close_s` on.
    fn response(slides: bool, close_s: f64) -> Response {
        let mut response = Response::new(0.001, 0.05);
        for tick in 0..1000 {
            let since_s = f64::from(tick) * 1e-3;
            let slid_m = if slides && since_s >= 0.5 {
                0.0012
            } else {
                0.00105
            };
            let opening_m = if since_s >= close_s { 0.0499 } else { 0.05 };
            response.update(since_s, slid_m, opening_m);
        }
        response
    }

    #[test]
    fn latency_counts_from_slip_to_command() {
        let check = |slides, close_s, expected: Option<f64>| {
            let response = response(slides, close_s);
            assert_eq!(response.has_slipped(), slides);
            let latency_ms = response.latency_ms().map(f64::round);
            assert_eq!(latency_ms, expected, "{slides} {close_s}");
        };
        check(true, 0.52, Some(20.0));
        check(true, 0.1, Some(0.0));
        check(true, 2.0, None);
        check(false, 0.1, None);
    }
}
