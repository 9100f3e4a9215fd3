//! The paper's figures in `model_core::paper` are those of `data/paper.toml`.

use model_core::paper;
use toml::{Table, Value};

fn figures(table: &Table, section: &str, key: &str) -> Vec<f64> {
    let number = |value: &Value| value.as_float().or_else(|| value.as_integer().map(|n| n as f64)).expect("a number");
    match &table[section][key] {
        Value::Array(values) => values.iter().map(number).collect(),
        single => vec![number(single)],
    }
}

#[test]
fn constants_are_those_of_the_reference_file() {
    let table: Table = include_str!("../data/paper.toml").parse().expect("paper.toml");
    let cases: [(&str, &str, &[f64]); 7] = [
        ("bend_measured", "pressure_kPa", &paper::PRESSURE_KPA),
        ("bend_measured", "chamber_bare_deg", &paper::CHAMBER_BARE_DEG),
        ("bend_measured", "chamber_exo_deg", &paper::CHAMBER_EXO_DEG),
        ("bend_measured", "finger_deg", &paper::FINGER_DEG),
        ("geometry_mm", "chambers_N", &[paper::CHAMBERS]),
        ("yeoh_uniaxial_MPa", "C10", &[paper::C10_MPA]),
        ("yeoh_uniaxial_MPa", "C20", &[paper::C20_MPA]),
    ];
    for (section, key, constant) in cases {
        assert_eq!(figures(&table, section, key), constant, "{section}.{key}");
    }
}
