//! Curves as pictures.

use plotters::prelude::*;

use crate::support::{Curve, Failure, number};

// The colours of Okabe and Ito, which colour-blind people can tell apart.
const COLOURS: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xb2),
    RGBColor(0xc0, 0x4f, 0x00),
    RGBColor(0x00, 0x7a, 0x5a),
    RGBColor(0xcc, 0x79, 0xa7),
    RGBColor(0xe6, 0x9f, 0x00),
    RGBColor(0x56, 0xb4, 0xe9),
];

const SIZE: (u32, u32) = (760, 460);
/// The size is the backend's own measure; it comes out some fifth smaller.
const TEXT: (&str, i32) = ("sans-serif", 15);

/// How values lie along an axis: themselves, or their powers of ten.
#[derive(Clone, Copy)]
struct Scale {
    logarithmic: bool,
}

impl Scale {
    fn place(self, value: f64) -> f64 {
        // A logarithm of nothing would be off the picture.
        if self.logarithmic { value.max(f64::MIN_POSITIVE).log10() } else { value }
    }

    fn label(self, place: &f64) -> String {
        if self.logarithmic { number(10_f64.powf(*place)) } else { number(*place) }
    }

    /// How many labels: one for each power of ten, or some.
    fn ticks(self, values: impl Iterator<Item = f64>) -> usize {
        let std::ops::Range { start, end } = self.range(values);
        // No more powers than a number can have.
        let powers = (0..=u8::MAX).take_while(|&nth| start + f64::from(nth) <= end);
        if self.logarithmic { powers.count() } else { 6 }
    }

    /// From the least value to the greatest, with a margin; a linear axis
    /// begins at nothing, so that a flat curve looks flat.
    fn range(self, values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
        let places: Vec<f64> = values.map(|value| self.place(value)).collect();
        let low = places.iter().copied().fold(f64::INFINITY, f64::min);
        let high = places.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if self.logarithmic {
            low.floor()..high.ceil().max(low.floor() + 1.0)
        } else {
            0.0..high * 1.1 + f64::EPSILON
        }
    }
}

/// The picture of a curve.
pub(crate) fn svg(curve: &Curve) -> Result<String, Failure> {
    let mut text = String::new();
    draw(curve, &mut text).map_err(|reason| format!("{}: {reason}", curve.slug))?;
    Ok(text)
}

fn draw(curve: &Curve, text: &mut String) -> Result<(), Failure> {
    let (x, y) = (Scale { logarithmic: curve.log_x }, Scale { logarithmic: curve.log_y });
    let points = || curve.series.iter().flat_map(|series| series.points.iter().copied());
    if points().next().is_none() {
        return Err("a curve without points".into());
    }
    let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let mut chart = ChartBuilder::on(&area)
        .caption(&curve.title, ("sans-serif", 21))
        .margin(12)
        .margin_right(32)
        .x_label_area_size(42)
        .y_label_area_size(64)
        .build_cartesian_2d(
            x.range(points().map(|point| point.0)),
            y.range(points().map(|point| point.1)),
        )?;
    chart
        .configure_mesh()
        .label_style(TEXT)
        .axis_desc_style(TEXT)
        .x_labels(x.ticks(points().map(|point| point.0)))
        .y_labels(y.ticks(points().map(|point| point.1)))
        .x_desc(&curve.x)
        .y_desc(&curve.y)
        .x_label_formatter(&|place| x.label(place))
        .y_label_formatter(&|place| y.label(place))
        .light_line_style(TRANSPARENT)
        .draw()?;
    for (series, colour) in curve.series.iter().zip(COLOURS.into_iter().cycle()) {
        let places: Vec<_> =
            series.points.iter().map(|(a, b)| (x.place(*a), y.place(*b))).collect();
        chart.draw_series(places.iter().map(|place| Circle::new(*place, 3, colour.filled())))?;
        chart
            .draw_series(LineSeries::new(places, colour.stroke_width(2)))?
            .label(&series.name)
            .legend(move |(left, middle)| {
                PathElement::new([(left, middle), (left + 18, middle)], colour.stroke_width(2))
            });
    }
    chart
        .configure_series_labels()
        .label_font(TEXT)
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK)
        .draw()?;
    area.present()?;
    Ok(())
}
