//! The command line as its users meet it: results, and one clear error for each bad input.

use std::io::Write;
use std::process::{Command, Output, Stdio};

/// The paper's Table 2, one chamber with exoskeleton.
const TABLE_2: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/bend-table-2.csv");
/// Ten repeats drawn from known coefficients, with one misread bend.
const TEN_REPEATS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/data/bend-ten-repeats.csv");

fn host_sim(arguments: &[&str], stdin: &str) -> Output {
    let mut child = Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(arguments)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    // A program that ends before it reads is no failure of this test.
    let _ = child.stdin.take().expect("piped").write_all(stdin.as_bytes());
    child.wait_with_output().expect("ends")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn eval_answers_a_line_for_a_line_and_inverts_itself() {
    let bends = host_sim(&["eval", "angle-from-pressure"], "0\n30\n150\n");
    assert!(bends.status.success());
    let lines = text(&bends.stdout);
    assert_eq!(lines.lines().next(), Some("0.000000"));
    let pressures = text(&host_sim(&["eval", "pressure-from-angle"], &lines).stdout);
    for (line, expected) in pressures.lines().zip([0.0, 30.0, 150.0]) {
        assert!((line.parse::<f64>().expect("a number") - expected).abs() < 1e-3, "{line}");
    }
}

#[test]
fn eval_with_a_method_answers_in_that_methods_digits() {
    // 60 kPa bends the default finger by 70.696249461 degrees (50 digits of mpmath: 70.6962494611...).
    for (method, within) in [("fixed-newton", 1.6e-5), ("f32-newton-native", 3e-5), ("f64-newton", 1e-9)] {
        let output = host_sim(&["eval", "angle-from-pressure", "--method", method], "60\n");
        assert!(output.status.success(), "{method}: {}", text(&output.stderr));
        let bend: f64 = text(&output.stdout).trim().parse().expect("a number");
        assert!((bend - 70.696_249_461).abs() < within, "{method}: {bend}");
    }
    let own = text(&host_sim(&["eval", "angle-from-pressure"], "60\n").stdout);
    assert_eq!(own, text(&host_sim(&["eval", "angle-from-pressure", "--method", "fixed-newton"], "60\n").stdout));
}

#[test]
fn pareto_prints_json_and_leaves_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["pareto", "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let rows = json["report"]["rows"].as_array().expect("rows");
    assert!(rows.iter().any(|row| row["method"] == "f64-newton" && row["max_error_working_deg"].is_number()));
    for name in
        ["pareto-bend-from-pressure.svg", "pareto-pressure-from-bend.svg", "pareto-inverse.csv", "hard-cases.md"]
    {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[test]
fn paper_prints_json_and_leaves_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["paper", "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(json["passed"], true);
    assert_eq!(json["bend"][1]["points"][4]["measured_deg"], 112.6);
    assert_eq!(json["combinations"][0]["paper"], "not given");
    for name in ["paper.md", "kinematics.md", "paper-bend.svg", "paper-force.svg", "paper-points.svg"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[test]
fn a_bad_line_is_named_after_the_earlier_ones_are_answered() {
    let output = host_sim(&["eval", "angle-from-pressure"], "30\n60\nsixty\n90\n");
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(&output.stdout).lines().count(), 2);
    let error = text(&output.stderr);
    assert!(error.contains("line 3") && error.contains("sixty"), "{error}");
}

#[test]
fn bad_arguments_name_the_value_and_the_limit() {
    for (arguments, named) in [
        (vec!["run", "--sequence", "polka"], vec!["polka", "reconfigure", "isolated-dip"]),
        (vec!["run", "--setpoints", "60,151,60"], vec!["151", "150 kPa"]),
        (vec!["run", "--setpoints", "60,60"], vec!["2 values"]),
        (vec!["run", "--bends", "60,111,60"], vec!["111", "110 degrees"]),
        (vec!["run", "--bends", "60,60,60", "--setpoints", "60,60,60"], vec!["--bends", "--setpoints"]),
        (vec!["identify", "--finger", "0,4,0.3"], vec!["C1", "5..=40"]),
        (vec!["identify", "--finger", "0,9,0.3", "--finger", "0,9,0.3"], vec!["2 times"]),
        (vec!["eval", "angle-from-pressure", "--calibration", "0,4,0.3"], vec!["C1", "5..=40"]),
        (
            vec!["eval", "angle-from-pressure", "--method", "guess"],
            vec!["guess", "fixed-newton", "f64-newton", "minimax"],
        ),
        (vec!["pareto", "--out", "Cargo.toml/below"], vec!["Cargo.toml/below", "--out"]),
        (vec!["--seed", "3", "run"], vec!["--seed"]),
        (vec!["campaign", "--shard", "4/3"], vec!["4/3", "I from 1 to N"]),
        (vec!["campaign", "--fault", "gremlins"], vec!["gremlins", "pump-stuck-on"]),
        (vec!["campaign", "--sequence", "polka"], vec!["polka", "by-hand"]),
        (vec!["campaign", "--out", "Cargo.toml/below"], vec!["Cargo.toml/below", "--out"]),
        (vec!["paper", "--out", "Cargo.toml/below"], vec!["Cargo.toml/below", "--out"]),
        (vec!["campaign", "merge"], vec!["FILES"]),
        (vec!["campaign", "merge", "no-such-file"], vec!["no-such-file"]),
        (vec!["campaign", "merge", "Cargo.toml", "--out", "../target/cli-test"], vec!["Cargo.toml", "no part"]),
        (vec!["calibrate"], vec!["FILE.csv"]),
        (vec!["calibrate", "no-such.csv"], vec!["no-such.csv"]),
        (vec!["calibrate", "Cargo.toml", "--out", "../target/cli-test"], vec!["Cargo.toml", "no column pressure_kpa"]),
        (vec!["calibrate", TABLE_2, "--out", "Cargo.toml/below"], vec!["Cargo.toml/below", "--out"]),
        (vec!["run", "--tempo", "3"], vec!["--tempo"]),
        (vec!["run", "--out", "Cargo.toml/below"], vec!["Cargo.toml/below", "--out"]),
    ] {
        let output = host_sim(&arguments, "");
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {error}");
        assert!(named.iter().all(|part| error.contains(part)), "{arguments:?}: {error}");
        assert_eq!(error.lines().count(), 1, "{arguments:?}: {error}");
        assert!(text(&output.stdout).is_empty(), "{arguments:?}");
    }
}

#[test]
fn run_prints_the_figures_as_json_and_leaves_the_files_it_names() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["run", "--setpoints", "30,0,30", "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert!(json["segments"][0]["hold_mean_abs_error_kpa"].as_f64().is_some_and(|error| error <= 2.0), "{json:#}");
    assert_eq!(json["seed"], 1);
    for file in json["files"].as_array().expect("a list") {
        assert!(std::path::Path::new(file.as_str().expect("a path")).exists(), "{file}");
    }
}

#[test]
fn identify_prints_the_figures_as_json_and_leaves_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["identify", "--finger", "0,13.79,0.323", "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert!(json["segments"][2]["points"].as_u64().is_some_and(|points| points >= 10), "{json:#}");
    for name in ["identify.svg", "identify.json"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
}

#[test]
fn list_names_every_sequence() {
    let output = host_sim(&["list", "--json"], "");
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(json.as_array().map(Vec::len), Some(model_core::sequence::library::ALL.len()));
}

#[test]
fn compare_prints_json_and_leaves_its_files() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["compare", "--scenario", "60-30-60", "--seeds", "1", "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let rows = json["rows"].as_array().expect("rows");
    let regulators: Vec<_> = rows.iter().map(|row| row["regulator"].as_str().expect("a name")).collect();
    assert_eq!(regulators, ["bang-bang", "pwm-pid", "sliding-mode", "ours"]);
    for row in rows {
        assert!(row["scores"]["mean_absolute_error_kpa"].is_number(), "{row}");
        assert!(row["steps"][0]["bound_ms"].as_f64().is_some_and(|bound| bound > 0.0), "{row}");
    }
    assert!(json["targets"].as_array().is_some_and(|targets| targets.iter().all(|target| target["met"].is_boolean())));
    for name in ["compare.json", "compare.csv", "compare.md", "compare-traces.svg", "compare-switchings.svg"] {
        assert!(folder.path().join(name).exists(), "{name}");
    }
    let table = text(&host_sim(&["compare", "--scenario", "60-30-60", "--seeds", "1", "--out", out], "").stdout);
    assert!(table.contains("0/0/0 to 60/30/60") && table.contains("target of ours"), "{table}");
}

#[test]
fn compare_names_a_scenario_that_is_not_there_and_seeds_out_of_range() {
    for (arguments, named) in [
        (vec!["compare", "--scenario", "polka"], vec!["polka", "multi-step", "cold-valves"]),
        (vec!["compare", "--seeds", "0"], vec!["0", "1..=1000"]),
        (vec!["compare", "--tune", "0"], vec!["0", "1..=100000"]),
    ] {
        let output = host_sim(&arguments, "");
        assert_eq!(output.status.code(), Some(2), "{arguments:?}");
        let error = text(&output.stderr);
        assert!(error.lines().count() == 1 && named.iter().all(|word| error.contains(word)), "{error}");
    }
}

#[test]
fn campaign_prints_json_and_its_shards_are_joined_to_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = |name: &str| folder.path().join(name).to_str().expect("UTF-8").to_owned();
    // What the controller misses ends in 1; here only what is printed and written counts.
    let campaign = |name: &str, more: &[&str]| {
        let out = place(name);
        let mut arguments = vec!["campaign", "--runs", "9", "--seed", "5", "--json", "--out", &out];
        arguments.extend(more);
        host_sim(&arguments, "").stdout
    };
    let whole = campaign("whole", &[]);
    let json: serde_json::Value = serde_json::from_slice(&whole).expect("JSON and nothing else");
    assert_eq!(json["result"]["runs"], 9);
    for (name, shard) in [("one", "1/2"), ("two", "2/2")] {
        campaign(name, &["--shard", shard]);
    }
    let files = ["two", "one"].map(|name| format!("{}/campaign.json", place(name)));
    let joined = host_sim(&["campaign", "merge", &files[0], &files[1], "--json", "--out", &place("joined")], "");
    assert_eq!(joined.stdout, whole);
    for name in ["campaign.json", "campaign.md", "campaign.csv", "campaign.txt", "detection-matrix.svg"] {
        let read = |of: &str| std::fs::read(format!("{}/{name}", place(of))).expect("there");
        assert_eq!(read("joined"), read("whole"), "{name}");
    }
    let twice = host_sim(&["campaign", "merge", &files[0], &files[0], "--out", &place("joined")], "");
    assert_eq!(twice.status.code(), Some(2));
    assert!(text(&twice.stderr).contains("both shard 2/2"), "{}", text(&twice.stderr));

    let again = host_sim(&["campaign", "--seed", "5", "--replay", "3", "--out", &place("again")], "");
    assert!(again.status.success() && text(&again.stdout).starts_with("run 3: "), "{}", text(&again.stdout));
    assert!(std::path::Path::new(&place("again/run-3/report.html")).exists());
}

#[test]
fn report_opens_a_runs_table_cut_in_a_line_and_says_so() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("run");
    let output = host_sim(&["run", "--setpoints", "30,0,30", "--json", "--out", out.to_str().expect("UTF-8")], "");
    let run: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let table = std::fs::read(out.join("samples.csv")).expect("there");
    let cut = folder.path().join("cut.csv");
    std::fs::write(&cut, &table[..table.len() - 7]).expect("written");
    let place = folder.path().join("report");
    let arguments = ["report", cut.to_str().expect("UTF-8"), "--json", "--out", place.to_str().expect("UTF-8")];
    let output = host_sim(&arguments, "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    assert_eq!(json["torn"], true);
    assert_eq!(json["bad_lines"], 0);
    assert_eq!(json["true_pressures"], true);
    assert_eq!(json["valve_switchings"], run["valve_switchings"]);
    assert!(json["files"][0].as_str().is_some_and(|file| std::path::Path::new(file).exists()), "{json}");
    for (file, named) in [("no-such.csv", "no-such.csv"), ("Cargo.toml", "no recording")] {
        let output = host_sim(&["report", file], "");
        let error = text(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{error}");
        assert!(error.contains(named) && error.lines().count() == 1, "{error}");
    }
}

#[test]
fn calibrate_finds_the_drawn_coefficients_and_names_the_misread_line() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["calibrate", TEN_REPEATS, "--json", "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let json: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON and nothing else");
    let table = std::fs::read_to_string(TEN_REPEATS).expect("there");
    let told =
        table.lines().nth(1).and_then(|line| line.split("line ").nth(1)).expect("the file names its misread line");
    let told = told.split(' ').next().expect("a number");
    let outliers: Vec<_> =
        json["warnings"].as_array().expect("warnings").iter().filter(|w| w["kind"] == "outlier").collect();
    assert_eq!(outliers.len(), 1, "{json:#}");
    assert!(
        outliers[0]["message"].as_str().is_some_and(|m| m.starts_with(&format!("line {told}:"))),
        "{:#}",
        outliers[0]
    );
    // As the file's own head says they were drawn.
    for (index, truth) in [12.0, 11.0, 0.5].into_iter().enumerate() {
        let interval = &json["segments"][0]["ci95_kpa"][index];
        let [low, high] = [0, 1].map(|end| interval[end].as_f64().expect("a number"));
        assert!(low <= truth && truth <= high, "{truth} is not in {low}..{high}");
    }
    for file in json["files"].as_array().expect("a list") {
        assert!(std::path::Path::new(file.as_str().expect("a path")).exists(), "{file}");
    }
}

#[test]
fn the_lines_that_calibrate_prints_work() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let output = host_sim(&["calibrate", TABLE_2, "--out", out], "");
    assert!(output.status.success(), "{}", text(&output.stderr));
    let said = text(&output.stdout);
    let line = said.lines().find(|line| line.contains("host-sim eval")).expect("how to look at it");
    let arguments: Vec<&str> = line.split_whitespace().skip(1).collect();
    let bends = text(&host_sim(&arguments, "30\n60\n90\n120\n150\n").stdout);
    for (bend, measured) in bends.lines().zip([46.3, 71.0, 89.6, 103.7, 112.6]) {
        let bend: f64 = bend.parse().expect("a number");
        assert!((bend - measured).abs() < 0.01 * measured, "{bend}, not {measured}");
    }
    let file = folder.path().join("calibration.toml");
    let load = format!("host-sim monitor --port auto --calibration {}", file.display());
    assert!(said.contains(&load) && said.contains("warning: segment all: fewer than 3"), "{said}");
    let segments = host_sim::calibrate::file::read(&file).and_then(|calibration| calibration.segments()).expect("read");
    let default = model_core::calibration::DEFAULT.to_f64_kpa();
    for segment in segments {
        let found = segment.expect("all segments").to_f64_kpa();
        assert!(found.iter().zip(default).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    }
}

#[test]
fn what_the_device_would_not_take_leaves_no_file_to_load() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().to_str().expect("UTF-8");
    let stale = folder.path().join("calibration.toml");
    std::fs::write(&stale, "of an earlier fit").expect("written");
    // A finger three times as soft: c1 near 4 kPa.
    let soft = folder.path().join("soft.csv");
    let table = "pressure_kpa,bend_deg\n10,46.3\n20,71.0\n30,89.6\n40,103.7\n50,112.6\n";
    std::fs::write(&soft, table).expect("written");
    let output = host_sim(&["calibrate", soft.to_str().expect("UTF-8"), "--out", out], "");
    let error = text(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    assert!(error.contains("C1 = 4.6") && error.contains("5..=40"), "{error}");
    assert!(!stale.exists() && folder.path().join("fit.svg").exists());
    assert!(!text(&output.stdout).contains("load it"));
}
