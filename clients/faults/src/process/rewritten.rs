//! Frames that change after their publication.

use std::fs::File;
use std::os::unix::fs::FileExt;

use sim_backend::random::split_mix;
use zerocopy::IntoBytes;

use super::{Drill, Effect, Pace, Rig};

/// Ticks with rewritten frames.
const TICKS: u64 = 200;
/// Bytes at the start of a frame that identify it: stamp with sequence number, time and writer.
const STAMP_BYTES: usize = 24;

/// A process of the same user writes into the shared memory of published frames.
pub(super) const FRAME_REWRITTEN: Drill = Drill::new(Pace::Clock, frame_rewritten);

fn frame_rewritten(rig: &mut Rig<'_>) -> anyhow::Result<Effect> {
    rig.promise();
    let mut random = rig.course.fault_seed();
    let mut segment: Option<File> = None;
    let mut rewritten = 0;
    for _ in 0..TICKS {
        rig.advance(1)?;
        let Some(frame) = rig.last_frame().copied() else {
            continue;
        };
        let bytes = frame.as_bytes();
        if segment.is_none() {
            segment = find_segment(rig.observer.prefix(), &bytes[..STAMP_BYTES])?;
        }
        let Some(file) = &segment else {
            continue;
        };
        for at in positions(file, &bytes[..STAMP_BYTES])? {
            random = split_mix(random);
            let offset = random as usize % bytes.len();
            file.write_all_at(&random.to_le_bytes()[..1], at + offset as u64)?;
            rewritten += 1;
        }
    }
    if rewritten == 0 {
        let reason = "could not find the shared memory of the frames in /dev/shm";
        return Ok(Effect::Skipped(reason.to_owned()));
    }
    Ok(Effect::Done)
}

/// Returns the file of the bus that contains these bytes.
fn find_segment(prefix: &str, bytes: &[u8]) -> anyhow::Result<Option<File>> {
    let mut entries: Vec<_> = std::fs::read_dir("/dev/shm")?.flatten().collect();
    entries.sort_by_key(std::fs::DirEntry::file_name);
    for entry in entries {
        if !entry.file_name().to_string_lossy().contains(prefix) {
            continue;
        }
        let opened = File::options().read(true).write(true).open(entry.path());
        let Ok(file) = opened else { continue };
        if !positions(&file, bytes)?.is_empty() {
            return Ok(Some(file));
        }
    }
    Ok(None)
}

/// Returns all positions of these bytes in a file.
fn positions(file: &File, bytes: &[u8]) -> std::io::Result<Vec<u64>> {
    let mut content = vec![0; file.metadata()?.len() as usize];
    file.read_exact_at(&mut content, 0)?;
    let windows = content.windows(bytes.len()).enumerate();
    let found = windows.filter(|(_, window)| *window == bytes);
    Ok(found.map(|(at, _)| at as u64).collect())
}
