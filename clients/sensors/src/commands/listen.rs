//! `hz` and `echo`: print a hand's frame rate or frames.

use std::sync::atomic::Ordering;
use std::time::Duration;

use serde_json::json;
use shm_bus::{Bus, Realtime, Subscriber, now_ns};
use shm_schemas::service::HAND_FRAME;
use shm_schemas::{Hand, HandFrame};

use super::{print, stop_on_signal};
use crate::cli::{BusArgs, Format};
use crate::failure::Failure;

/// Pause between bus reads. Design choice: the bus buffers far longer.
const PAUSE: Duration = Duration::from_millis(5);
const SECOND_NS: u64 = 1_000_000_000;

fn subscribe(args: &BusArgs) -> Result<Subscriber<HandFrame>, Failure> {
    let node = Bus::join(&args.bus, "sensor-listener", Realtime::No).map_err(Failure::Bus)?;
    let service = HAND_FRAME[usize::from(args.hand != Hand::LEFT)];
    node.subscriber(service).map_err(Failure::Bus)
}

pub(super) fn hz(args: &BusArgs, seconds: Option<u64>) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let mut frames = subscribe(args)?;
    let begun_ns = now_ns();
    let mut second = RateWindow::default();
    let mut printed = 0;
    while !stop.load(Ordering::Relaxed) && seconds.is_none_or(|end| printed < end) {
        frames
            .drain(256, |frame| second.take(frame))
            .map_err(Failure::Bus)?;
        if now_ns() - begun_ns >= (printed + 1) * SECOND_NS {
            print(&second.line(args))?;
            second.begin_next();
            printed += 1;
        }
        std::thread::sleep(PAUSE);
    }
    Ok(())
}

/// Frame statistics of one second.
#[derive(Default)]
struct RateWindow {
    frames: u64,
    lost: u64,
    min_ns: Option<u64>,
    max_ns: u64,
    sum_ns: u64,
    /// Epoch, sequence and capture time of the newest frame.
    newest: Option<(u64, u64, u64)>,
}

impl RateWindow {
    fn take(&mut self, frame: &HandFrame) {
        let stamp = frame.stamp;
        self.frames += 1;
        if let Some((epoch, sequence, captured_ns)) = self.newest
            && epoch == stamp.writer_epoch
        {
            let period_ns = stamp.captured_ns.saturating_sub(captured_ns);
            let gap = stamp.sequence.saturating_sub(sequence).saturating_sub(1);
            self.lost = self.lost.saturating_add(gap);
            self.min_ns = Some(self.min_ns.map_or(period_ns, |min| min.min(period_ns)));
            self.max_ns = self.max_ns.max(period_ns);
            self.sum_ns = self.sum_ns.saturating_add(period_ns);
        }
        self.newest = Some((stamp.writer_epoch, stamp.sequence, stamp.captured_ns));
    }

    fn begin_next(&mut self) {
        *self = Self {
            newest: self.newest,
            ..Self::default()
        };
    }

    /// Returns the mean period, ns; `None` without two consecutive frames.
    fn mean_ns(&self) -> Option<f64> {
        self.min_ns?;
        Some(self.sum_ns as f64 / self.frames as f64)
    }

    fn line(&self, args: &BusArgs) -> String {
        let ms = |ns: f64| (ns / 1e4).round() / 100.0;
        let (min, mean) = (self.min_ns.map(|ns| ms(ns as f64)), self.mean_ns().map(ms));
        let max = self.min_ns.map(|_| ms(self.max_ns as f64));
        if args.format == Format::Json {
            let period = json!({ "min": min, "mean": mean, "max": max });
            return json!({
                "hand": args.hand.to_string(),
                "frames": self.frames,
                "lost": self.lost,
                "rate_hz": self.frames,
                "period_ms": period,
            })
            .to_string();
        }
        match (min, mean, max) {
            (Some(min), Some(mean), Some(max)) => format!(
                "{} Hz, {} lost; period {mean:.2} ms ({min:.2} to {max:.2})",
                self.frames, self.lost
            ),
            _ => format!("{} Hz: too few frames for a period", self.frames),
        }
    }
}

pub(super) fn echo(args: &BusArgs, limit: Option<u64>) -> Result<(), Failure> {
    let stop = stop_on_signal()?;
    let mut frames = subscribe(args)?;
    let mut lines = Vec::new();
    let mut printed = 0;
    while !stop.load(Ordering::Relaxed) {
        frames
            .drain(256, |frame| lines.push(line(frame, args.format)))
            .map_err(Failure::Bus)?;
        for line in lines.drain(..) {
            if limit.is_some_and(|limit| printed >= limit) {
                return Ok(());
            }
            print(&line)?;
            printed += 1;
        }
        if limit.is_some_and(|limit| printed >= limit) {
            return Ok(());
        }
        std::thread::sleep(PAUSE);
    }
    Ok(())
}

fn line(frame: &HandFrame, format: Format) -> String {
    let fingers = (frame.finger_count as usize).min(frame.force_n.len());
    let valid = |finger: usize, element: usize| frame.valid_mask[finger] >> element & 1 == 1;
    let sum = |finger: usize| {
        let mut sum = [0.0_f32; 3];
        let measured = frame.force_n[finger].iter().enumerate();
        for (_, force_n) in measured.filter(|(element, _)| valid(finger, *element)) {
            sum.iter_mut().zip(force_n).for_each(|(s, f)| *s += f);
        }
        sum
    };
    if format == Format::Json {
        let fingers: Vec<_> = (0..fingers)
            .map(|finger| {
                let count = 64 - frame.valid_mask[finger].leading_zeros() as usize;
                json!({
                    "finger": finger,
                    "valid": frame.valid_mask[finger].count_ones(),
                    "force_n": sum(finger),
                    "taxels_n": frame.force_n[finger][..count],
                })
            })
            .collect();
        return json!({
            "hand": frame.hand.to_string(),
            "sequence": frame.stamp.sequence,
            "captured_ns": frame.stamp.captured_ns,
            "fingers": fingers,
        })
        .to_string();
    }
    let texts: Vec<String> = (0..fingers)
        .map(|finger| match (frame.valid_mask[finger], sum(finger)) {
            (0, _) => format!("finger {finger}: -"),
            (_, [n, t1, t2]) => format!("finger {finger}: {n:.3} {t1:.3} {t2:.3} N"),
        })
        .collect();
    format!("{} {}", frame.stamp.sequence, texts.join("; "))
}
