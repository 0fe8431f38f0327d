//! Quantities as they are written: exact, in a unit that a person would choose.

use faregate_tickets::amount::{Microjoules, Milliwatts};

use crate::file::value::{DATA, Quantity, SPAN};
use crate::units::{Bytes, Ppm, Span};

/// In the largest unit that leaves a whole number.
fn whole(units: i64, of: &Quantity) -> String {
    let sign = if units < 0 { "-" } else { "" };
    let units = i128::from(units).abs();
    let fits = |size: i128, parts: i128| parts == 1 && units >= size && units % size == 0;
    let unit = of.units.iter().find(|(_, size, parts)| fits(*size, *parts));
    let smallest = of.units.iter().find(|(_, size, parts)| (*size, *parts) == (1, 1));
    let (name, size) = unit.or(smallest).map_or(("", 1), |(name, size, _)| (*name, *size));
    format!("{sign}{} {name}", units / size)
}

/// A number of so many units, as a decimal fraction of the larger unit.
fn decimal(units: u64, places: usize) -> String {
    let size = 10_u64.pow(u32::try_from(places).unwrap_or_default());
    let text = format!("{}.{:0places$}", units / size, units % size);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

pub(crate) fn span(span: Span) -> String {
    whole(span.get(), &SPAN)
}

pub(crate) fn data(data: Bytes) -> String {
    whole(data.get(), &DATA)
}

pub(crate) fn power(power: Milliwatts) -> String {
    format!("{} W", decimal(power.get(), 3))
}

/// In watt-hours, as batteries are, where that is exact.
pub(crate) fn energy(energy: Microjoules) -> String {
    const MILLIWATT_HOUR: u64 = 3_600_000;
    match energy.get() {
        uj if uj.is_multiple_of(MILLIWATT_HOUR) => {
            format!("{} Wh", decimal(uj / MILLIWATT_HOUR, 3))
        }
        uj => format!("{} J", decimal(uj, 6)),
    }
}

pub(crate) fn fraction(fraction: Ppm) -> String {
    fraction.to_string()
}
