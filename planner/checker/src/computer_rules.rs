//! What is generated: awake phases, sleeps, heating. Looked at as it is given,
//! rule by rule; then once more against what the rules generate.

use core::fmt::Display;

use crate::computer::{Begin, Phase, Rules};
use crate::given::Given;
use crate::violation::{Rule, Violation};
use crate::world::{begin, needs, rules};

pub(crate) fn check(given: &Given<'_>) -> Vec<Violation> {
    let rules = rules(given.scene);
    let phases = &given.world.phases;
    let mut all = ordered(&rules, phases);
    if !all.is_empty() {
        return all;
    }
    all.extend(
        phases
            .iter()
            .enumerate()
            .flat_map(|(i, phase)| {
                [
                    wakeup(given, &rules, i, phase),
                    shutdown(&rules, phase),
                    awake(given, &rules, i, phase),
                ]
            })
            .flatten(),
    );
    all.extend(sleeps(given, &rules));
    all.extend(full(given, &rules));
    all.extend(covered(given));
    all.extend(blocks(given, &rules));
    all.extend(generated(given));
    all
}

fn ordered(rules: &Rules, phases: &[Phase]) -> Vec<Violation> {
    let within = |p: &Phase| rules.now <= p.wakeup && p.asleep <= rules.end;
    let inside = phases
        .iter()
        .filter(|p| !(p.wakeup <= p.up && p.up <= p.down && p.down <= p.asleep && within(p)));
    let pairs = phases.windows(2).filter(|pair| pair[0].asleep > pair[1].wakeup);
    let wrong = inside.chain(pairs.map(|pair| &pair[1]));
    wrong.map(|p| Violation::new(Rule::Generated, None, p.wakeup).detail("out of order")).collect()
}

fn wakeup(given: &Given<'_>, rules: &Rules, i: usize, phase: &Phase) -> Option<Violation> {
    let after_block = rules.blocks.iter().any(|(_, end)| *end == phase.wakeup);
    let first = i == 0 && phase.wakeup == rules.now;
    let length = match begin(given.scene) {
        Begin::Up { .. } if first => 0,
        Begin::Waking { up } if first => up - rules.now,
        _ if after_block => 0,
        _ => rules.wakeup,
    };
    // What comes too late is cut off by a manual block, or by the end.
    let blocks = rules.blocks.iter().map(|(start, _)| *start);
    let stop = blocks.filter(|start| *start >= phase.wakeup).fold(rules.end, i64::min);
    let off = phase.up - phase.wakeup - length.min(stop - phase.wakeup);
    (off != 0).then(|| Violation::new(Rule::Wakeup, None, phase.wakeup).by(off))
}

fn shutdown(rules: &Rules, phase: &Phase) -> Option<Violation> {
    let at_block = rules.blocks.iter().any(|(start, _)| *start == phase.down);
    let cut = phase.down == rules.end && phase.asleep == rules.end;
    let length = if at_block || cut { 0 } else { rules.shutdown };
    let off = phase.asleep - phase.down - length;
    (off != 0).then(|| Violation::new(Rule::Shutdown, None, phase.down).by(off))
}

/// The shortest awake phase: what was before now counts. One that could not begin
/// earlier, since it begins now, or as soon as the computer is asleep that shuts
/// down now, or when a manual block ends, may be cut short.
fn awake(given: &Given<'_>, rules: &Rules, i: usize, phase: &Phase) -> Option<Violation> {
    let allowed = match begin(given.scene) {
        Begin::Up { floor } if i == 0 => floor,
        _ => phase.up + rules.min_awake,
    };
    let cut = phase.down == rules.end || rules.blocks.iter().any(|(start, _)| *start == phase.down);
    let first = match begin(given.scene) {
        Begin::Asleep { since } => since.max(rules.now),
        _ => rules.now,
    };
    let bound = phase.wakeup == first || rules.blocks.iter().any(|b| b.1 == phase.wakeup);
    let off = allowed - phase.down;
    (off > 0 && !(cut && bound)).then(|| Violation::new(Rule::MinAwake, None, phase.up).by(off))
}

/// The shortest sleep: what was before now counts, and the last one may be cut.
fn sleeps(given: &Given<'_>, rules: &Rules) -> Vec<Violation> {
    let since = match begin(given.scene) {
        Begin::Asleep { since } => Some(since),
        _ => None,
    };
    let phases = &given.world.phases;
    // A sleep in progress ends early where the world does not ask, or where the
    // battery is as full as it may be in a sleep.
    let unasked = given.base.flaws.iter().any(|flaw| flaw.index.is_none());
    let room = |at: i64| rules.most - given.world.charge.at(at);
    let first = since.zip(phases.first()).map(|(since, phase)| (since, phase.wakeup));
    let first = first.filter(|(_, wakeup)| !unasked && room(*wakeup) >= rules.surplus);
    let between = phases.windows(2).map(|pair| (pair[0].asleep, pair[1].wakeup));
    let manual = |at: i64| rules.blocks.iter().any(|(start, _)| *start == at);
    let between = between.filter(|(asleep, _)| !manual(*asleep));
    let short = first.into_iter().chain(between).filter(|(from, to)| to - from < rules.min_sleep);
    short
        .map(|(from, to)| {
            Violation::new(Rule::MinSleep, None, from).by(rules.min_sleep - (to - from))
        })
        .collect()
}

/// No sleep goes past the maximum.
fn full(given: &Given<'_>, rules: &Rules) -> Vec<Violation> {
    let past = given.sleeps().into_iter().filter_map(|(from, to)| {
        let (at, by) = given.world.charge.first_above(rules.most, (from, to))?;
        // Too full at the begin of a plan that begins asleep: it wakes at once.
        (to > from).then(|| Violation::new(Rule::Full, None, at).by(by))
    });
    past.collect()
}

/// The computer is up for all that needs it.
fn covered(given: &Given<'_>) -> Vec<Violation> {
    let scene = given.scene;
    let known = &given.base.flaws;
    let up = |start: i64, end: i64| {
        given.world.phases.iter().any(|phase| phase.up <= start && end <= phase.down)
    };
    let windows = known.is_empty();
    let needs = needs(scene, &given.world.placed, &given.world.heatings, windows);
    let needs = needs.into_iter().map(|(start, end)| (start.max(scene.now), end.min(scene.end)));
    let dark = needs.filter(|(start, end)| start < end && !up(*start, *end));
    // What runs already is a fact: a manual block that it overlaps is, too.
    let facts: Vec<i64> = scene.fixed.iter().map(|fixed| fixed.start.max(scene.now)).collect();
    let dark = dark.filter(|(start, _)| !facts.contains(start));
    dark.map(|(start, end)| {
        Violation::new(Rule::Computer, None, start).detail(format!("needed until {end} ms"))
    })
    .collect()
}

/// Manual blocks have the computer to themselves.
fn blocks(given: &Given<'_>, rules: &Rules) -> Vec<Violation> {
    let over = rules.blocks.iter().filter(|(start, end)| {
        given.world.phases.iter().any(|p| p.wakeup < *end && *start < p.asleep)
    });
    over.map(|(start, _)| Violation::new(Rule::Manual, None, *start)).collect()
}

/// The rules generate just that.
fn generated(given: &Given<'_>) -> Vec<Violation> {
    let (world, derived) = (&given.world, &given.derived);
    let phase = first_difference(&world.phases, &derived.phases);
    let phase = phase.map(|(found, wanted)| {
        let at = found.or(wanted).map_or(0, |phase| phase.wakeup);
        let detail = differ(found, wanted);
        Violation::new(Rule::Generated, None, at).detail(detail)
    });
    let heating = first_difference(&world.heatings, &derived.heatings).map(|(found, wanted)| {
        let short = match (&found, &wanted) {
            (None, Some(_)) => true,
            (Some(found), Some(wanted)) => found.start >= wanted.start,
            _ => false,
        };
        let rule = if short { Rule::Heating } else { Rule::HeatedTwice };
        let at = wanted.as_ref().or(found.as_ref()).map_or(0, |heating| heating.start);
        let detail = differ(found, wanted);
        Violation::new(rule, None, at).detail(detail)
    });
    phase.into_iter().chain(heating).collect()
}

/// What the plan has, and what it should have.
fn differ<T: Display>(found: Option<T>, wanted: Option<T>) -> String {
    let say = |one: Option<T>| one.map_or_else(|| "nothing".into(), |one| one.to_string());
    format!("the plan has {}, the rules give {}", say(found), say(wanted))
}

fn first_difference<T: Clone + PartialEq>(a: &[T], b: &[T]) -> Option<(Option<T>, Option<T>)> {
    let length = a.len().max(b.len());
    let pairs = (0..length).map(|i| (a.get(i).cloned(), b.get(i).cloned()));
    pairs.into_iter().find(|(a, b)| a != b)
}
