//! The report as a lab engineer meets it: opened by a double click, zoomed with the mouse.

use browser::{Page, Setting};
use host_sim::metrics::summarise;
use host_sim::report::{self, Folder, csv, recording};
use host_sim::simulate::{Program, Run};
use host_sim::trace::Trace;
use model_core::units::Pressure;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use tempfile::TempDir;

/// A simulated run, made once.
static RUN: LazyLock<(Run, Trace)> = LazyLock::new(|| {
    let run = Run::new(Program::Setpoints([60, 30, 60].map(Pressure::from_kpa)), 1);
    let trace = run.simulate(|_, _| {}).expect("taken");
    (run, trace)
});

fn report_of_run() -> (TempDir, PathBuf) {
    let (run, trace) = &*RUN;
    let place = tempfile::tempdir().expect("a folder");
    let folder = Folder::prepare(place.path()).expect("writable");
    let files = report::write(&folder, trace, &summarise(trace), &run.parameters).expect("written");
    (place, files[0].clone())
}

fn opened(file: &Path, setting: Setting) -> Page {
    let page = Page::open(file, setting).expect("opens");
    page.settle().expect("draws");
    page
}

/// Of each plot's canvas, pixels that are not blank.
fn drawn_pixels(page: &Page) -> Vec<u32> {
    let count = "[...document.querySelectorAll('.chart canvas')].map((canvas) => {
        const { data } = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
        let drawn = 0;
        for (let i = 3; i < data.length; i += 4) drawn += data[i] > 0;
        return drawn;
    })";
    page.evaluate(count).expect("pixels")
}

/// Pixels of a plot that have one of the page's colours, nearly.
fn pixels_of(page: &Page, chart: u32, colour: &str) -> u32 {
    let count = format!(
        "(() => {{
            const canvas = report.charts[{chart}].ctx.canvas, probe = document.createElement('canvas').getContext('2d');
            probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--{colour}').trim();
            probe.fillRect(0, 0, 1, 1);
            const want = probe.getImageData(0, 0, 1, 1).data;
            const {{ data }} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
            let found = 0;
            for (let i = 0; i < data.length; i += 4) {{
                found += data[i + 3] > 200 && [0, 1, 2].every((k) => Math.abs(data[i + k] - want[k]) < 12);
            }}
            return found;
        }})()"
    );
    page.evaluate(&count).expect("pixels")
}

/// Each plot's stretch of time, s.
fn stretches(page: &Page) -> Vec<[f64; 2]> {
    page.evaluate("report.charts.map((chart) => [chart.scales.x.min, chart.scales.x.max])").expect("stretches")
}

/// A place in a plot, by shares of its width and height, in the window.
fn place(page: &Page, chart: u32, (x, y): (f64, f64)) -> (f64, f64) {
    let find = format!(
        "(() => {{
            const over = report.charts[{chart}].over;
            over.scrollIntoView({{ block: 'center', behavior: 'instant' }});
            const box = over.getBoundingClientRect();
            return [box.left + {x} * box.width, box.top + {y} * box.height];
        }})()"
    );
    page.evaluate(&find).expect("a place")
}

fn near(a: f64, b: f64, within: f64) -> bool {
    (a - b).abs() <= within
}

#[test]
fn the_plots_are_drawn_zoom_by_drag_and_reset_by_double_click() {
    let (_place, file) = report_of_run();
    let page = opened(&file, Setting::default());
    let drawn = drawn_pixels(&page);
    assert_eq!(drawn.len(), 5, "three chambers, pump and valves, bend");
    assert!(drawn.iter().all(|&pixels| pixels > 2000), "{drawn:?}");
    for (chart, colour) in
        [(0, "proximal"), (1, "middle"), (2, "distal"), (3, "ink"), (3, "dump"), (4, "distal"), (4, "ink")]
    {
        let pixels = pixels_of(&page, chart, colour);
        assert!(pixels > 100, "plot {chart} has {pixels} pixels of {colour}");
    }

    let [start, end] = stretches(&page)[0];
    let last = f64::from(RUN.1.samples.last().expect("samples").time_ms) / 1000.0;
    assert!(start.abs() < 1e-9 && near(end, last, 1e-9), "{start} {end} {last}");
    // From a quarter to half of the width.
    page.drag(place(&page, 0, (0.25, 0.5)), place(&page, 0, (0.5, 0.5))).expect("drags");
    let tolerance = (end - start) * 0.01;
    for [from, to] in stretches(&page) {
        assert!(near(from, start + 0.25 * (end - start), tolerance), "{from}");
        assert!(near(to, start + 0.5 * (end - start), tolerance), "{to}");
    }
    assert!(drawn_pixels(&page).iter().all(|&pixels| pixels > 2000));
    // Deeper, in another plot; all follow.
    page.drag(place(&page, 4, (0.4, 0.5)), place(&page, 4, (0.6, 0.5))).expect("drags");
    for [from, to] in stretches(&page) {
        assert!(near(to - from, 0.05 * (end - start), tolerance), "{from} {to}");
    }
    page.double_click(place(&page, 1, (0.5, 0.5))).expect("clicks");
    for [from, to] in stretches(&page) {
        assert!(near(from, start, 1e-9) && near(to, end, 1e-9), "{from} {to}");
    }
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn the_cursor_is_at_the_same_time_in_all_plots_and_moves_the_finger() {
    let (_place, file) = report_of_run();
    let page = opened(&file, Setting::default());
    let still: String = page.evaluate("document.getElementById('live').innerHTML").expect("a finger");
    page.point(place(&page, 0, (0.5, 0.5))).expect("points");
    let times: Vec<f64> =
        page.evaluate("report.charts.map((chart) => chart.posToVal(chart.cursor.left, 'x'))").expect("times");
    let [start, end] = stretches(&page)[0];
    assert!(times.iter().all(|&time| near(time, f64::midpoint(start, end), (end - start) * 0.01)), "{times:?}");
    let moved: String = page.evaluate("document.getElementById('live').innerHTML").expect("a finger");
    assert_ne!(still, moved);
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn a_recording_with_a_cut_last_line_opens() {
    let mut bytes = csv::table(&RUN.1).expect("written").into_bytes();
    bytes.truncate(bytes.len() * 2 / 3);
    assert_ne!(bytes.last(), Some(&b'\n'), "the cut is within a line");
    let place = tempfile::tempdir().expect("a folder");
    let cut = place.path().join("cut.csv");
    fs::write(&cut, &bytes).expect("written");
    let folder = Folder::prepare(&place.path().join("report")).expect("writable");
    let files = recording::open(&cut).expect("a recording").write(&folder).expect("written");
    let page = opened(&files[0], Setting::default());
    assert!(drawn_pixels(&page).iter().all(|&pixels| pixels > 2000));
    let notes: String = page.evaluate("document.querySelector('.notes').textContent").expect("notes");
    assert!(notes.contains("cut"), "{notes}");
    let [_, end] = stretches(&page)[0];
    let whole = f64::from(RUN.1.samples.last().expect("samples").time_ms) / 1000.0;
    assert!(end < 0.75 * whole && end > 0.5 * whole, "{end} of {whole}");
    assert_eq!(page.complaints(), Vec::<String>::new());
}

#[test]
fn light_or_dark_every_letter_and_curve_stands_out() {
    let (_place, file) = report_of_run();
    // The ratio of WCAG 2: 4.5 for text, 3 for graphics.
    let ratio = "(name, ground) => {
        const probe = document.createElement('canvas').getContext('2d', { willReadFrequently: true });
        const light = (name) => {
            probe.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
            probe.fillRect(0, 0, 1, 1);
            const [r, g, b] = [...probe.getImageData(0, 0, 1, 1).data].map((v) => v / 255)
                .map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
            return 0.2126 * r + 0.7152 * g + 0.0722 * b;
        };
        const [low, high] = [light(name), light(ground)].sort((a, b) => a - b);
        return (high + 0.05) / (low + 0.05);
    }";
    for dark in [false, true] {
        let page = opened(&file, Setting { dark, ..Setting::default() });
        let is_dark: bool = page.evaluate("matchMedia('(prefers-color-scheme: dark)').matches").expect("an answer");
        assert_eq!(is_dark, dark);
        for (colour, least) in [
            ("text", 4.5),
            ("soft", 4.5),
            ("ink", 4.5),
            ("estimate", 3.0),
            ("setpoint", 3.0),
            ("sensor", 3.0),
            ("dump", 3.0),
            ("proximal", 3.0),
            ("middle", 3.0),
            ("distal", 3.0),
        ] {
            let found: f64 = page.evaluate(&format!("({ratio})('{colour}', 'page')")).expect("a ratio");
            assert!(found >= least, "dark {dark}: {colour} has a contrast of {found:.2}");
        }
        // A picture has colours of its own: turned over on a dark page, and they keep their hue.
        let turned: bool = page
            .evaluate("getComputedStyle(document.querySelector('.picture svg')).filter != 'none'")
            .expect("a style");
        assert_eq!(turned, dark);
        // And it is these that the plots are drawn with.
        assert!(pixels_of(&page, 0, "proximal") > 100 && pixels_of(&page, 4, "distal") > 100);
        assert_eq!(page.complaints(), Vec::<String>::new());
    }
}

#[test]
fn without_scripts_there_are_pictures() {
    let (_place, file) = report_of_run();
    let page = opened_without_scripts(&file);
    let shown = "[...document.querySelectorAll('noscript .picture svg')].filter((svg) => svg.getBoundingClientRect().height > 100).length";
    assert_eq!(page.evaluate::<u32>(shown).expect("a count"), 3);
    assert!(page.evaluate::<bool>("document.getElementById('scripted').hidden").expect("an answer"));
}

fn opened_without_scripts(file: &Path) -> Page {
    Page::open(file, Setting { scripts: false, ..Setting::default() }).expect("opens")
}
