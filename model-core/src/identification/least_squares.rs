//! Weighted least squares of three unknowns, one measurement after another, in fixed point.
//!
//! The information of all measurements is kept as Rᵀ D R with R unit upper triangular, and D diagonal and never negative:
//! Gentleman's rotations without square roots (J. Inst. Maths Applics 12, 1973; Applied Statistics AS 75, AS 274), the
//! information form of Bierman's U-D filter. Nothing is ever subtracted from D, so no rounding makes it indefinite; and
//! what is added to R and to the right-hand side is a share of a residual, so a measurement that the unknowns fit already
//! changes nothing, however coarse that share is.
//!
//! What was found is forgotten only down to [`PRIOR`]: a direction that nothing excites keeps its value and a gain that
//! does not grow.

/// Unknowns.
pub(super) const UNKNOWNS: usize = 3;

/// Information about each unknown at the start, and the least that forgetting leaves, in 2⁻²⁴: as if each were known to be
/// right to some 250 times a measurement's error.
const PRIOR: u32 = 1 << 8;

/// Forgetting takes this power of one half.
const FORGET_SHIFT: u32 = 5;

/// To 32 bits, saturating.
const fn narrow(wide: i64) -> i32 {
    if wide > i32::MAX as i64 {
        i32::MAX
    } else if wide < i32::MIN as i64 {
        i32::MIN
    } else {
        wide as i32
    }
}

/// One measurement: `x` · unknowns = `y`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Row {
    /// 2⁻²⁸ each.
    pub x: [i32; UNKNOWNS],
    /// 2⁻¹⁶.
    pub y: i32,
    /// 2⁻²⁴.
    pub weight: u32,
    /// What the rotations have left of the weight, in 2⁻³¹.
    left: u32,
}

impl Row {
    pub const fn new(x: [i32; UNKNOWNS], y: i32, weight: u32) -> Self {
        Self { x, y, weight, left: 1 << 31 }
    }

    /// y less what these unknowns (2⁻¹⁶) explain of it.
    pub fn residual(&self, unknowns: &[i32; UNKNOWNS]) -> i32 {
        let explained: i64 = self.x.iter().zip(unknowns).map(|(&x, &u)| (i64::from(x) * i64::from(u)) >> 28).sum();
        narrow(i64::from(self.y).saturating_sub(explained))
    }

    /// The square of a residual (2⁻¹⁶), weighted, in 2⁻¹⁶.
    pub fn weighted_square(&self, residual: i32) -> u64 {
        // 2000 kPa and more are as bad as 2000.
        let size = u64::from(residual.unsigned_abs().min(1 << 27));
        (((size * size) >> 22) * u64::from(self.weight)) >> 18
    }
}

/// See the module's text.
#[derive(Clone, Copy, Debug)]
pub(super) struct LeastSquares {
    /// D, 2⁻²⁴.
    information: [u32; UNKNOWNS],
    /// R above its diagonal, 2⁻²⁴: up to 128 where what is left of one regressor is small beside another's.
    above: [[i32; UNKNOWNS]; UNKNOWNS],
    /// 2⁻¹⁶.
    right: [i32; UNKNOWNS],
    /// Sums of the squared residuals, weighted and not, and of the rows, all 2⁻¹⁶ and forgotten like the rest.
    weighted_squares: u32,
    squares: u32,
    rows: u32,
}

impl LeastSquares {
    /// Every unknown is zero, as far as is known.
    pub const fn new() -> Self {
        Self {
            information: [PRIOR; UNKNOWNS],
            above: [[0; UNKNOWNS]; UNKNOWNS],
            right: [0; UNKNOWNS],
            weighted_squares: 0,
            squares: 0,
            rows: 0,
        }
    }

    /// Everything counts a little less, down to the prior.
    pub fn forget(&mut self) {
        for information in &mut self.information {
            *information = (*information - (*information >> FORGET_SHIFT)).max(PRIOR);
        }
        for sum in [&mut self.weighted_squares, &mut self.squares, &mut self.rows] {
            *sum -= *sum >> FORGET_SHIFT;
        }
    }

    /// Eliminates one unknown from a row; all of them in their order take it in. Some 130 instructions.
    pub fn rotate(&mut self, row: &mut Row, unknown: usize) {
        let (Some(d), Some(above), Some(z), Some(&x)) = (
            self.information.get_mut(unknown),
            self.above.get_mut(unknown),
            self.right.get_mut(unknown),
            row.x.get(unknown),
        ) else {
            return;
        };
        let gain = (i64::from(row.weight) * i64::from(x)) >> 28;
        let added = (gain.saturating_mul(i64::from(x)) >> 28).clamp(0, 1 << 32) as u64;
        let sum = (u64::from(*d) + added).clamp(1, u64::from(u32::MAX)) as u32;
        // 1/sum is reciprocal · 2^(zeros − 47), to some 16 bits: nothing here needs more (see the module's text).
        let zeros = sum.leading_zeros();
        let reciprocal = u32::MAX / (((sum << (zeros & 31)) >> 15) | 1);
        let share = narrow(((gain * i64::from(reciprocal)) << 5) >> ((32 - zeros) & 63));
        let kept = ((u64::from(*d << (zeros & 31)) * u64::from(reciprocal)) >> 16).min(1 << 31);
        for (r, x_other) in above.iter_mut().zip(&mut row.x).skip(unknown + 1) {
            *x_other = narrow(i64::from(*x_other) - ((i64::from(x) * i64::from(*r)) >> 24));
            *r = narrow(i64::from(*r) + ((i64::from(share) * i64::from(*x_other)) >> 24));
        }
        row.y = narrow(i64::from(row.y) - ((i64::from(x) * i64::from(*z)) >> 28));
        *z = narrow(i64::from(*z) + ((i64::from(share) * i64::from(row.y)) >> 20));
        *d = sum;
        row.weight = ((u64::from(row.weight) * kept) >> 31) as u32;
        row.left = ((u64::from(row.left) * kept) >> 31) as u32;
    }

    /// Counts a row from which every unknown has been eliminated: what is left of it is the residual of the fit.
    pub fn count(&mut self, row: &Row) {
        let size = u64::from(row.y.unsigned_abs());
        let square = ((size * size) >> 16).min(1 << 31) as u32;
        let add = |sum: &mut u32, value: u64| *sum = sum.saturating_add(value.min(u64::from(u32::MAX)) as u32);
        add(&mut self.weighted_squares, row.weighted_square(row.y));
        add(&mut self.squares, (u64::from(square) * u64::from(row.left)) >> 31);
        add(&mut self.rows, 1 << 16);
    }

    /// Mean of the squared residuals, weighted and not, in 2⁻¹⁶: for as many rows as there are beyond the unknowns, at
    /// least one.
    pub fn mean_squares(&self) -> [u32; 2] {
        let beyond = (self.rows >> 8).saturating_sub((UNKNOWNS as u32) << 8).max(1 << 8);
        [self.weighted_squares, self.squares].map(|sum| {
            // Rows in 2⁻⁸; the quotient has 16 bits more than the type has room for above 2²⁴.
            let whole = sum / beyond;
            let part = ((sum % beyond) << 8).checked_div(beyond).unwrap_or(0);
            (whole << 8).saturating_add(part)
        })
    }

    /// The unknowns (2⁻¹⁶) within their bounds, and the first one but the last that lies outside when nothing else holds
    /// it: [`Self::hold`] that one and ask again. The last one's bound is exact without.
    pub fn solve(&self, bounds: &[[i32; 2]; UNKNOWNS]) -> ([i32; UNKNOWNS], Option<(usize, i32)>) {
        let [z0, z1, z2] = self.right;
        let [[_, r01, r02], [_, _, r12], _] = self.above;
        let [b0, b1, b2] = bounds;
        let times = |r: i32, u: i32| (i64::from(r) * i64::from(u)) >> 24;
        let within = |[low, high]: &[i32; 2], value: i32| value.min(*high).max(*low);
        let u2 = within(b2, z2);
        let free1 = narrow(i64::from(z1) - times(r12, u2));
        let u1 = within(b1, free1);
        let free0 = narrow(i64::from(z0) - times(r01, u1) - times(r02, u2));
        let u0 = within(b0, free0);
        let outside = if u1 != free1 {
            Some((1, u1))
        } else if u0 != free0 {
            Some((0, u0))
        } else {
            None
        };
        ([u0, u1, u2], outside)
    }

    /// Holds an unknown at a value from now on; what its own equation says of those after it comes back as a row, which
    /// they have to take in.
    pub fn hold(&mut self, unknown: usize, value: i32) -> Option<Row> {
        let own = self.above.get_mut(unknown)?;
        let z = self.right.get_mut(unknown)?;
        let d = self.information.get_mut(unknown)?;
        // The entries of R, in 2⁻²⁴, are a sixteenth of themselves in 2⁻²⁸; the weight makes up for it.
        let row = Row::new(*own, narrow((i64::from(*z) - i64::from(value)) >> 4), d.saturating_mul(256));
        (*own, *z, *d) = ([0; UNKNOWNS], value, u32::MAX);
        Some(row)
    }
}
