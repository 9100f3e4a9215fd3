//! The polynomial with the smallest worst error, by Remez' exchange on a grid.

/// Points of the grid.
pub const GRID: usize = 33;
/// Exchanges at most; four or five are usual.
const MOST_EXCHANGES: u32 = 12;
/// The error is level when no point exceeds the reference by more than this share.
const LEVEL: f64 = 1e-3;

/// The grid: −cos(jπ / 32), from −1 to 1, denser towards the ends.
pub fn grid() -> [f64; GRID] {
    let mut grid = [0.0; GRID];
    for (index, x) in grid.iter_mut().enumerate() {
        *x = -libm::cos(core::f64::consts::PI * index as f64 / (GRID - 1) as f64);
    }
    grid
}

/// Horner.
pub fn evaluate(coefficients: &[f64], x: f64) -> f64 {
    coefficients.iter().rev().fold(0.0, |sum, c| sum * x + c)
}

/// The highest divided difference of `values` over `points`, both of the same length.
fn divided_difference(points: &[f64], values: impl Iterator<Item = f64>) -> f64 {
    // Lagrange's form of it: Σ y_i / Π (x_i − x_j).
    let others = |i: usize| points.iter().enumerate().filter(move |&(j, _)| j != i).map(|(_, x)| x);
    points.iter().zip(values).enumerate().map(|(i, (x, y))| y / others(i).map(|other| x - other).product::<f64>()).sum()
}

/// The coefficients, constant first, of the polynomial of degree `N` − 1 that has the smallest worst error among the
/// `values` at [`grid`]. `N` at most 8.
pub fn minimax<const N: usize>(grid: &[f64; GRID], values: &[f64; GRID]) -> [f64; N] {
    // N + 1 points at which the error is to have alternating signs and the same size: in the beginning, the Chebyshev
    // extremes among the grid.
    let mut reference = [0; GRID];
    for (index, point) in reference.iter_mut().take(N + 1).enumerate() {
        *point = index * (GRID - 1) / N;
    }
    let mut coefficients = [0.0; N];
    for _ in 0..MOST_EXCHANGES {
        let level = levelled(grid, values, &reference, &mut coefficients);
        let (next, found, worst) = extremes::<N>(grid, values, &coefficients);
        if found <= N || worst <= level.abs() * (1.0 + LEVEL) {
            break;
        }
        reference = next;
    }
    coefficients
}

/// The polynomial whose error at the reference is level and alternates; returns that error.
fn levelled<const N: usize>(
    grid: &[f64; GRID],
    values: &[f64; GRID],
    reference: &[usize; GRID],
    coefficients: &mut [f64; N],
) -> f64 {
    let mut points = [0.0; 9];
    let mut heights = [0.0; 9];
    for ((&at, point), height) in reference.iter().zip(&mut points).zip(&mut heights).take(N + 1) {
        *point = grid.get(at).copied().unwrap_or(0.0);
        *height = values.get(at).copied().unwrap_or(0.0);
    }
    let sign = |index: usize| if index.is_multiple_of(2) { 1.0 } else { -1.0 };
    let points = points.get(..=N).unwrap_or_default();
    // The polynomial has no term of degree N, so that the divided differences of values and errors are the same.
    let level =
        divided_difference(points, heights.iter().copied()) / divided_difference(points, (0..points.len()).map(sign));
    // Newton's form through the first N points less their errors, then powers.
    for (index, (c, height)) in coefficients.iter_mut().zip(heights).enumerate() {
        *c = height - sign(index) * level;
    }
    for order in 1..N {
        for index in (order..N).rev() {
            let width = points.get(index).unwrap_or(&1.0) - points.get(index - order).unwrap_or(&0.0);
            let before = coefficients.get(index - 1).copied().unwrap_or(0.0);
            if let Some(c) = coefficients.get_mut(index) {
                *c = (*c - before) / width;
            }
        }
    }
    for start in (0..N.saturating_sub(1)).rev() {
        let point = points.get(start).copied().unwrap_or(0.0);
        for index in start..N - 1 {
            let after = coefficients.get(index + 1).copied().unwrap_or(0.0);
            if let Some(c) = coefficients.get_mut(index) {
                *c -= point * after;
            }
        }
    }
    level
}

/// The grid's points of the largest error in each run of one sign, N + 1 of them; how many there are, and the worst error.
fn extremes<const N: usize>(
    grid: &[f64; GRID],
    values: &[f64; GRID],
    coefficients: &[f64; N],
) -> ([usize; GRID], usize, f64) {
    let mut places = [0; GRID];
    let mut sizes = [0.0_f64; GRID];
    let (mut found, mut last, mut worst) = (0, 0.0_f64, 0.0_f64);
    for (index, (x, y)) in grid.iter().zip(values).enumerate() {
        let error = y - evaluate(coefficients, *x);
        worst = worst.max(error.abs());
        if found == 0 || error * last < 0.0 {
            found += 1;
            last = error;
        }
        let (Some(place), Some(size)) = (places.get_mut(found - 1), sizes.get_mut(found - 1)) else { break };
        if error.abs() >= *size {
            (*place, *size, last) = (index, error.abs(), error);
        }
    }
    // Too many: the smaller end goes.
    let mut first = 0;
    while found - first > N + 1 {
        let (head, tail) = (sizes.get(first).unwrap_or(&0.0), sizes.get(found - 1).unwrap_or(&0.0));
        if head < tail { first += 1 } else { found -= 1 }
    }
    let mut kept = [0; GRID];
    for (kept, place) in kept.iter_mut().zip(places.iter().skip(first)) {
        *kept = *place;
    }
    (kept, found - first, worst)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst<const N: usize>(of: impl Fn(f64) -> f64) -> f64 {
        let grid = grid();
        let c: [f64; N] = minimax(&grid, &grid.map(&of));
        (0..=2000).map(|i| f64::from(i) / 1000.0 - 1.0).map(|x| (of(x) - evaluate(&c, x)).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn known_best_errors() {
        // Best errors from the literature. A grid of 33 points misses the true extremes by a few per cent at most.
        let near_best = |found: f64, best: f64| found > best * (1.0 - 1e-6) && found < best * 1.05;
        // x⁶ less its best polynomial of degree 5 is T6 / 32.
        assert!(near_best(worst::<6>(|x| x.powi(6)), 1.0 / 32.0));
        // e^x and degree 3 (Meinardus).
        assert!(near_best(worst::<4>(f64::exp), 0.005_528));
        // √x on 0..1 and degree 1: 1/8, by hand.
        assert!(near_best(worst::<2>(|x| f64::midpoint(x, 1.0).sqrt()), 0.125));
    }

    #[test]
    fn what_is_a_polynomial_is_found_exactly() {
        assert!(worst::<6>(|x| 1.0 - 2.0 * x + 0.5 * x.powi(5)) < 1e-13);
    }
}
