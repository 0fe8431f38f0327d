//! What no activity is: phases of the computer, heating, communication windows.

use std::collections::BTreeMap;

use faregate_agents::Categories;
use faregate_scheduler::task::{TaskId, TaskPriority};

use super::translate::{Given, Held};
use super::{Misfit, ticket_priority};
use crate::parameters::Load;
use crate::plan::{Activity, Kind, Plan};
use crate::timed::{AwakePhase, Fate, Preheat, Slot};
use crate::units::{Span, Time};

/// What is generated, by what it is and when it is over: a phase that goes on
/// is the same one in the next plan, though that begins now.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Generated {
    Wakeup(Time),
    Awake(Time),
    Shutdown(Time),
    Heating(String, Time),
    Window(String, Time),
}

/// The first number of a task that is no activity, where the plan's are below:
/// so that the numbers of the next plan's activities are free.
const FIRST: u32 = 1_000_000;

/// Numbers of tasks that are no activities: above those of the plan, and never
/// used for anything else.
#[derive(Clone, Debug, Default)]
pub(super) struct Numbers {
    next: u32,
    ids: BTreeMap<Generated, TaskId>,
}

impl Numbers {
    pub(super) fn above(plan: &Plan) -> Self {
        let last = plan.activities.iter().map(|activity| activity.id.get()).max();
        let next = last.map_or(1, |last| last.saturating_add(1));
        Self { next: next.max(FIRST), ids: BTreeMap::new() }
    }

    pub(super) fn id(&mut self, what: &Generated) -> Result<TaskId, Vec<Misfit>> {
        if let Some(id) = self.ids.get(what) {
            return Ok(*id);
        }
        let id = TaskId::new(self.next).filter(|_| self.next < u32::MAX);
        let id = id.ok_or_else(|| vec![Misfit::Numbers])?;
        self.next += 1;
        self.ids.insert(what.clone(), id);
        Ok(id)
    }

    pub(super) fn what(&self, id: TaskId) -> Option<&Generated> {
        self.ids.iter().find(|(_, other)| **other == id).map(|(what, _)| what)
    }
}

impl Given<'_> {
    /// Everything that is generated and not over, each from now on.
    pub(super) fn generated(&self) -> Vec<(Generated, Held)> {
        let phases = self.timed.awake.iter().flat_map(|phase| self.phase(phase));
        let blocks = self.setting.plan.activities.iter().flat_map(|block| self.block(block));
        let heating = self.timed.preheats.iter().map(|heating| self.heating(heating));
        let windows = self.windows.iter().map(|window| {
            let held = Held {
                draw: Load { marginal: window.marginal, peak: window.peak },
                categories: window.resources,
                engines: usize::try_from(window.engines).unwrap_or(usize::MAX),
                // It is made elsewhere, and nobody moves it.
                priority: None,
                ..Held::over(window.start, window.end)
            };
            (Generated::Window(window.name.clone(), window.end), held)
        });
        let all = phases.chain(blocks).chain(heating).chain(windows);
        let from_now = all.filter_map(|(what, mut held)| {
            held.slot.start = held.slot.start.max(self.now);
            (held.slot.start < held.slot.end).then_some((what, held))
        });
        from_now.collect()
    }

    fn phase(&self, phase: &AwakePhase) -> Vec<(Generated, Held)> {
        let parameters = &self.setting.parameters;
        let held = Held::by_computer;
        vec![
            (Generated::Wakeup(phase.up), held(phase.wakeup, phase.up, parameters.wakeup.load)),
            (Generated::Awake(phase.down), held(phase.up, phase.down, parameters.awake)),
            (
                Generated::Shutdown(phase.asleep),
                held(phase.down, phase.asleep, parameters.shutdown.load),
            ),
        ]
    }

    /// The ground's own shutdown and wakeup.
    fn block(&self, block: &Activity) -> Vec<(Generated, Held)> {
        let Kind::ManualShutdown { shutdown, wakeup } = block.kind else { return Vec::new() };
        let Some(from) = block.starts.first().map(|range| range.from) else { return Vec::new() };
        let until = from.after(block.duration);
        let parameters = &self.setting.parameters;
        let held = Held::by_computer;
        let down = from.after(shutdown);
        vec![
            (Generated::Shutdown(down), held(from, down, parameters.shutdown.load)),
            (Generated::Wakeup(until), held(until.before(wakeup), until, parameters.wakeup.load)),
        ]
    }

    fn heating(&self, heating: &Preheat) -> (Generated, Held) {
        let zone = self.setting.parameters.zones.iter().find(|zone| zone.name == heating.zone);
        let held = Held {
            draw: zone.map_or(Load::default(), |zone| zone.load),
            priority: Some(self.priority_of_use(heating)),
            gates: super::fits::heaters(&self.setting.mission, &heating.zone),
            ..Held::over(heating.start, heating.end)
        };
        (Generated::Heating(heating.zone.clone(), heating.end), held)
    }

    pub(super) fn priority(&self, activity: &Activity) -> TaskPriority {
        ticket_priority(&self.setting.plan, &self.setting.parameters, activity.priority)
    }

    /// That of the most important activity that is heated for.
    fn priority_of_use(&self, heating: &Preheat) -> TaskPriority {
        let users = self.slots().filter(|(activity, slot)| {
            slot.start == heating.end && activity.zones.contains(&heating.zone)
        });
        self.most_important(users.map(|(activity, _)| activity)).unwrap_or_default()
    }

    fn most_important<'a>(
        &self,
        activities: impl Iterator<Item = &'a Activity>,
    ) -> Option<TaskPriority> {
        let most = activities.max_by_key(|activity| activity.priority);
        most.map(|activity| self.priority(activity))
    }

    /// Activities that run, or will.
    pub(super) fn slots(&self) -> impl Iterator<Item = (&Activity, Slot)> {
        let all = self.setting.plan.activities.iter().zip(&self.timed.rows);
        all.filter_map(|(activity, row)| match row.fate {
            Fate::Scheduled(slot) | Fate::Running(slot) => Some((activity, slot)),
            Fate::Ended(_) | Fate::Out(_) => None,
        })
    }
}

impl Held {
    const fn over(start: Time, end: Time) -> Self {
        Self {
            slot: Slot { start, end, range: 0 },
            draw: Load {
                marginal: faregate_tickets::amount::Milliwatts::ZERO,
                peak: faregate_tickets::amount::Milliwatts::ZERO,
            },
            priority: None,
            categories: Categories::NONE,
            engines: 0,
            gates: Vec::new(),
        }
    }

    /// The computer draws what it draws, whoever has the tickets for it: nobody
    /// takes them.
    fn by_computer(start: Time, end: Time, draw: Load) -> Self {
        Self { draw, ..Self::over(start, end) }
    }

    /// How late it may begin.
    pub(super) const fn tolerance(&self, allowed: Span) -> Time {
        let last = self.slot.start.after(allowed);
        if last.get() < self.slot.end.get() { last } else { self.slot.end }
    }
}
