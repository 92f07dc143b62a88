//! A headless Chromium with one page, controlled over the Chrome DevTools protocol.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use crate::{Process, TIMEOUT, wait_for};

/// Executable names of Chromium.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// Interval between polls of the page. Polling takes drawing time from the browser.
const POLL_INTERVAL: Duration = Duration::from_millis(20);
/// Maximum number of Tab presses in a search for a field.
const TAB_PRESSES_MAX: usize = 60;

/// A browser with one page.
pub struct Browser {
    socket: WebSocket<TcpStream>,
    last_request_id: u64,
    page_errors: Vec<String>,
    // dropped before its folder
    _process: Process,
    _folder: tempfile::TempDir,
}

/// Returns the path of the installed browser, if any.
#[must_use]
pub fn installed() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let mut all = NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    all.find(|program| program.is_file())
}

impl Browser {
    /// Starts the browser and opens a page.
    ///
    /// # Panics
    /// If the browser does not start.
    #[must_use]
    pub fn open(program: &std::path::Path, url: &str) -> Self {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let profile = format!("--user-data-dir={}", folder.path().display());
        let process = Process::start_program(
            program,
            &[
                "--headless=new",
                // The sandbox is not available to root in a container; the page is part of this
                // repository.
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                // No traffic other than the page.
                "--disable-background-networking",
                "--disable-component-update",
                "--no-first-run",
                "--window-size=1440,1000",
                "--remote-debugging-port=0",
                &profile,
                "about:blank",
            ],
        );
        let reported = folder.path().join("DevToolsActivePort");
        let port: u16 = wait_for("the browser to report its port", || {
            let text = std::fs::read_to_string(&reported).ok()?;
            text.lines().next()?.parse().ok()
        });
        let address = wait_for("the browser's page", || page_of(port));
        let stream = connected(port).expect("the browser accepts connections");
        let (socket, _) = tungstenite::client(&address, stream).expect("a WebSocket");
        let mut browser = Self {
            socket,
            last_request_id: 0,
            page_errors: Vec::new(),
            _process: process,
            _folder: folder,
        };
        for domain in ["Page", "Runtime", "Log"] {
            browser.request(&format!("{domain}.enable"), json!({}));
        }
        browser.navigate(url);
        browser
    }

    /// Navigates to a page.
    pub fn navigate(&mut self, url: &str) {
        self.request("Page.navigate", json!({ "url": url }));
    }

    /// Sends a DevTools request and returns its result.
    ///
    /// # Panics
    /// If the browser returns an error or does not reply in time.
    pub fn request(&mut self, method: &str, parameters: Value) -> Value {
        self.last_request_id += 1;
        let request = json!({ "id": self.last_request_id, "method": method, "params": parameters });
        let sent = self.socket.send(Message::text(request.to_string()));
        sent.unwrap_or_else(|error| panic!("could not send {method} to the browser: {error}"));
        let end = Instant::now() + TIMEOUT;
        loop {
            let reported = self.read(method, end);
            if reported["id"] == self.last_request_id {
                assert!(reported["error"].is_null(), "{method}: {reported}");
                return reported["result"].clone();
            }
            self.record_error(&reported);
        }
    }

    /// Reads the next message of the browser, until `end`. Events do not extend the deadline.
    fn read(&mut self, method: &str, end: Instant) -> Value {
        let left = end.saturating_duration_since(Instant::now());
        assert!(
            !left.is_zero(),
            "timed out waiting for the browser's reply to {method}"
        );
        let bounded = self.socket.get_ref().set_read_timeout(Some(left));
        bounded.expect("a non-zero duration");
        let message = self.socket.read().unwrap_or_else(|error| {
            panic!("timed out waiting for the browser's reply to {method}: {error}")
        });
        let text = message.to_text().unwrap_or_default();
        serde_json::from_str(text).unwrap_or_default()
    }

    fn record_error(&mut self, event: &Value) {
        let is_error = event["params"]["entry"]["level"] == "error";
        if event["method"] == "Runtime.exceptionThrown"
            || (event["method"] == "Log.entryAdded" && is_error)
        {
            self.page_errors.push(event["params"].to_string());
        }
    }

    /// Returns the script errors and failed requests of the page so far.
    pub fn page_errors(&mut self) -> &[String] {
        // Pending events arrive before the reply to this request.
        self.value("0");
        &self.page_errors
    }

    /// Evaluates an expression in the page and returns its value; awaits a promise.
    ///
    /// # Panics
    /// If the expression throws.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let result = self.request("Runtime.evaluate", asked);
        assert!(
            result["exceptionDetails"].is_null(),
            "{expression}: {result}"
        );
        result["result"]["value"].clone()
    }

    /// Returns the text of an element, empty if the element does not exist.
    pub fn text(&mut self, id: &str) -> String {
        let value = self.value(&format!(
            "document.getElementById({id:?})?.textContent ?? ''"
        ));
        value.as_str().unwrap_or_default().to_owned()
    }

    /// Waits until `accept` returns a value for the text of an element.
    ///
    /// # Panics
    /// On timeout, with the awaited condition and the actual text.
    pub fn wait_text<T>(
        &mut self,
        what: &str,
        id: &str,
        mut accept: impl FnMut(&str) -> Option<T>,
    ) -> T {
        let end = Instant::now() + TIMEOUT;
        loop {
            let text = self.text(id);
            if let Some(accepted) = accept(&text) {
                return accepted;
            }
            assert!(
                Instant::now() < end,
                "timed out waiting for {what}: the text of #{id} is {text:?}"
            );
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Waits until the text of an element contains `part`.
    pub fn wait_contains(&mut self, id: &str, part: &str) {
        self.wait_text(&format!("{part:?} in #{id}"), id, |text| {
            text.contains(part).then_some(())
        });
    }

    /// Waits until an expression is true.
    ///
    /// # Panics
    /// On timeout.
    pub fn wait_true(&mut self, what: &str, expression: &str) {
        let end = Instant::now() + TIMEOUT;
        while self.value(expression) != Value::Bool(true) {
            assert!(
                Instant::now() < end,
                "timed out waiting for {what}: {expression}"
            );
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Presses a key on the focused element.
    pub fn press(&mut self, key: &str) {
        let (code, text) = match key {
            "Tab" => (9, ""),
            "Enter" => (13, "\r"),
            "End" => (35, ""),
            "ArrowRight" => (39, ""),
            _ => panic!("no key code is defined for {key}"),
        };
        let kinds: &[&str] = match text {
            "" => &["rawKeyDown", "keyUp"],
            _ => &["rawKeyDown", "char", "keyUp"],
        };
        for kind in kinds {
            let text = if *kind == "char" { text } else { "" };
            let event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "text": text });
            self.request("Input.dispatchKeyEvent", event);
        }
    }

    /// Presses Tab until an element has the focus.
    ///
    /// # Panics
    /// If the element is not reachable with Tab.
    pub fn tab_to(&mut self, selector: &str) {
        let is_there = format!("document.activeElement.matches({selector:?})");
        for _ in 0..TAB_PRESSES_MAX {
            if self.value(&is_there) == Value::Bool(true) {
                return;
            }
            self.press("Tab");
        }
        panic!("{selector} is not reachable with Tab");
    }

    /// Sets the colour scheme, "light" or "dark".
    pub fn theme(&mut self, theme: &str) {
        let feature = json!({ "name": "prefers-color-scheme", "value": theme });
        self.request(
            "Emulation.setEmulatedMedia",
            json!({ "features": [feature] }),
        );
    }

    /// Returns a screenshot as base64 PNG.
    pub fn screenshot(&mut self) -> String {
        let shot = self.request("Page.captureScreenshot", json!({ "format": "png" }));
        shot["data"].as_str().unwrap_or_default().to_owned()
    }
}

/// Returns the WebSocket address of the browser's page.
fn page_of(port: u16) -> Option<String> {
    let (_, listed) = request(port, "GET", "/json/list", &[])?;
    let pages: Value = serde_json::from_str(&listed).ok()?;
    let page = pages
        .as_array()?
        .iter()
        .find(|page| page["type"] == "page")?;
    Some(page["webSocketDebuggerUrl"].as_str()?.to_owned())
}

/// Opens a connection with read and write timeouts.
fn connected(port: u16) -> std::io::Result<TcpStream> {
    let stream = TcpStream::connect(("127.0.0.1", port))?;
    stream.set_read_timeout(Some(TIMEOUT))?;
    stream.set_write_timeout(Some(TIMEOUT))?;
    Ok(stream)
}

/// Sends one HTTP request; returns status and body, `None` without a response.
#[must_use]
pub fn request(
    port: u16,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
) -> Option<(u16, String)> {
    let mut stream = connected(port).ok()?;
    let own = headers.iter().any(|(name, _)| *name == "Host");
    let mut text =
        format!("{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: 0\r\n");
    if !own {
        text += &format!("Host: 127.0.0.1:{port}\r\n");
    }
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    write!(stream, "{text}\r\n").ok()?;
    read_response(stream)
}

/// Reads the response up to its content length, because the browser keeps the connection open.
fn read_response(stream: TcpStream) -> Option<(u16, String)> {
    let mut reader = BufReader::new(stream);
    let mut line = String::new();
    reader.read_line(&mut line).ok()?;
    let status = line.split_whitespace().nth(1)?.parse().ok()?;
    let mut length = 0;
    loop {
        line.clear();
        reader.read_line(&mut line).ok()?;
        match line.trim_end().split_once(':') {
            Some((name, value)) if name.eq_ignore_ascii_case("content-length") => {
                length = value.trim().parse().ok()?;
            }
            Some(_) => {}
            None => break,
        }
    }
    let mut body = String::new();
    reader.take(length).read_to_string(&mut body).ok()?;
    Some((status, body))
}
