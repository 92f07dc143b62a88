//! Runs seeded trials on all cores; results keep the order of the indices.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

/// Calls `run` with each index below `count` on `threads` threads (0: one per core); `None` if
/// stopped.
///
/// # Errors
/// The first error of `run`, or the threads do not start.
pub fn run_indexed<T: Send>(
    count: u64,
    threads: usize,
    stop: &AtomicBool,
    run: impl Fn(u64) -> anyhow::Result<T> + Sync,
) -> anyhow::Result<Option<Vec<T>>> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let one = |index: u64| {
        let stopped = stop.load(Ordering::Relaxed);
        (!stopped).then(|| run(index)).transpose()
    };
    let indices: Vec<u64> = (0..count).collect();
    let ended: anyhow::Result<Vec<Option<T>>> =
        pool.install(|| indices.into_par_iter().with_max_len(1).map(one).collect());
    Ok(ended?.into_iter().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_keep_the_order_and_stop_gives_none() {
        let stop = AtomicBool::new(false);
        let squares = |stop: &AtomicBool| run_indexed(5, 2, stop, |index| Ok(index * index));
        assert_eq!(
            squares(&stop).expect("no error"),
            Some(vec![0, 1, 4, 9, 16])
        );
        stop.store(true, Ordering::Relaxed);
        assert_eq!(squares(&stop).expect("no error"), None);
    }
}
