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

mod devtools;

use anyhow::{Context, Result, bail};
use devtools::Tab;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};
use std::cell::RefCell;
use std::path::Path;

/// The window, pixels.
const WINDOW: (u32, u32) = (1200, 1000);

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

/// An open page.
pub struct Page {
    tab: RefCell<Tab>,
    url: String,
    /// What was heard: console errors, exceptions, and requests for anything but the page.
    heard: RefCell<Vec<String>>,
}

impl Page {
    /// Opens a file.
    ///
    /// # Errors
    /// When there is no browser, or it does not open the file.
    pub fn open(file: &Path, setting: Setting) -> Result<Self> {
        let file = file.canonicalize().with_context(|| format!("no page {}", file.display()))?;
        let url = format!("file://{}", file.display());
        let mut tab = Tab::open(WINDOW)?;
        for domain in ["Page", "Runtime", "Log", "Network"] {
            tab.command(&format!("{domain}.enable"), &json!({}))?;
        }
        let scheme = if setting.dark { "dark" } else { "light" };
        let media = json!({ "features": [{ "name": "prefers-color-scheme", "value": scheme }] });
        tab.command("Emulation.setEmulatedMedia", &media)?;
        tab.command("Emulation.setScriptExecutionDisabled", &json!({ "value": !setting.scripts }))?;
        // The empty page's.
        tab.events().for_each(drop);
        let answer = tab.command("Page.navigate", &json!({ "url": url }))?;
        if let Some(why) = answer["errorText"].as_str() {
            bail!("{url}: {why}");
        }
        tab.wait_for("Page.loadEventFired")?;
        Ok(Self { tab: RefCell::new(tab), url, heard: RefCell::default() })
    }

    /// Value of a JavaScript expression; a promise's once it is there.
    ///
    /// # Errors
    /// When it throws, or is not of this type.
    pub fn evaluate<T: DeserializeOwned>(&self, expression: &str) -> Result<T> {
        let parameters = json!({ "expression": expression, "awaitPromise": true, "returnByValue": true });
        let mut answer = self.tab.borrow_mut().command("Runtime.evaluate", &parameters)?;
        if !answer["exceptionDetails"].is_null() {
            bail!("{expression}: {}", answer["exceptionDetails"]);
        }
        let value = answer["result"]["value"].take();
        serde_json::from_value(value.clone()).with_context(|| format!("{expression} is {value}"))
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
        self.tab.borrow_mut().command("Input.dispatchMouseEvent", &event).map(drop)
    }

    /// Console errors, exceptions, and requests for anything but the page, in their order.
    #[must_use]
    pub fn complaints(&self) -> Vec<String> {
        let mut heard = self.heard.borrow_mut();
        heard.extend(self.tab.borrow_mut().events().filter_map(|(event, of)| complaint(&self.url, &event, &of)));
        heard.clone()
    }
}

fn complaint(page: &str, event: &str, of: &Value) -> Option<String> {
    match event {
        "Runtime.exceptionThrown" => Some(format!("exception: {}", of["exceptionDetails"])),
        "Runtime.consoleAPICalled" if of["type"] == "error" => Some(format!("console: {}", of["args"])),
        "Log.entryAdded" if of["entry"]["level"] == "error" => Some(format!("log: {}", of["entry"]["text"])),
        "Network.requestWillBeSent" => {
            let url = of["request"]["url"].as_str().unwrap_or_default();
            (url != page && !url.starts_with("data:")).then(|| format!("request: {url}"))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A page that does all that a report must not do is heard; one that does nothing is not.
    #[test]
    fn what_goes_wrong_in_a_page_is_heard() {
        let place = tempfile::tempdir().expect("a folder");
        let heard_of = |name: &str, body: &str| {
            let file = place.path().join(name);
            std::fs::write(&file, format!("<!doctype html><title>x</title><body>{body}</body>")).expect("written");
            let page = Page::open(&file, Setting::default()).expect("opens");
            page.settle().expect("draws");
            page.complaints()
        };
        assert_eq!(heard_of("quiet.html", "<p>nothing</p>"), Vec::<String>::new());
        let wrong = "<img src='missing.png'><script>console.error('no'); throw new Error('oh');</script>";
        let heard = heard_of("wrong.html", wrong).join("\n");
        for part in ["request: file://", "missing.png", "console: ", "exception: ", "Error: oh"] {
            assert!(heard.contains(part), "{part} in {heard}");
        }
    }

    #[test]
    fn an_expression_that_throws_says_so() {
        let place = tempfile::tempdir().expect("a folder");
        let file = place.path().join("page.html");
        std::fs::write(&file, "<!doctype html><title>x</title>").expect("written");
        let page = Page::open(&file, Setting::default()).expect("opens");
        assert_eq!(page.evaluate::<Vec<u32>>("Promise.resolve([1, 2])").expect("a list"), [1, 2]);
        let error = page.evaluate::<u32>("nowhere.to_be_found").expect_err("it throws").to_string();
        assert!(error.contains("ReferenceError"), "{error}");
        assert!(Page::open(&place.path().join("none.html"), Setting::default()).is_err());
    }
}
