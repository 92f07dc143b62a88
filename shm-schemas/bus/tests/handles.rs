//! Cost of many handles of one process on one bus.

use rustix::time::{ClockId, clock_gettime};
use shm_bus::{Bus, FreshBus, Realtime};

/// Handles per batch and batches per measurement, of which the fastest counts; handles between the
/// two measurements. All of them need fewer than 1024 file descriptors.
const BATCH: usize = 4;
const BATCHES: usize = 5;
const BETWEEN: usize = 160;
/// Largest ratio of the last to the first measurement. Design choice: a search per handle gave a
/// ratio of about 10, noise stays below 3.
const RATIO_MAX: f64 = 5.0;

/// Processor time of this thread, s.
fn cpu_s() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Regression: every new handle examined all others, so that 300 handles took 12 s.
#[test]
fn late_handle_opens_as_fast_as_early_one() {
    let name = FreshBus::new("handles");
    let mut handles = Vec::new();
    let mut open = |count: usize| {
        let begin_s = cpu_s();
        for _ in 0..count {
            handles.push(Bus::open(&name, "handle", Realtime::No).expect("opens"));
        }
        (cpu_s() - begin_s) / count as f64
    };
    let mut batches_s = [[0.0; BATCHES]; 2];
    batches_s[0].fill_with(|| open(BATCH));
    open(BETWEEN);
    batches_s[1].fill_with(|| open(BATCH));
    let [early_s, late_s] = batches_s.map(|all| all.into_iter().fold(f64::INFINITY, f64::min));
    assert!(
        late_s < RATIO_MAX * early_s,
        "a late handle takes {late_s:.6} s, an early one {early_s:.6} s"
    );
}
