//! A page opened from the disk in a headless Chromium, used with the mouse, with an ear for all that goes wrong in it.
//!
//! Chromium is looked for on the path; the variable `CHROME` names another. `cargo xtask browser` installs it where it can.
//!
//! ```no_run
//! let page = browser::Page::open("target/finger/report.html".as_ref(), browser::Setting::default())?;
//! page.drag((300.0, 300.0), (500.0, 300.0))?;
//! let from_s: f64 = page.evaluate("report.charts[0].scales.x.min")?;
//! assert!(page.complaints().is_empty());
//! # anyhow::Ok(())
//! ```

use anyhow::{Context, Result, anyhow};
use headless_chrome::browser::default_executable;
use headless_chrome::browser::tab::Tab;
use headless_chrome::protocol::cdp::types::Event;
use headless_chrome::protocol::cdp::{Emulation, Input, Log, Network, Page as PageDomain, Runtime};
use headless_chrome::{Browser, LaunchOptions};
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::ffi::OsStr;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tempfile::TempDir;

/// The window, pixels.
const WINDOW: (u32, u32) = (1200, 1000);
/// A busy machine may take its time.
const PATIENCE: Duration = Duration::from_mins(2);
/// Nothing that a browser does of itself, so that every request is the page's.
const ARGUMENTS: [&str; 4] = ["--disable-quic", "--disable-component-update", "--disable-gpu", "--hide-scrollbars"];

/// How a page is shown.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The user prefers dark pages.
    pub dark: bool,
    /// Scripts run.
    pub scripts: bool,
}

impl Default for Setting {
    fn default() -> Self {
        Self { dark: false, scripts: true }
    }
}

/// What was heard: console errors, exceptions, and requests for anything but the page.
type Heard = Arc<Mutex<Vec<String>>>;

/// An open page.
pub struct Page {
    tab: Arc<Tab>,
    heard: Heard,
    _browser: Browser,
    // Removed after the browser has ended.
    _profile: TempDir,
}

impl Page {
    /// Opens a file.
    ///
    /// # Errors
    /// When there is no browser, or it does not open the file.
    pub fn open(file: &Path, setting: Setting) -> Result<Self> {
        let file = file.canonicalize().with_context(|| format!("no page {}", file.display()))?;
        let program =
            default_executable().map_err(|why| anyhow!("no Chromium ({why}): install it, or name it in CHROME"))?;
        let profile = tempfile::tempdir()?;
        let options = LaunchOptions::default_builder()
            .path(Some(program))
            // Its sandbox needs a user who is not root, or rights that containers do not have; the page is our own.
            .sandbox(false)
            .window_size(Some(WINDOW))
            .user_data_dir(Some(profile.path().to_path_buf()))
            .idle_browser_timeout(PATIENCE)
            .args(ARGUMENTS.iter().map(OsStr::new).collect())
            .build()?;
        let browser = Browser::new(options).context("Chromium does not start")?;
        let tab = browser.new_tab()?;
        tab.set_default_timeout(PATIENCE);
        let url = format!("file://{}", file.display());
        let heard = Heard::default();
        tab.add_event_listener(Arc::new(listener(url.clone(), Arc::clone(&heard))))?;
        tab.enable_runtime()?.enable_log()?;
        tab.call_method(serde_json::from_value::<Network::Enable>(json!({}))?)?;
        let scheme = if setting.dark { "dark" } else { "light" };
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        tab.call_method(serde_json::from_value::<Emulation::SetEmulatedMedia>(media)?)?;
        tab.call_method(Emulation::SetScriptExecutionDisabled { value: !setting.scripts })?;
        tab.navigate_to(&url)?.wait_until_navigated()?;
        Ok(Self { tab, heard, _browser: browser, _profile: profile })
    }

    /// Value of a JavaScript expression; a promise's once it is there.
    ///
    /// # Errors
    /// When it throws, or is not of this type.
    pub fn evaluate<T: DeserializeOwned>(&self, expression: &str) -> Result<T> {
        let wrapped = format!("Promise.resolve({expression}).then((value) => JSON.stringify(value))");
        let object = self.tab.evaluate(&wrapped, true)?;
        let text = object.value.as_ref().and_then(Value::as_str);
        let text = text.ok_or_else(|| anyhow!("{expression}: {}", object.description.unwrap_or_default()))?;
        serde_json::from_str(text).with_context(|| format!("{expression} is {text}"))
    }

    /// Waits until the page has drawn what it was told to.
    ///
    /// # Errors
    /// When the page does not answer.
    pub fn settle(&self) -> Result<()> {
        let frames = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(true))))";
        self.evaluate::<bool>(frames).map(drop)
    }

    /// Presses the left button at one place of the window, moves, and lets go at another, as a hand does; pixels.
    ///
    /// # Errors
    /// When the browser does not answer.
    pub fn drag(&self, from: (f64, f64), to: (f64, f64)) -> Result<()> {
        const STEPS: u32 = 8;
        self.mouse("mouseMoved", from, 0)?;
        self.mouse("mousePressed", from, 1)?;
        for step in 1..=STEPS {
            let share = f64::from(step) / f64::from(STEPS);
            let between = |a: f64, b: f64| a + (b - a) * share;
            self.mouse("mouseMoved", (between(from.0, to.0), between(from.1, to.1)), 1)?;
        }
        self.mouse("mouseReleased", to, 1)?;
        self.settle()
    }

    /// Clicks twice at a place of the window; pixels.
    ///
    /// # Errors
    /// When the browser does not answer.
    pub fn double_click(&self, at: (f64, f64)) -> Result<()> {
        self.mouse("mouseMoved", at, 0)?;
        for count in [1, 2] {
            self.mouse("mousePressed", at, count)?;
            self.mouse("mouseReleased", at, count)?;
        }
        self.settle()
    }

    /// Moves the mouse to a place of the window; pixels.
    ///
    /// # Errors
    /// When the browser does not answer.
    pub fn point(&self, at: (f64, f64)) -> Result<()> {
        self.mouse("mouseMoved", at, 0)?;
        self.settle()
    }

    /// With the left button where there are clicks, the second of which is a double click's.
    fn mouse(&self, kind: &str, (x, y): (f64, f64), clicks: u32) -> Result<()> {
        let mut event = json!({ "type": kind, "x": x, "y": y });
        if clicks > 0 {
            event["button"] = "left".into();
            event["buttons"] = 1.into();
            event["clickCount"] = clicks.into();
        }
        self.tab.call_method(serde_json::from_value::<Input::DispatchMouseEvent>(event)?)?;
        Ok(())
    }

    /// What the window shows, as a PNG.
    ///
    /// # Errors
    /// When the browser does not answer.
    pub fn picture(&self) -> Result<Vec<u8>> {
        self.tab.capture_screenshot(PageDomain::CaptureScreenshotFormatOption::Png, None, None, true)
    }

    /// Console errors, exceptions, and requests for anything but the page, in their order.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        self.heard.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

fn listener(page: String, heard: Heard) -> impl Fn(&Event) {
    move |event| {
        let complaint = match event {
            Event::RuntimeExceptionThrown(event) => Some(format!("exception: {:?}", event.params.exception_details)),
            Event::RuntimeConsoleAPICalled(event)
                if event.params.Type == Runtime::ConsoleAPICalledEventTypeOption::Error =>
            {
                Some(format!("console: {:?}", event.params.args))
            }
            Event::LogEntryAdded(event) if event.params.entry.level == Log::LogEntryLevel::Error => {
                Some(format!("log: {}", event.params.entry.text))
            }
            Event::NetworkRequestWillBeSent(event) => {
                let url = &event.params.request.url;
                (*url != page && !url.starts_with("data:")).then(|| format!("request: {url}"))
            }
            _ => None,
        };
        if let Some(complaint) = complaint {
            heard.lock().unwrap_or_else(PoisonError::into_inner).push(complaint);
        }
    }
}
