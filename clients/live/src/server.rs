//! HTTP server of the page, its data, and the requests stop and recover.

use std::future::{Future, IntoFuture, poll_fn};
use std::pin::pin;
use std::sync::Arc;
use std::task::Poll;
use std::time::Duration;

use anyhow::Context;
use atas_client::Run;
use atas_console::arguments::Dashboard;
use atas_console::{Interrupt, Output};
use axum::Router;
use axum::body::Bytes;
use axum::extract::ws::{Message, Utf8Bytes, WebSocket, WebSocketUpgrade};
use axum::extract::{Path, Request, State};
use axum::http::header::{self, HeaderValue};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use robot_model::RobotFiles;
use serde_json::json;
use shm_bus::BusName;
use shm_schemas::Status;
use tokio::net::TcpListener;
use tokio::runtime::Runtime;
use tokio::sync::broadcast::Receiver;
use tokio::sync::broadcast::error::RecvError;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::timeout;

use crate::connections::BoundedListener;
use crate::control;
use crate::displayed::DisplayedRobot;
use crate::feed::Feed;
use crate::guard::Guard;
use crate::observe::observe;
use crate::page::ASSETS;
use crate::recorded::LoadedRecording;
use crate::scene;

const POLL_INTERVAL: Duration = Duration::from_millis(50);
/// Most open pages; each costs CPU time.
const PAGES_MAX: usize = 16;
/// Longest time for a page to take a message. Design choice: a page in the background reads within
/// a second.
const SEND_TIMEOUT: Duration = Duration::from_secs(5);
/// Interval of pings without messages; shorter than the idle time of a connection.
const PING_INTERVAL: Duration = Duration::from_secs(10);
/// Most pictures of a recording per request.
const PICTURES_MAX: usize = 240;
/// Content security policy: the page may load from and connect to this server only.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
                      base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

struct Server {
    /// One permit per open page.
    places: Arc<Semaphore>,
    guard: Guard,
    bus: BusName,
    feed: Arc<Feed>,
    shelf: Option<LoadedRecording>,
}

impl Server {
    fn new(
        port: u16,
        bus: BusName,
        feed: Arc<Feed>,
        shelf: Option<LoadedRecording>,
    ) -> anyhow::Result<Self> {
        Ok(Self {
            places: Arc::new(Semaphore::new(PAGES_MAX)),
            guard: Guard::new(port).context("could not draw a token")?,
            bus,
            feed,
            shelf,
        })
    }
}

/// Makes the router of a dashboard on this port without a daemon. Its changes reach no bus.
pub(crate) fn unconnected_router(port: u16) -> anyhow::Result<Router> {
    let bus = "unconnected".parse()?;
    let server = Server::new(port, bus, Arc::default(), None)?;
    Ok(router(Arc::new(server)))
}

pub(crate) fn dashboard(
    arguments: &Dashboard,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let shelf = match &arguments.recording[..] {
        [] => None,
        files => Some(LoadedRecording::read(files)?),
    };
    let reported = arguments.robot.as_deref().map(RobotFiles::find);
    let reported = reported.transpose()?;
    let feed = Arc::<Feed>::default();
    let unheard = DisplayedRobot::from_run(reported.as_ref(), &Run::default(), &Status::default());
    feed.history().scene = scene::scene(&unheard)?;
    let runtime = runtime()?;
    let listener = runtime.block_on(listen(arguments.port))?;
    let address = listener.local_addr()?;
    let bus = arguments.bus.bus.clone();
    let server = Arc::new(Server::new(address.port(), bus, feed, shelf)?);
    announce(&server, address.port(), output)?;
    std::thread::scope(|threads| {
        if server.shelf.is_none() {
            threads.spawn(|| {
                observe(
                    &server.bus,
                    &server.feed,
                    reported.as_ref(),
                    interrupt.flag(),
                )
            });
        }
        runtime.block_on(serve(Arc::clone(&server), listener, interrupt, output))
    })
}

pub(crate) fn runtime() -> anyhow::Result<Runtime> {
    let mut builder = tokio::runtime::Builder::new_current_thread();
    let runtime = builder.enable_io().enable_time().build();
    runtime.context("could not start the server")
}

pub(crate) async fn listen(port: u16) -> anyhow::Result<TcpListener> {
    let bound = TcpListener::bind(("127.0.0.1", port)).await;
    bound.with_context(|| port_taken(port))
}

fn port_taken(port: u16) -> String {
    format!(
        "could not listen on port {port} of this machine; select another one with --port, or 0 for \
         any"
    )
}

fn announce(server: &Server, port: u16, output: &mut Output) -> anyhow::Result<()> {
    // The token follows the #, so browsers do not send it in requests.
    let url = format!("http://127.0.0.1:{port}/#{}", server.guard.token());
    if output.is_json() {
        return output.json(&json!({ "url": url, "port": port, "token": server.guard.token() }));
    }
    output.line(format_args!(
        "open {url}\nwithout the part after #, the page is read-only and cannot stop the robot; \
         Ctrl-C ends the server"
    ))
}

async fn serve(
    server: Arc<Server>,
    listener: TcpListener,
    interrupt: &Interrupt,
    output: &mut Output,
) -> anyhow::Result<()> {
    let listener = BoundedListener::new(listener);
    let serving = tokio::spawn(axum::serve(listener, router(Arc::clone(&server))).into_future());
    let mut pages = 0;
    while !interrupt.is_set() {
        anyhow::ensure!(
            !serving.is_finished(),
            "the server ended unexpectedly; report this"
        );
        let now = server.feed.pages();
        if output.is_json() && now != pages {
            output.json(&json!({ "pages": now }))?;
        }
        pages = now;
        tokio::time::sleep(POLL_INTERVAL).await;
    }
    Ok(())
}

fn router(server: Arc<Server>) -> Router {
    let mut router = Router::new()
        .route("/scene.json", get(scene_json))
        .route("/feed", get(feed))
        .route("/recording.json", get(recording))
        .route("/pictures/{from}/{count}", get(pictures))
        .route("/flight/{number}", get(flight))
        .route("/stop", post(stop))
        .route("/recover", post(recover));
    for asset in ASSETS {
        let kind = HeaderValue::from_static(asset.kind);
        let answer = move || async move { ([(header::CONTENT_TYPE, kind)], asset.text) };
        router = router.route(asset.path, get(answer));
    }
    router
        .layer(middleware::from_fn_with_state(Arc::clone(&server), admit))
        .with_state(server)
}

/// Rejects requests from other pages; adds security headers.
async fn admit(State(server): State<Arc<Server>>, request: Request, next: Next) -> Response {
    if !server.guard.admits(request.headers()) {
        return (
            StatusCode::FORBIDDEN,
            "request rejected: this server answers only its own pages",
        )
            .into_response();
    }
    let mut response = next.run(request).await;
    let headers = response.headers_mut();
    headers.insert(
        header::CONTENT_SECURITY_POLICY,
        HeaderValue::from_static(POLICY),
    );
    headers.insert(
        header::X_CONTENT_TYPE_OPTIONS,
        HeaderValue::from_static("nosniff"),
    );
    headers.insert(
        header::REFERRER_POLICY,
        HeaderValue::from_static("no-referrer"),
    );
    headers.insert(header::CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

fn as_json(text: String) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], text).into_response()
}

async fn scene_json(State(server): State<Arc<Server>>) -> Response {
    let mut scene = match &server.shelf {
        Some(shelf) => shelf.scene.clone(),
        None => server.feed.history().scene.clone(),
    };
    scene["recording"] = server.shelf.is_some().into();
    scene["bus"] = server.bus.as_str().into();
    as_json(scene.to_string())
}

async fn feed(State(server): State<Arc<Server>>, upgrade: WebSocketUpgrade) -> Response {
    // The place is taken here, so that pages that open at once are counted.
    match Arc::clone(&server.places).try_acquire_owned() {
        Ok(place) => upgrade.on_upgrade(move |socket| send_messages(socket, server, place)),
        Err(_) => (
            StatusCode::SERVICE_UNAVAILABLE,
            "too many open pages: the limit is 16; close one",
        )
            .into_response(),
    }
}

/// Sends all messages to one page until it closes or takes nothing. A page that lags too far starts
/// over. Pings find a page that has gone while there are no messages.
async fn send_messages(mut socket: WebSocket, server: Arc<Server>, _place: OwnedSemaphorePermit) {
    loop {
        let (past, mut messages) = server.feed.subscribe();
        let mut next = Message::Text(past);
        loop {
            let sent = timeout(SEND_TIMEOUT, socket.send(next)).await;
            if !matches!(sent, Ok(Ok(()))) {
                return;
            }
            next = match timeout(PING_INTERVAL, message_or_end(&mut messages, &mut socket)).await {
                Ok(Ok(message)) => Message::Text(message),
                Ok(Err(RecvError::Lagged(_))) => break,
                Ok(Err(RecvError::Closed)) => return,
                Err(_) => Message::Ping(Bytes::new()),
            };
        }
    }
}

/// Returns the next message, or `Closed` when the page has closed. Ignores what the page sends.
async fn message_or_end(
    messages: &mut Receiver<Utf8Bytes>,
    socket: &mut WebSocket,
) -> Result<Utf8Bytes, RecvError> {
    let mut message = pin!(messages.recv());
    let mut closed = pin!(async { while let Some(Ok(_)) = socket.recv().await {} });
    poll_fn(|context| {
        if closed.as_mut().poll(context).is_ready() {
            return Poll::Ready(Err(RecvError::Closed));
        }
        message.as_mut().poll(context)
    })
    .await
}

async fn recording(State(server): State<Arc<Server>>) -> Response {
    match &server.shelf {
        Some(shelf) => as_json(shelf.to_json().to_string()),
        None => (
            StatusCode::NOT_FOUND,
            "not available: this server shows a running daemon",
        )
            .into_response(),
    }
}

async fn pictures(
    State(server): State<Arc<Server>>,
    Path((from, count)): Path<(usize, usize)>,
) -> Response {
    match &server.shelf {
        Some(shelf) => as_json(shelf.pictures(from, count.min(PICTURES_MAX))),
        None => (
            StatusCode::NOT_FOUND,
            "not available: this server shows a running daemon",
        )
            .into_response(),
    }
}

async fn flight(State(server): State<Arc<Server>>, Path(number): Path<u64>) -> Response {
    let found = match &server.shelf {
        Some(shelf) => shelf.faults.flight(number),
        None => server.feed.history().faults.flight(number),
    };
    match found {
        Some(flight) => as_json(flight.to_string()),
        None => (StatusCode::NOT_FOUND, "this fault is no longer stored").into_response(),
    }
}

async fn stop(State(server): State<Arc<Server>>, headers: HeaderMap) -> Response {
    act(server, &headers, control::stop).await
}

async fn recover(State(server): State<Arc<Server>>, headers: HeaderMap) -> Response {
    act(server, &headers, control::recover).await
}

async fn act(
    server: Arc<Server>,
    headers: &HeaderMap,
    act: fn(&BusName) -> anyhow::Result<()>,
) -> Response {
    if !server.guard.trusts(headers) {
        return (
            StatusCode::FORBIDDEN,
            "request rejected: no valid token; open the page by the address that the server printed",
        )
            .into_response();
    }
    if server.shelf.is_some() {
        return (
            StatusCode::CONFLICT,
            "not possible: this server shows a recording",
        )
            .into_response();
    }
    let done = tokio::task::spawn_blocking(move || act(&server.bus)).await;
    match done {
        Ok(Ok(())) => (StatusCode::OK, "done").into_response(),
        Ok(Err(error)) => (StatusCode::BAD_GATEWAY, format!("{error:#}")).into_response(),
        Err(error) => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()).into_response(),
    }
}
