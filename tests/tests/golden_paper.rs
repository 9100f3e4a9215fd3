//! The paper's figures in `model_core::paper` are those of `data/paper.toml`.

use model_core::paper;
use toml::{Table, Value};

fn numbers(value: &Value) -> Vec<f64> {
    match value {
        Value::Array(values) => values.iter().flat_map(numbers).collect(),
        single => {
            vec![single.as_float().or_else(|| single.as_integer().map(|n| n as f64)).expect("a number")]
        }
    }
}

#[test]
fn constants_are_those_of_the_reference_file() {
    let table: Table = include_str!("../data/paper.toml").parse().expect("paper.toml");
    let cases: [(&str, &str, &[f64]); 27] = [
        ("bend_measured", "pressure_kPa", &paper::PRESSURE_KPA),
        ("bend_measured", "chamber_bare_deg", &paper::CHAMBER_BARE_DEG),
        ("bend_measured", "chamber_exo_deg", &paper::CHAMBER_EXO_DEG),
        ("bend_measured", "finger_deg", &paper::FINGER_DEG),
        ("force_measured", "pressure_kPa", &paper::FORCE_PRESSURE_KPA),
        ("force_measured", "chamber_bare_N", &paper::CHAMBER_BARE_N),
        ("force_measured", "chamber_exo_N", &paper::CHAMBER_EXO_N),
        ("force_measured", "finger_N", &paper::FINGER_N),
        ("fem_at_150_kPa", "small_cavity_exo_deg", &[paper::FEM_SMALL_CAVITY_DEG]),
        ("fem_at_150_kPa", "chamber_bare_deg", &[paper::FEM_CHAMBER_BARE_DEG]),
        ("fem_at_150_kPa", "chamber_exo_deg", &[paper::FEM_CHAMBER_EXO_DEG]),
        ("fem_at_150_kPa", "finger_deg", &[paper::FEM_FINGER_DEG]),
        ("fem_at_150_kPa", "small_cavity_exo_N", &[paper::FEM_SMALL_CAVITY_N]),
        ("fem_at_150_kPa", "chamber_bare_N", &[paper::FEM_CHAMBER_BARE_N]),
        ("fem_at_150_kPa", "chamber_exo_N", &[paper::FEM_CHAMBER_EXO_N]),
        ("fem_at_150_kPa", "finger_N", &[paper::FEM_FINGER_N]),
        ("reconfiguration", "pressure_kPa", &paper::RECONFIGURATION_KPA),
        ("reconfiguration", "model_mm", paper::POINTS_MODEL_MM.as_flattened()),
        ("reconfiguration", "fem_mm", paper::POINTS_FEM_MM.as_flattened()),
        ("reconfiguration", "measured_mm", paper::POINTS_MEASURED_MM.as_flattened()),
        ("geometry_mm", "chambers_N", &[paper::CHAMBERS]),
        ("geometry_mm", "small_cavities_per_chamber_n", &[paper::SMALL_CAVITIES]),
        ("geometry_mm", "chamber_length_a", &[paper::CHAMBER_LENGTH_MM]),
        ("geometry_mm", "exoskeleton_height_h", &[paper::EXOSKELETON_HEIGHT_MM]),
        ("geometry_mm", "chamber_height_c", &[paper::CHAMBER_HEIGHT_MM]),
        ("yeoh_uniaxial_MPa", "C10", &[paper::C10_MPA]),
        ("yeoh_uniaxial_MPa", "C20", &[paper::C20_MPA]),
    ];
    for (section, key, constant) in cases {
        assert_eq!(numbers(&table[section][key]), constant, "{section}.{key}");
    }
}

#[expect(clippy::float_cmp, reason = "whole millimetres, exact in both")]
#[test]
fn the_chains_lengths_are_those_of_table_1() {
    let table: Table = include_str!("../data/paper.toml").parse().expect("paper.toml");
    let mm = |key: &str| numbers(&table["geometry_mm"][key])[0];
    let chain = model_core::kinematics::Chain::PAPER;
    assert_eq!(chain.base().to_f64(), mm("tail_length_l1"));
    assert_eq!(chain.arcs().map(model_core::units::Length::to_f64), [mm("chamber_length_a"); 3]);
    let [between, also, head] = chain.links().map(model_core::units::Length::to_f64);
    assert_eq!([between, also, head], [mm("cavity_spacing_e"), mm("cavity_spacing_e"), mm("head_length_l0")]);
    let sum = chain.base().to_f64() + chain.arcs().iter().chain(&chain.links()).map(|part| part.to_f64()).sum::<f64>();
    assert_eq!(sum, mm("actuator_length_L"));
}
