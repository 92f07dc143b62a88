//! A real browser without a screen, spoken to by its debugging protocol (Chrome DevTools).

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use crate::{PATIENCE, Process, wait_for};

/// Names under which Chromium is installed.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];
/// Time between two looks at the page: looking costs the browser time to draw.
const LOOK: Duration = Duration::from_millis(20);
/// Most fields that Tab may pass on the way to the one that is looked for.
const FIELDS: usize = 60;

/// A browser with one page.
pub struct Browser {
    socket: WebSocket<TcpStream>,
    asked: u64,
    troubles: Vec<String>,
    // Ends before its folder goes.
    _process: Process,
    _folder: tempfile::TempDir,
}

/// The browser of this machine, if it has one.
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
    /// Starts this browser with this page.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn open(program: &std::path::Path, url: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let profile = format!("--user-data-dir={}", folder.path().display());
        let process = Process::start_program(
            program,
            &[
                "--headless=new",
                // A container's root has no sandbox; the page is ours.
                "--no-sandbox",
                "--disable-gpu",
                "--disable-dev-shm-usage",
                // It looks for nobody but the page.
                "--disable-background-networking",
                "--disable-component-update",
                "--no-first-run",
                "--window-size=1440,1000",
                "--remote-debugging-port=0",
                &profile,
                "about:blank",
            ],
        );
        let told = folder.path().join("DevToolsActivePort");
        let port: u16 = wait_for("the browser to say its port", || {
            let text = std::fs::read_to_string(&told).ok()?;
            text.lines().next()?.parse().ok()
        });
        let address = wait_for("the browser's page", || page_of(port));
        let stream = connected(port).expect("the browser listens");
        let (socket, _) = tungstenite::client(&address, stream).expect("a WebSocket");
        let mut browser = Self {
            socket,
            asked: 0,
            troubles: Vec::new(),
            _process: process,
            _folder: folder,
        };
        for domain in ["Page", "Runtime", "Log"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser.go(url);
        browser
    }

    /// Goes to a page, as if its address had been typed.
    pub fn go(&mut self, url: &str) {
        self.ask("Page.navigate", json!({ "url": url }));
    }

    /// Asks and waits for the answer.
    ///
    /// # Panics
    /// If the browser refuses, or says nothing for too long.
    pub fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.asked += 1;
        let request = json!({ "id": self.asked, "method": method, "params": parameters });
        let sent = self.socket.send(Message::text(request.to_string()));
        sent.unwrap_or_else(|error| panic!("could not ask the browser {method}: {error}"));
        let end = Instant::now() + PATIENCE;
        loop {
            let told = self.read(method, end);
            if told["id"] == self.asked {
                assert!(told["error"].is_null(), "{method}: {told}");
                return told["result"].clone();
            }
            self.note(&told);
        }
    }

    /// The next that the browser tells. What it tells of its own accord puts off no end.
    fn read(&mut self, method: &str, end: Instant) -> Value {
        let left = end.saturating_duration_since(Instant::now());
        assert!(
            !left.is_zero(),
            "waited in vain for the browser's answer to {method}"
        );
        let bounded = self.socket.get_ref().set_read_timeout(Some(left));
        bounded.expect("a time that is not zero");
        let message = self.socket.read().unwrap_or_else(|error| {
            panic!("waited in vain for the browser's answer to {method}: {error}")
        });
        let text = message.to_text().unwrap_or_default();
        serde_json::from_str(text).unwrap_or_default()
    }

    fn note(&mut self, event: &Value) {
        let is_error = event["params"]["entry"]["level"] == "error";
        if event["method"] == "Runtime.exceptionThrown"
            || (event["method"] == "Log.entryAdded" && is_error)
        {
            self.troubles.push(event["params"].to_string());
        }
    }

    /// Errors that the page's scripts threw so far, and requests that failed.
    pub fn troubles(&mut self) -> &[String] {
        // They come before the next answer.
        self.value("0");
        &self.troubles
    }

    /// The value of an expression in the page; a promise is waited for.
    ///
    /// # Panics
    /// If it throws.
    pub fn value(&mut self, expression: &str) -> Value {
        let asked =
            json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let result = self.ask("Runtime.evaluate", asked);
        assert!(
            result["exceptionDetails"].is_null(),
            "{expression}: {result}"
        );
        result["result"]["value"].clone()
    }

    /// The text of an element, empty if there is none.
    pub fn text(&mut self, id: &str) -> String {
        let value = self.value(&format!(
            "document.getElementById({id:?})?.textContent ?? ''"
        ));
        value.as_str().unwrap_or_default().to_owned()
    }

    /// Waits until an element's text is accepted.
    ///
    /// # Panics
    /// If it is not for too long: with what was waited for, and what the element says instead.
    pub fn wait_text<T>(
        &mut self,
        what: &str,
        id: &str,
        mut accept: impl FnMut(&str) -> Option<T>,
    ) -> T {
        let end = Instant::now() + PATIENCE;
        loop {
            let text = self.text(id);
            if let Some(accepted) = accept(&text) {
                return accepted;
            }
            assert!(
                Instant::now() < end,
                "waited in vain for {what}: #{id} says {text:?}"
            );
            std::thread::sleep(LOOK);
        }
    }

    /// Waits until an element's text contains this.
    pub fn wait_part(&mut self, id: &str, part: &str) {
        self.wait_text(&format!("{part:?} in #{id}"), id, |text| {
            text.contains(part).then_some(())
        });
    }

    /// Waits until an expression is true.
    ///
    /// # Panics
    /// If it is not for too long.
    pub fn wait_true(&mut self, what: &str, expression: &str) {
        let end = Instant::now() + PATIENCE;
        while self.value(expression) != Value::Bool(true) {
            assert!(
                Instant::now() < end,
                "waited in vain for {what}: {expression}"
            );
            std::thread::sleep(LOOK);
        }
    }

    /// Presses a key on whatever has the focus.
    pub fn press(&mut self, key: &str) {
        let (code, text) = match key {
            "Tab" => (9, ""),
            "Enter" => (13, "\r"),
            "End" => (35, ""),
            "ArrowRight" => (39, ""),
            _ => panic!("{key} has no code here"),
        };
        let kinds: &[&str] = match text {
            "" => &["rawKeyDown", "keyUp"],
            _ => &["rawKeyDown", "char", "keyUp"],
        };
        for kind in kinds {
            let text = if *kind == "char" { text } else { "" };
            let event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "text": text });
            self.ask("Input.dispatchKeyEvent", event);
        }
    }

    /// Goes on with Tab until an element has the focus, as people without a mouse do.
    ///
    /// # Panics
    /// If Tab does not lead there.
    pub fn tab_to(&mut self, selector: &str) {
        let is_there = format!("document.activeElement.matches({selector:?})");
        for _ in 0..FIELDS {
            if self.value(&is_there) == Value::Bool(true) {
                return;
            }
            self.press("Tab");
        }
        panic!("Tab does not lead to {selector}");
    }

    /// Light or dark.
    pub fn theme(&mut self, theme: &str) {
        let feature = json!({ "name": "prefers-color-scheme", "value": theme });
        self.ask(
            "Emulation.setEmulatedMedia",
            json!({ "features": [feature] }),
        );
    }

    /// What the page looks like now, as PNG in base64.
    pub fn picture(&mut self) -> String {
        let shot = self.ask("Page.captureScreenshot", json!({ "format": "png" }));
        shot["data"].as_str().unwrap_or_default().to_owned()
    }
}

/// The address at which the browser's one page is spoken to.
fn page_of(port: u16) -> Option<String> {
    let (_, listed) = request(port, "GET", "/json/list", &[])?;
    let pages: Value = serde_json::from_str(&listed).ok()?;
    let page = pages
        .as_array()?
        .iter()
        .find(|page| page["type"] == "page")?;
    Some(page["webSocketDebuggerUrl"].as_str()?.to_owned())
}

/// A connection on which nothing is waited for without end.
fn connected(port: u16) -> std::io::Result<TcpStream> {
    let stream = TcpStream::connect(("127.0.0.1", port))?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    Ok(stream)
}

/// One request over HTTP: status and body; `None` if there is no answer.
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
    answer(stream)
}

/// As many bytes as the answer says that it has: the browser leaves the connection open behind them.
fn answer(stream: TcpStream) -> Option<(u16, String)> {
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
