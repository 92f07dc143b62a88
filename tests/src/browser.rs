//! A real browser without a screen, spoken to by its debugging protocol (Chrome DevTools).

use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

use crate::{PATIENCE, Process, wait_for};

/// Names under which Chromium is installed.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// A browser with one page.
pub struct Browser {
    _process: Process,
    _folder: tempfile::TempDir,
    socket: WebSocket<TcpStream>,
    asked: u64,
    /// Errors that the page's scripts threw, and requests that failed.
    pub troubles: Vec<String>,
}

/// The browser of this machine; `None`, with a word about it, where there is none.
#[must_use]
#[expect(clippy::print_stderr, reason = "a test that cannot run here says so")]
pub fn installed() -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let all = NAMES
        .iter()
        .flat_map(|name| folders.iter().map(move |f| f.join(name)));
    let found = all.into_iter().find(|program| program.is_file());
    if found.is_none() {
        eprintln!(
            "SKIPPED: no browser ({}) is installed: `apt-get install chromium`",
            NAMES.join(", ")
        );
    }
    found
}

impl Browser {
    /// Starts it with this page.
    ///
    /// # Panics
    /// If it cannot be started.
    #[must_use]
    pub fn open(program: &Path, url: &str) -> Self {
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
                "--no-first-run",
                "--window-size=1440,1000",
                "--remote-debugging-port=0",
                &profile,
                url,
            ],
        );
        let told = folder.path().join("DevToolsActivePort");
        let port: u16 = wait_for("the browser", || {
            let text = std::fs::read_to_string(&told).ok()?;
            text.lines().next()?.parse().ok()
        });
        let address = wait_for("the browser's page", || page_of(port));
        let stream = TcpStream::connect(("127.0.0.1", port)).expect("connected");
        // A browser that hangs fails the test instead of hanging it.
        stream.set_read_timeout(Some(PATIENCE)).expect("bounded");
        let (socket, _) = tungstenite::client(&address, stream).expect("a WebSocket");
        let mut browser = Self {
            _process: process,
            _folder: folder,
            socket,
            asked: 0,
            troubles: Vec::new(),
        };
        for domain in ["Page", "Runtime", "Log"] {
            browser.ask(&format!("{domain}.enable"), json!({}));
        }
        browser
    }

    /// Asks and waits for the answer.
    ///
    /// # Panics
    /// If the browser refuses.
    pub fn ask(&mut self, method: &str, parameters: Value) -> Value {
        self.asked += 1;
        let request = json!({ "id": self.asked, "method": method, "params": parameters });
        self.socket
            .send(Message::text(request.to_string()))
            .expect("sent");
        loop {
            let message = self.socket.read().expect("an answer");
            let Ok(text) = message.to_text() else {
                continue;
            };
            let answer: Value = serde_json::from_str(text).unwrap_or_default();
            if answer["id"] == self.asked {
                assert!(answer["error"].is_null(), "{method}: {answer}");
                return answer["result"].clone();
            }
            self.note(&answer);
        }
    }

    fn note(&mut self, event: &Value) {
        let is_error = event["params"]["entry"]["level"] == "error";
        if event["method"] == "Runtime.exceptionThrown"
            || (event["method"] == "Log.entryAdded" && is_error)
        {
            self.troubles.push(event["params"].to_string());
        }
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

    /// Presses a key on whatever has the focus.
    pub fn press(&mut self, key: &str, code: u32) {
        for kind in ["rawKeyDown", "char", "keyUp"] {
            let text = if kind == "char" && key == "Enter" {
                "\r"
            } else {
                ""
            };
            if kind == "char" && text.is_empty() {
                continue;
            }
            let event = json!({ "type": kind, "key": key, "code": key, "windowsVirtualKeyCode": code, "text": text });
            self.ask("Input.dispatchKeyEvent", event);
        }
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
    let listed = get(port, "/json/list", &[])?;
    let pages: Value = serde_json::from_str(&listed.1).ok()?;
    let page = pages.as_array()?.iter().find(|page| {
        page["type"] == "page"
            && page["url"]
                .as_str()
                .is_some_and(|url| url.starts_with("http"))
    })?;
    Some(page["webSocketDebuggerUrl"].as_str()?.to_owned())
}

/// One request over HTTP: status and body.
#[must_use]
pub fn get(port: u16, path: &str, headers: &[(&str, &str)]) -> Option<(u16, String)> {
    request(port, "GET", path, headers)
}

/// One request over HTTP: status and body.
#[must_use]
pub fn request(
    port: u16,
    method: &str,
    path: &str,
    headers: &[(&str, &str)],
) -> Option<(u16, String)> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
    let host = format!("127.0.0.1:{port}");
    let own = headers.iter().any(|(name, _)| *name == "Host");
    let mut text =
        format!("{method} {path} HTTP/1.1\r\nConnection: close\r\nContent-Length: 0\r\n");
    if !own {
        text += &format!("Host: {host}\r\n");
    }
    for (name, value) in headers {
        text += &format!("{name}: {value}\r\n");
    }
    write!(stream, "{text}\r\n").ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    let (head, body) = answer.split_once("\r\n\r\n")?;
    let status = head.split_whitespace().nth(1)?.parse().ok()?;
    Some((status, body.to_owned()))
}
