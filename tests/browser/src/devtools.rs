//! A Chromium of one's own, and the part of its `DevTools` protocol (<https://chromedevtools.github.io/devtools-protocol>) that a page's
//! test needs: commands with their answers, and what happens in between.

use anyhow::{Context, Result, anyhow, bail};
use serde_json::{Value, json};
use std::collections::VecDeque;
use std::net::TcpStream;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use tungstenite::{Message, WebSocket, client};

/// A busy machine may take its time.
const PATIENCE: Duration = Duration::from_mins(2);
/// A browser that was told to close gets so long.
const FAREWELL: Duration = Duration::from_secs(5);
/// Between two looks at something that comes by itself.
const LOOK_AGAIN: Duration = Duration::from_millis(20);
/// Where Chromium is looked for when `CHROME` does not name it.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome-stable"];
/// Headless, with nothing that a browser does of itself, so that every request is the page's. Its sandbox needs a user who is not
/// root, or rights that containers do not have; the page is our own.
const ARGUMENTS: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--no-first-run",
    "--remote-debugging-port=0",
    "--disable-component-update",
    "--disable-dev-shm-usage",
    "--disable-gpu",
    "--disable-quic",
    "--hide-scrollbars",
];

/// The Chromium on this machine: what `CHROME` names, or one on the path.
fn chromium() -> Option<PathBuf> {
    let runs = |program: &PathBuf| {
        let mut version = Command::new(program);
        version.arg("--version").output().is_ok_and(|output| output.status.success())
    };
    let named = std::env::var_os("CHROME").map(PathBuf::from);
    named.into_iter().chain(NAMES.map(PathBuf::from)).find(runs)
}

/// A running Chromium, which ends with this.
struct Process {
    child: Child,
    profile: TempDir,
}

impl Process {
    fn start((width, height): (u32, u32)) -> Result<Self> {
        let program =
            chromium().context("no Chromium: install it, or name it in the variable CHROME (docs/testing.md)")?;
        let profile = tempfile::tempdir()?;
        let mut command = Command::new(&program);
        command.args(ARGUMENTS).arg(format!("--window-size={width},{height}")).arg("about:blank");
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        let child = command.spawn().with_context(|| format!("{} does not start", program.display()))?;
        Ok(Self { child, profile })
    }

    /// The address at which it listens, from the file that it leaves in its profile: a port, and a path.
    fn address(&mut self) -> Result<(u16, String)> {
        let file = self.profile.path().join("DevToolsActivePort");
        let started = Instant::now();
        while started.elapsed() < PATIENCE {
            let text = std::fs::read_to_string(&file).unwrap_or_default();
            if let Some((port, path)) = text.split_once('\n')
                && let Ok(port) = port.parse()
            {
                return Ok((port, path.trim().to_owned()));
            }
            if let Some(status) = self.child.try_wait()? {
                bail!("Chromium ended at once: {status}");
            }
            std::thread::sleep(LOOK_AGAIN);
        }
        bail!("Chromium says not within {PATIENCE:?} where it listens")
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        let told = Instant::now();
        while told.elapsed() < FAREWELL {
            if matches!(self.child.try_wait(), Ok(Some(_)) | Err(_)) {
                return;
            }
            std::thread::sleep(LOOK_AGAIN);
        }
        // It may have ended meanwhile: then there is nothing to do either.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A tab of a Chromium that has no other.
pub struct Tab {
    socket: WebSocket<TcpStream>,
    session: String,
    commands: u64,
    events: VecDeque<(String, Value)>,
    _process: Process,
}

impl Tab {
    /// An empty page in a window of this size, pixels.
    ///
    /// # Errors
    /// When there is no Chromium, or it does not start.
    pub fn open(window: (u32, u32)) -> Result<Self> {
        let mut process = Process::start(window)?;
        let (port, path) = process.address()?;
        let stream = TcpStream::connect(("127.0.0.1", port)).context("Chromium does not listen")?;
        stream.set_read_timeout(Some(PATIENCE))?;
        let (socket, _) =
            client(format!("ws://127.0.0.1:{port}{path}"), stream).map_err(|why| anyhow!("no DevTools: {why}"))?;
        let (session, events) = (String::new(), VecDeque::new());
        let mut tab = Self { socket, session, commands: 0, events, _process: process };
        let created = tab.command("Target.createTarget", &json!({ "url": "about:blank" }))?;
        let target = json!({ "targetId": created["targetId"], "flatten": true });
        let attached = tab.command("Target.attachToTarget", &target)?;
        attached["sessionId"].as_str().context("a session")?.clone_into(&mut tab.session);
        Ok(tab)
    }

    /// Gives a command, and waits for its answer.
    ///
    /// # Errors
    /// When it is refused, or there is no answer.
    pub fn command(&mut self, method: &str, parameters: &Value) -> Result<Value> {
        self.commands += 1;
        let id = self.commands;
        let mut command = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            command["sessionId"] = json!(self.session);
        }
        self.socket.send(Message::text(command.to_string())).with_context(|| method.to_owned())?;
        loop {
            let mut answer = self.next().with_context(|| format!("no answer to {method}"))?;
            if answer["id"] != json!(id) {
                continue;
            }
            if !answer["error"].is_null() {
                bail!("{method}: {}", answer["error"]);
            }
            return Ok(answer["result"].take());
        }
    }

    /// Waits for an event; those before it are kept.
    ///
    /// # Errors
    /// When it does not come.
    pub fn wait_for(&mut self, event: &str) -> Result<()> {
        while !self.events.iter().any(|(name, _)| name == event) {
            self.next().with_context(|| format!("no {event}"))?;
        }
        Ok(())
    }

    /// What has happened since this was asked for last: events and their parameters.
    pub fn events(&mut self) -> impl Iterator<Item = (String, Value)> + '_ {
        self.events.drain(..)
    }

    /// The next message; an event is kept too.
    fn next(&mut self) -> Result<Value> {
        loop {
            if let Message::Text(text) = self.socket.read()? {
                let mut message: Value = serde_json::from_str(text.as_str())?;
                if let Some(name) = message["method"].as_str().map(str::to_owned) {
                    self.events.push_back((name, message["params"].take()));
                }
                return Ok(message);
            }
        }
    }
}

impl Drop for Tab {
    fn drop(&mut self) {
        self.session.clear();
        // One that hears no more is ended by the process.
        let _ = self.socket.send(Message::text(json!({ "id": 0, "method": "Browser.close" }).to_string()));
    }
}
