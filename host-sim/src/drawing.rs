//! What all pictures share: the area they are drawn into, its inks, and boxes that must not cover each other.

use anyhow::{Result, anyhow};
use plotters::chart::MeshStyle;
use plotters::coord::ranged1d::ValueFormatter;
use plotters::coord::types::RangedCoordf64;
use plotters::coord::{CoordTranslate, Shift};
use plotters::prelude::*;

/// Letters and axes.
pub const INK: RGBColor = RGBColor(60, 64, 72);
/// Grids and frames.
pub const FAINT: RGBColor = RGBColor(226, 229, 234);

/// A drawing area over an SVG text.
pub type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// What a plot draws into its area.
/// Axes of plain numbers both ways.
pub type Chart<'a, 'b> = ChartContext<'a, SVGBackend<'b>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;
type Draw<'a> = &'a dyn Fn(&Area<'_>) -> Result<()>;

/// An SVG of this size in pixels.
///
/// # Errors
/// When the drawing backend fails.
pub fn svg(size: (u32, u32), draw: Draw<'_>) -> Result<String> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, size).into_drawing_area();
        area.fill(&WHITE).map_err(drawing)?;
        draw(&area)?;
        area.present().map_err(drawing)?;
    }
    Ok(text)
}

/// How all plots' grids and axes look: no fine lines, faint grid, letters of 12.
pub fn styled<'m, 'a, 'b, X, Y, XT, YT, B>(
    mesh: &'m mut MeshStyle<'a, 'b, X, Y, B>,
) -> &'m mut MeshStyle<'a, 'b, X, Y, B>
where
    X: Ranged<ValueType = XT> + ValueFormatter<XT>,
    Y: Ranged<ValueType = YT> + ValueFormatter<YT>,
    B: DrawingBackend,
{
    mesh.light_line_style(WHITE.mix(0.0)).bold_line_style(FAINT).axis_style(INK).label_style(("sans-serif", 12, &INK))
}

/// Draws the legend of a chart there.
///
/// # Errors
/// When drawing fails.
pub fn series_labels<'a, 'b: 'a, C>(
    chart: &mut ChartContext<'a, SVGBackend<'b>, C>,
    position: SeriesLabelPosition,
) -> Result<()>
where
    C: CoordTranslate,
{
    chart
        .configure_series_labels()
        .position(position)
        .background_style(WHITE)
        .border_style(FAINT)
        .label_font(("sans-serif", 12, &INK))
        .draw()
        .map_err(drawing)
}

/// The backend's error as everybody else's.
#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
pub fn drawing<E: std::error::Error + Send + Sync>(error: DrawingAreaErrorKind<E>) -> anyhow::Error {
    anyhow!("cannot draw: {error}")
}

/// A rectangle in pixels: left, top, right, bottom.
pub type Bounds = [i32; 4];

/// Whether they share a pixel.
pub fn overlap(a: Bounds, b: Bounds) -> bool {
    a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3]
}
