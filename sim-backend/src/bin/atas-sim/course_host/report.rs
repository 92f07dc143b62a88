//! Results of a course on standard output after its end.

use sim_backend::course::{Host, RobotResult};

use super::RobotSession;
use crate::failure::Failure;
use crate::output::{self, Format};

/// Prints one line per robot, in lane order.
pub(super) fn print(host: &Host, seats: &[RobotSession], format: Format) -> Result<(), Failure> {
    let seats = seats.iter().enumerate();
    let lines: Vec<String> = seats
        .map(|(robot, seat)| {
            let ended = host.result(robot, &seat.truth());
            match format {
                // Serialisation cannot fail: only numbers and strings.
                Format::Json => serde_json::to_string(&ended).unwrap_or_default(),
                Format::Human => result_line(&ended),
            }
        })
        .collect();
    output::print(&lines)
}

fn result_line(ended: &RobotResult) -> String {
    let mishap = ended.mishap.as_deref().unwrap_or("no mishap");
    let drive = ended.drive.map_or_else(String::new, |drive| {
        format!(
            ", carried for {:.1} s with a slip of {:.2} mm",
            drive.took_s,
            drive.slip_m * 1e3
        )
    });
    format!(
        "{}: {mishap}{drive}; {:.3} m from its goal after {:.1} s",
        ended.object, ended.off_goal_m, ended.simulated_s
    )
}
