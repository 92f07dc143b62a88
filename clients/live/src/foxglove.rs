//! `atas foxglove`: serves a running daemon over Foxglove's WebSocket protocol, for custom layouts.
//!
//! Topics and types equal those of an exported recording ([`atas_recording::Messages`]), so that
//! layouts fit both. The server is read-only and reachable from this machine only.

use std::array;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context as _;
use atas_client::{ClientError, Observer, Session};
use atas_console::arguments::Foxglove;
use atas_console::{Interrupt, Output};
use atas_recording::{MessageType, Messages, Outlet, Row, RowInputs, Subject};
use foxglove::{Context, PartialMetadata, RawChannel, Schema};
use robot_model::RobotFiles;
use serde_json::json;
use shm_bus::{BusError, End};
use shm_schemas::capacity::HANDS;
use shm_schemas::{ModuleEvent, Status, TickReport, View};
use tokio::sync::oneshot;

use crate::connections::BoundedListener;
use crate::displayed::RobotDisplay;
use crate::entrance;
use crate::guard::Guard;
use crate::polling::poll_bus;

/// Interval of robot descriptions, for clients that connect later.
const DESCRIPTION_INTERVAL: Duration = Duration::from_secs(1);
/// Transforms and point clouds per second: one per poll.
const PICTURES_HZ: f64 = 60.0;
/// Example layout: 3-D, forces, slip, modules, events.
const LAYOUT: &str = include_str!("../foxglove-layout.json");

pub(crate) fn foxglove(
    arguments: &Foxglove,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    if arguments.print_layout {
        return output.bytes(LAYOUT.as_bytes());
    }
    let reported = arguments.robot.as_deref().map(RobotFiles::find);
    let reported = reported.transpose()?;
    let context = Context::new();
    let runtime = crate::server::runtime()?;
    let listener = runtime.block_on(crate::server::listen(arguments.port))?;
    let port = listener.local_addr()?.port();
    let guard = Guard::new(port).context("could not draw a token")?;
    let inner = entrance::inner_address().context("could not draw an address")?;
    let server = context.websocket_server().name("atas");
    let server = server.bind(inner.to_string(), 0).start_blocking();
    let server = server.context("could not start the server")?;
    let inner = SocketAddr::from((inner, server.port()));
    announce(port, output)?;
    let begin = |watch, _: &Session| Ok((watch, Converter::new(reported.as_ref(), &context)));
    std::thread::scope(|threads| {
        let (end, ended) = oneshot::channel::<()>();
        threads.spawn(move || {
            let listener = BoundedListener::new(listener);
            runtime.spawn(entrance::serve(listener, guard, inner));
            // The end of the sender is the signal. Connections end with the runtime.
            let _ = runtime.block_on(ended);
        });
        poll_bus(
            &arguments.bus.bus,
            interrupt.flag(),
            begin,
            |(watch, teller), session| poll(watch, teller, session),
            |error| tracing::debug!("{error:#}"),
        );
        drop(end);
    });
    // Waiting for the library's tasks would wait for their viewers.
    drop(server.stop());
    Ok(())
}

fn announce(port: u16, output: &mut Output) -> anyhow::Result<()> {
    let url = format!("ws://127.0.0.1:{port}");
    if output.is_json() {
        return output.json(&json!({ "url": url, "port": port }));
    }
    output.line(format_args!(
        "open {url} in Foxglove (Open connection, Foxglove WebSocket); `atas foxglove \
         --print-layout > atas.json` writes a layout to import; Ctrl-C ends the server"
    ))
}

fn poll(watch: &mut Observer, teller: &mut Converter<'_>, session: &Session) -> anyhow::Result<()> {
    let (mut reports, mut events) = (Vec::new(), Vec::new());
    watch.poll(|report| reports.push(*report), |event| events.push(*event))?;
    teller.update_robot(&watch.status, session)?;
    teller.send(&watch.view, reports, &events)?;
    if !watch.is_alive() && watch.status.pid != 0 {
        // A new daemon may use a newly created bus.
        let bus = session.bus();
        return Err(ClientError::NoDaemon {
            bus: bus.name().to_string(),
            folder: bus.folder().to_owned(),
            end: End::last(bus.name()),
        }
        .into());
    }
    Ok(())
}

type Hashes = [u64; HANDS];

struct Converter<'a> {
    showing: RobotDisplay<'a>,
    context: &'a Arc<Context>,
    hashes: Hashes,
    messages: Option<Messages<Channels>>,
    described: Instant,
}

impl<'a> Converter<'a> {
    fn new(reported: Option<&'a RobotFiles>, context: &'a Arc<Context>) -> Self {
        Self {
            showing: RobotDisplay::new(reported),
            context,
            hashes: Hashes::default(),
            messages: None,
            described: Instant::now(),
        }
    }

    fn update_robot(&mut self, status: &Status, session: &Session) -> Result<(), BusError> {
        if self.showing.update(session.bus(), status)? {
            self.messages = None;
        }
        Ok(())
    }

    fn send(
        &mut self,
        view: &View,
        reports: Vec<TickReport>,
        events: &[ModuleEvent],
    ) -> anyhow::Result<()> {
        let Some(shown) = self.showing.shown() else {
            return Ok(());
        };
        let hashes = view.frames.each_ref().map(|frame| frame.layout_hash);
        if self.messages.is_none() || hashes != self.hashes {
            self.hashes = hashes;
            let layouts = array::from_fn(|hand| {
                let known = shown.layout(hand, hashes[hand]);
                known.unwrap_or_else(|| shown.layouts[hand])
            });
            let subject = Subject::live(shown.robot.clone(), layouts, shown.fingers)?;
            let channels = Channels {
                context: Arc::clone(self.context),
                open: Vec::new(),
            };
            self.messages = Some(Messages::new(channels, subject, PICTURES_HZ));
        }
        let Some(messages) = &mut self.messages else {
            return Ok(());
        };
        if self.described.elapsed() >= DESCRIPTION_INTERVAL {
            self.described = Instant::now();
            messages.describe(view.stamp.captured_ns)?;
        }
        rows(view, reports, events)
            .iter()
            .try_for_each(|row| messages.row(row))
    }
}

/// Makes one row per report; the newest includes frames, joints and events.
fn rows(view: &View, reports: Vec<TickReport>, events: &[ModuleEvent]) -> Vec<Row> {
    let row = |report: TickReport| Row {
        tick: report.tick,
        captured_ns: report.stamp.captured_ns,
        report: Some(Box::new(report)),
        ..Row::default()
    };
    let mut rows: Vec<Row> = reports.into_iter().map(row).collect();
    if let Some(newest) = rows.last_mut() {
        let frame = |hand: usize| (view.has_frame[hand] != 0).then_some(view.frames[hand]);
        newest.inputs = Some(Box::new(RowInputs {
            frames: std::array::from_fn(frame),
            joints: (view.has_joints != 0).then_some(view.joints),
            ..RowInputs::default()
        }));
        newest.events = events.to_vec();
    }
    rows
}

/// Topics of the server. Opening a topic twice gives the same channel.
struct Channels {
    context: Arc<Context>,
    open: Vec<Arc<RawChannel>>,
}

impl Outlet for Channels {
    fn open(&mut self, topic: &str, of: &MessageType, unit: &str) -> anyhow::Result<u16> {
        let schema = Schema::new(of.name, MessageType::LANGUAGE, of.schema().into_bytes());
        let channel = self.context.channel_builder(topic).schema(schema);
        let channel = channel.message_encoding(MessageType::ENCODING);
        let channel = match unit {
            "" => channel,
            unit => channel.add_metadata("unit", unit),
        };
        self.open.push(channel.build_raw()?);
        u16::try_from(self.open.len() - 1).context(
            "could not open another topic: more than 65535 \
            are open; report this",
        )
    }

    fn send(&mut self, channel: u16, unix_ns: u64, cdr: &[u8]) -> anyhow::Result<()> {
        let meta = PartialMetadata {
            log_time: Some(unix_ns),
        };
        self.open[usize::from(channel)].log_with_meta(cdr, meta);
        Ok(())
    }
}
