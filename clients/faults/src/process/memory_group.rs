//! Memory control group of one process, version 1 or 2.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Mutex;

/// Limit of the group, bytes. Design choice: a daemon requests less after it has joined.
const LIMIT_BYTES: u64 = 64 << 20;
/// Memory that the second process requests, bytes. Design choice: several times the limit.
const REQUESTED_BYTES: u64 = 256 << 20;

/// Control group with a memory limit; removed on drop.
#[derive(Debug)]
pub(crate) struct MemoryGroup {
    path: PathBuf,
    limit: PathBuf,
    /// Process that requests memory.
    consumer: Mutex<Option<Child>>,
}

impl MemoryGroup {
    /// Creates a group below that of this process.
    ///
    /// # Errors
    /// Reason: there is no memory controller, or this user may not use it.
    pub(crate) fn create() -> Result<Self, String> {
        let own = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
        let mut reason = "no memory controller for control groups".to_owned();
        for line in own.lines() {
            let mut fields = line.splitn(3, ':').skip(1);
            let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else {
                continue;
            };
            let root = match controllers {
                "" => Path::new("/sys/fs/cgroup").to_owned(),
                "memory" => Path::new("/sys/fs/cgroup/memory").to_owned(),
                _ => continue,
            };
            let own = root.join(path.trim_start_matches('/'));
            // A group with processes cannot have children with limits (version 2): the parent may.
            for parent in [Some(own.as_path()), own.parent(), Some(root.as_path())]
                .into_iter()
                .flatten()
            {
                match Self::create_in(parent) {
                    Ok(group) => return Ok(group),
                    Err(why) => reason = why,
                }
            }
        }
        Err(reason)
    }

    fn create_in(parent: &Path) -> Result<Self, String> {
        let path = parent.join(format!("atas-fault-{}", std::process::id()));
        fs::create_dir(&path)
            .map_err(|error| format!("could not make the group {}: {error}", path.display()))?;
        let limits = ["memory.max", "memory.limit_in_bytes"].map(|name| path.join(name));
        let limit = limits.into_iter().find(|limit| limit.exists());
        let group = Self {
            limit: limit.clone().unwrap_or_default(),
            path,
            consumer: Mutex::new(None),
        };
        let write = limit.map(|limit| fs::write(limit, LIMIT_BYTES.to_string()));
        match write {
            Some(Ok(())) => Ok(group),
            Some(Err(error)) => Err(format!("could not set {}: {error}", group.limit.display())),
            None => Err(format!("{} has no memory limit", group.path.display())),
        }
    }

    /// Moves a process into the group, makes it the kernel's first choice, and exhausts the memory.
    ///
    /// # Errors
    /// Reason: the kernel does not permit it.
    pub(crate) fn exhaust(&self, pid: u32) -> Result<(), String> {
        let members = self.path.join("cgroup.procs");
        fs::write(&members, pid.to_string())
            .map_err(|error| format!("could not move the daemon into a control group: {error}"))?;
        let score = format!("/proc/{pid}/oom_score_adj");
        fs::write(&score, "1000").map_err(|error| format!("could not write {score}: {error}"))?;
        let script = "echo $$ > \"$1\" && head -c \"$2\" /dev/zero | tail -c \"$2\" > /dev/null";
        let consumer = Command::new("sh")
            .args(["-c", script, "sh"])
            .arg(&members)
            .arg(REQUESTED_BYTES.to_string())
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map_err(|error| format!("could not start sh: {error}"))?;
        *self.lock() = Some(consumer);
        Ok(())
    }

    /// Returns true if the process that requests memory has ended.
    pub(crate) fn has_ended(&self) -> bool {
        let mut consumer = self.lock();
        let consumer = consumer.as_mut();
        consumer.is_none_or(|process| !matches!(process.try_wait(), Ok(None)))
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Option<Child>> {
        let consumer = self.consumer.lock();
        consumer.unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

impl Drop for MemoryGroup {
    fn drop(&mut self) {
        if let Some(mut consumer) = self.lock().take() {
            // Both fail harmlessly if the process has ended.
            let _ = consumer.kill();
            let _ = consumer.wait();
        }
        // Processes of the pipe and the daemon leave the group at their end.
        let parent = self.path.parent().unwrap_or(Path::new("/"));
        let members = fs::read_to_string(self.path.join("cgroup.procs")).unwrap_or_default();
        for pid in members.lines() {
            let _ = fs::write(parent.join("cgroup.procs"), pid);
        }
        let _ = fs::remove_dir(&self.path);
    }
}
