//! One fuzz target.

/// Reader of foreign bytes with its seeds.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Name on the command line and of the coverage-guided target.
    pub name: &'static str,
    /// Passes an input to the reader. Panics if the reader breaks a promise.
    pub run: fn(&[u8]),
    /// Returns valid inputs.
    pub seeds: fn() -> Vec<Vec<u8>>,
    /// Longest input, bytes.
    pub length_max: usize,
    /// Most memory that one input may allocate at a time, bytes.
    pub memory_max: u64,
    /// Executions of the ordinary test.
    pub test_executions: u64,
}

impl Target {
    /// Creates a target with the usual limits.
    pub(crate) const fn new(
        name: &'static str,
        run: fn(&[u8]),
        seeds: fn() -> Vec<Vec<u8>>,
    ) -> Self {
        Self {
            name,
            run,
            seeds,
            length_max: 4 << 10,
            memory_max: 16 << 20,
            test_executions: 2_000,
        }
    }

    /// Sets the longest input, bytes.
    pub(crate) const fn length(self, length_max: usize) -> Self {
        Self { length_max, ..self }
    }

    /// Sets the memory limit, bytes.
    pub(crate) const fn memory(self, memory_max: u64) -> Self {
        Self { memory_max, ..self }
    }

    /// Sets the executions of the ordinary test.
    pub(crate) const fn executions(self, test_executions: u64) -> Self {
        Self {
            test_executions,
            ..self
        }
    }
}
