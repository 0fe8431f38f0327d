//! A look before the look: in a phase in which the computer is up anyway, what
//! is not heated for adds nothing but its own draw. Where that alone leaves too
//! little later on, no start in the phase need be judged.

use super::Rest;

impl Rest<'_> {
    /// The last start up to which it would drain too much, if it would now.
    ///
    /// # Timing
    ///
    /// A few searches in what is sorted.
    pub(crate) fn drained_until(&self, item: usize, start: i64, optional: bool) -> Option<i64> {
        let Self { problem, world, .. } = self;
        let it = &problem.items[item];
        let (length, energy) = (it.shortest, it.draw.marginal * it.shortest);
        let end = start + length;
        let is_alone = it.zones.is_empty() && problem.blocks.is_empty();
        if self.plain || !is_alone || energy <= 0 || !world.late.is_empty() {
            return None;
        }
        let phase = world.phase_over(start, end)?;
        let leap = world.leap(end).filter(|_| !world.depends_between(phase.up.at, end))?;
        let lacks = |min: i64, without: i64| without - energy < min.min(without);
        let battery = &problem.battery;
        let (at, least) = leap.lowest;
        let soft = lacks(battery.soft, least).then_some(at);
        let is_in =
            |&at: &i64| optional && end <= at && leap.to.is_none_or(|to| at < to.cursor.at.at);
        let handover = problem.handover.filter(is_in);
        let handover = handover.filter(|&at| lacks(battery.handover, world.charge(at)));
        let later = soft.max(handover)?;
        Some(later.min(phase.down.at) - length)
    }
}
