//! What needs the computer, in order.

use crate::computer::{Begin, Rules};

/// What needs the computer, with the ends of manual blocks and the mode at the
/// begin, in one piece where it touches.
pub(crate) fn components(rules: &Rules, begin: Begin, needs: Vec<(i64, i64)>) -> Vec<(i64, i64)> {
    let within = |(start, end): (i64, i64)| (start.max(rules.now), end.min(rules.end));
    let mut all: Vec<(i64, i64)> = needs.into_iter().map(within).filter(|(s, e)| s < e).collect();
    match begin {
        Begin::Up { .. } => all.push((rules.now, rules.now)),
        Begin::Waking { up } => all.push((up, up)),
        Begin::Asleep { .. } | Begin::Block => {}
    }
    for (start, end) in &rules.blocks {
        all = all.into_iter().flat_map(|need| around(need, (*start, *end))).collect();
        all.extend([(*start, *start), (*end, *end)].iter().filter(|(s, _)| *s >= rules.now));
    }
    all.retain(|(start, _)| *start <= rules.end);
    all.sort_unstable();
    let mut merged: Vec<(i64, i64)> = Vec::new();
    for (start, end) in all {
        match merged.last_mut() {
            Some(last) if start <= last.1 => last.1 = last.1.max(end),
            _ => merged.push((start, end)),
        }
    }
    merged
}

/// What is left of a need beside a block: nothing should overlap one.
fn around((start, end): (i64, i64), block: (i64, i64)) -> Vec<(i64, i64)> {
    let parts = [(start, end.min(block.0)), (start.max(block.1), end)];
    let whole = start == end;
    parts.into_iter().filter(|(s, e)| s < e || whole && s == e).collect()
}
