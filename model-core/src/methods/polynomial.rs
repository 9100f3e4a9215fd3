//! Polynomials through Chebyshev points, in `const` evaluation: within a factor of two of the best for their degree.

/// Σ (−x)ⁿ (n + 1)^`weight` / (2n + `first`)!, 20 terms: with (1, 0) sin α / α, with (3, 0) (1 − sin α / α) / α² and with (3, 1)
/// the derivative of 1 − sin α / α, each as a function of x = α². Ample for α below π.
pub const fn series(x: f64, first: u32, weight: bool) -> f64 {
    let mut term = if first == 3 { 1.0 / 6.0 } else { 1.0 };
    let mut sum = 0.0;
    let mut n = 0;
    while n < 20 {
        sum += if weight { term * (n + 1) as f64 } else { term };
        let next = (2 * n + first + 1) as f64;
        term *= -x / (next * (next + 1.0));
        n += 1;
    }
    sum
}

/// cos((2i + 1) π / 2n), the Chebyshev points of −1..1.
const fn chebyshev_point(i: usize, n: usize) -> f64 {
    let angle = (2 * i + 1) as f64 * core::f64::consts::PI / (2 * n) as f64;
    let mut term = 1.0;
    let mut sum = 0.0;
    let mut m = 0;
    while m < 20 {
        sum += term;
        let next = (2 * m + 1) as f64;
        term *= -angle * angle / (next * (next + 1.0));
        m += 1;
    }
    sum
}

/// The `N` Chebyshev points of `low`..`high`.
pub const fn chebyshev_points<const N: usize>(low: f64, high: f64) -> [f64; N] {
    let mut points = [0.0; N];
    let mut i = 0;
    while i < N {
        points[i] = f64::midpoint(low, high) + (high - low) / 2.0 * chebyshev_point(i, N);
        i += 1;
    }
    points
}

/// The coefficients, constant first, of the polynomial through `values` at `points`, rounded to f32.
pub const fn through<const N: usize>(points: [f64; N], values: [f64; N]) -> [f32; N] {
    // Newton's divided differences in place, then from Newton's form to powers.
    let mut c = values;
    let mut order = 1;
    while order < N {
        let mut i = N - 1;
        while i >= order {
            c[i] = (c[i] - c[i - 1]) / (points[i] - points[i - order]);
            i -= 1;
        }
        order += 1;
    }
    let mut start = N - 1;
    while start > 0 {
        start -= 1;
        let mut i = start;
        while i + 1 < N {
            c[i] -= points[start] * c[i + 1];
            i += 1;
        }
    }
    let mut rounded = [0.0; N];
    let mut i = 0;
    while i < N {
        rounded[i] = c[i] as f32;
        i += 1;
    }
    rounded
}

/// Horner.
pub fn evaluate<const N: usize>(coefficients: &[f32; N], x: f32) -> f32 {
    let mut falling = coefficients.iter().rev();
    let highest = falling.next().copied().unwrap_or(0.0);
    falling.fold(highest, |sum, c| sum * x + c)
}
