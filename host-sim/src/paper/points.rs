//! What the points A, B and C at 60/30/60 kPa can be: each reading of the finger's geometry fitted to them.
//!
//! The paper gives neither the chain's lengths nor what the points mark. Every reading here is linear in what it leaves
//! open, so that the fit is a plain least-squares problem with one answer. The bends are the measured ones of Table 2 (one
//! chamber with exoskeleton, at 60 and 30 kPa), not fitted.

use anyhow::{Result, anyhow};
use model_core::paper;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// One place for each of A, B and C.
pub type Places = [[f64; 2]; 3];

/// The paper's three sets of points.
pub const SETS: [(&str, Places); 3] =
    [("model", paper::POINTS_MODEL_MM), ("fem", paper::POINTS_FEM_MM), ("measured", paper::POINTS_MEASURED_MM)];

/// A reading of the geometry, as places that are linear in what is open.
#[derive(Clone, Debug)]
pub struct Reading {
    /// Short name.
    pub name: &'static str,
    /// What the points are taken for.
    pub meaning: &'static str,
    /// What is known.
    known: Places,
    /// What is open: a name, and what a millimetre of it adds.
    open: Vec<(&'static str, Places)>,
}

/// A reading fitted to one set of points.
#[derive(Clone, Debug, Serialize)]
pub struct Fit {
    /// Short name.
    pub reading: &'static str,
    /// What the points are taken for.
    pub meaning: &'static str,
    /// `model`, `fem` or `measured`.
    pub points: &'static str,
    /// What was open, and its fitted value.
    pub open_mm: Vec<(&'static str, f64)>,
    /// Coordinates less what the fit could choose independently.
    pub degrees_of_freedom: usize,
    /// Root of the mean squared distance of the three points.
    pub rms_mm: f64,
    /// The largest of the three distances.
    pub worst_mm: f64,
    /// The same in proportion to C's distance from the origin, percent.
    pub worst_percent: f64,
    /// Where the fit puts A, B and C.
    pub places_mm: Places,
}

/// Measured bends at 60, 30 and 60 kPa, radians.
fn bends() -> [f64; 3] {
    let [at_30, at_60, ..] = paper::CHAMBER_EXO_DEG;
    [at_60, at_30, at_60].map(f64::to_radians)
}

fn unit(direction: f64) -> [f64; 2] {
    let (sin, cos) = direction.sin_cos();
    [cos, sin]
}

fn sum([a, b]: [f64; 2], [c, d]: [f64; 2]) -> [f64; 2] {
    [a + c, b + d]
}

/// The directions at the four ends of the segments.
fn directions() -> [f64; 4] {
    let [p, m, d] = bends();
    [0.0, p, p + m, p + m + d]
}

/// Adds up along the chain.
fn running(parts: [[f64; 2]; 3]) -> Places {
    let [a, b, c] = parts;
    [a, sum(a, b), sum(sum(a, b), c)]
}

/// Ends of three arcs of length 1.
fn arcs() -> Places {
    let [zero, one, two, _] = directions();
    let starts = [zero, one, two];
    let mut parts = [[0.0; 2]; 3];
    for ((part, start), bend) in parts.iter_mut().zip(starts).zip(bends()) {
        let [cos, sin] = unit(start + bend / 2.0);
        let chord = (bend / 2.0).sin() / (bend / 2.0);
        *part = [chord * cos, chord * sin];
    }
    running(parts)
}

/// Ends of rigid links, each of length 1 in turn, with these directions.
fn links(directions: [f64; 3]) -> [Places; 3] {
    [0, 1, 2].map(|which| {
        let mut parts = [[0.0; 2]; 3];
        parts[which] = unit(directions[which]);
        running(parts)
    })
}

fn added(all: [Places; 3]) -> Places {
    let [a, b, c] = all;
    let mut total = [[0.0; 2]; 3];
    for (total, ((a, b), c)) in total.iter_mut().zip(a.into_iter().zip(b).zip(c)) {
        *total = sum(sum(a, b), c);
    }
    total
}

fn scaled(places: Places, length: f64) -> Places {
    places.map(|[x, y]| [x * length, y * length])
}

const NOTHING: Places = [[0.0; 2]; 3];
const RIGHT: Places = [[1.0, 0.0]; 3];
const DOWN: Places = [[0.0, 1.0]; 3];

/// The gaps of 1 mm between the chambers, which A has not yet passed.
fn gaps() -> Places {
    let [_, one, two, _] = directions();
    running([[0.0; 2], unit(one), unit(two)])
}

/// Every reading that was tried, the ones with the fewest open values first within each kind.
#[must_use]
pub fn readings() -> Vec<Reading> {
    let [zero, one, two, three] = directions();
    let (before, after) = (links([one, two, three]), links([zero, one, two]));
    let inward = [one, two, three].map(|direction| [-direction.sin(), direction.cos()]);
    let reading = |name, meaning, known, open| Reading { name, meaning, known, open };
    let table_1 = scaled(arcs(), paper::CHAMBER_LENGTH_MM);
    let with_height = |height: f64| {
        let mut known = table_1;
        for place in &mut known {
            *place = sum(*place, [0.0, height]);
        }
        known
    };
    let three = |links: [Places; 3], from: bool| {
        let mut open: Vec<_> = ["proximal", "middle", "distal"].into_iter().zip(links).collect();
        if from {
            open.extend([("x0", RIGHT), ("y0", DOWN)]);
        }
        open
    };
    vec![
        reading(
            "arcs, Table 1",
            "ends of 38 mm arcs, along the exoskeleton's underside (22.5 mm below the origin)",
            with_height(paper::EXOSKELETON_HEIGHT_MM),
            vec![],
        ),
        reading("arcs, height", "ends of 38 mm arcs, height below the origin open", table_1, vec![("y0", DOWN)]),
        reading(
            "arcs, gaps, height",
            "as before, with the 1 mm between the chambers",
            {
                let mut known = table_1;
                for (place, gap) in known.iter_mut().zip(gaps()) {
                    *place = sum(*place, gap);
                }
                known
            },
            vec![("y0", DOWN)],
        ),
        reading("arcs, length and height", "ends of equal arcs", NOTHING, vec![("arc", arcs()), ("y0", DOWN)]),
        reading(
            "arcs, length and place",
            "ends of equal arcs, start open",
            NOTHING,
            vec![("arc", arcs()), ("x0", RIGHT), ("y0", DOWN)],
        ),
        reading(
            "arcs, offset",
            "points beside the ends of equal arcs, start open",
            NOTHING,
            vec![("arc", arcs()), ("inward", inward), ("x0", RIGHT), ("y0", DOWN)],
        ),
        reading(
            "links turned by the sum",
            "ends of equal rigid links, each turned by the bends up to its own, start open",
            NOTHING,
            vec![("link", added(before)), ("x0", RIGHT), ("y0", DOWN)],
        ),
        reading("links turned by the sum, unequal", "the same with three lengths", NOTHING, three(before, true)),
        reading(
            "links before their joint",
            "ends of equal rigid links, each turned by the bends before it, start open",
            NOTHING,
            vec![("link", added(after)), ("x0", RIGHT), ("y0", DOWN)],
        ),
        reading("links before their joint, unequal", "the same with three lengths", NOTHING, three(after, true)),
        reading(
            "links from the corner",
            "three rigid links from the origin itself, turned by the bends up to their own",
            NOTHING,
            three(before, false),
        ),
    ]
}

impl Reading {
    /// The least-squares fit to these points.
    ///
    /// # Errors
    /// When the decomposition fails.
    pub fn fit(&self, points: &'static str, places: &Places) -> Result<Fit> {
        let flat = |places: &Places| DVector::from_iterator(6, places.iter().flatten().copied());
        let known = flat(&self.known);
        let wanted = flat(places) - &known;
        let mut solved = known;
        let mut open_mm = Vec::new();
        let mut rank = 0;
        if !self.open.is_empty() {
            let columns: Vec<_> = self.open.iter().map(|(_, adds)| flat(adds)).collect();
            let matrix = DMatrix::from_columns(&columns);
            let decomposition = matrix.clone().svd(true, true);
            rank = decomposition.rank(1e-9);
            let values = decomposition.solve(&wanted, 1e-9).map_err(|error| anyhow!("{}: {error}", self.name))?;
            solved += matrix * &values;
            open_mm = self.open.iter().zip(values.iter()).map(|((name, _), &value)| (*name, value)).collect();
        }
        let mut places_mm = NOTHING;
        for (place, chunk) in places_mm.iter_mut().zip(solved.as_slice().chunks_exact(2)) {
            *place = [chunk[0], chunk[1]];
        }
        let distances: Vec<f64> = places_mm
            .iter()
            .zip(places)
            .map(|(fitted, given)| (fitted[0] - given[0]).hypot(fitted[1] - given[1]))
            .collect();
        let worst_mm = distances.iter().copied().fold(0.0, f64::max);
        let [_, _, [c_x, c_y]] = *places;
        Ok(Fit {
            reading: self.name,
            meaning: self.meaning,
            points,
            open_mm,
            degrees_of_freedom: 6 - rank,
            rms_mm: (distances.iter().map(|distance| distance * distance).sum::<f64>() / 3.0).sqrt(),
            worst_mm,
            worst_percent: 100.0 * worst_mm / c_x.hypot(c_y),
            places_mm,
        })
    }
}

/// Every reading with each of the paper's sets of points.
///
/// # Errors
/// As [`Reading::fit`].
pub fn fits() -> Result<Vec<Fit>> {
    let mut all = Vec::new();
    for reading in readings() {
        for (name, places) in &SETS {
            all.push(reading.fit(name, places)?);
        }
    }
    Ok(all)
}

/// Lengths and directions of the legs from the origin to A, to B, to C: what needs no reading at all.
#[derive(Clone, Debug, Serialize)]
pub struct Legs {
    /// `model`, `fem` or `measured`.
    pub points: &'static str,
    /// Of origin to A, A to B, B to C.
    pub lengths_mm: [f64; 3],
    /// From the x axis towards y.
    pub directions_deg: [f64; 3],
    /// From the second leg to the third.
    pub turn_at_b_deg: f64,
}

/// The legs of each set of points.
#[must_use]
pub fn legs() -> Vec<Legs> {
    SETS.iter()
        .map(|&(points, [a, b, c])| {
            let between = |[x0, y0]: [f64; 2], [x1, y1]: [f64; 2]| [x1 - x0, y1 - y0];
            let legs = [a, between(a, b), between(b, c)];
            let directions_deg = legs.map(|[x, y]| y.atan2(x).to_degrees());
            let [_, second, third] = directions_deg;
            Legs { points, lengths_mm: legs.map(|[x, y]| x.hypot(y)), directions_deg, turn_at_b_deg: third - second }
        })
        .collect()
}

/// What each kind of chain turns by at B, degrees, whatever its lengths: equal arcs' chords, links turned by the sum,
/// links before their joint.
#[must_use]
pub fn turns_at_b_deg() -> [f64; 3] {
    let [_, middle, distal] = bends().map(f64::to_degrees);
    [f64::midpoint(middle, distal), distal, middle]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_reading_finds_the_lengths_that_made_the_points() {
        for reading in readings() {
            let values: Vec<f64> = (0..reading.open.len()).map(|index| 31.0 + 7.0 * index as f64).collect();
            let mut places = reading.known;
            for ((_, adds), value) in reading.open.iter().zip(&values) {
                for (place, add) in places.iter_mut().zip(scaled(*adds, *value)) {
                    *place = sum(*place, add);
                }
            }
            let fit = reading.fit("made", &places).expect("a fit");
            assert!(fit.worst_mm < 1e-9, "{fit:?}");
            if fit.degrees_of_freedom == 6 - values.len() {
                for ((name, found), value) in fit.open_mm.iter().zip(values) {
                    assert!((found - value).abs() < 1e-6, "{}: {name}", reading.name);
                }
            }
        }
    }

    /// What docs/kinematics.md says of the points.
    #[test]
    fn arcs_of_table_1_fit_best_and_give_its_chamber_length_back() {
        let all = fits().expect("fits");
        let find = |reading: &str, points: &str| {
            all.iter().find(|fit| fit.reading == reading && fit.points == points).expect("is there")
        };
        for (points, _) in SETS {
            let arcs = find("arcs, length and height", points);
            assert!((arcs.open_mm[0].1 - paper::CHAMBER_LENGTH_MM).abs() < 1.0, "{arcs:?}");
            assert!((16.5..=22.5).contains(&arcs.open_mm[1].1), "{arcs:?}");
            assert!(arcs.rms_mm < 4.2, "{arcs:?}");
            for rigid in
                ["links turned by the sum, unequal", "links before their joint, unequal", "links from the corner"]
            {
                assert!(find(rigid, points).rms_mm > 2.0 * arcs.rms_mm, "{rigid} {points}");
            }
        }
    }
}
