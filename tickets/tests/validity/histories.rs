//! What no history of commands can obtain.

use super::*;
use proptest::collection::vec;
use proptest::prelude::*;

#[derive(Clone, Copy, Debug)]
enum Event {
    Invoke(Effect),
    /// Seen off, by a measurement this long ago.
    SeenOff(u64),
    Admitted,
    Renew,
}

fn effect() -> impl Strategy<Value = Effect> {
    let on = (0_u64..5_000, 0_u64..50).prop_map(|(draw, flow)| Effect::On {
        draw: Milliwatts::new(draw),
        flow: MilligramsPerSecond::new(flow),
    });
    prop_oneof![4 => on, 1 => Just(Effect::Unchanged), 1 => Just(Effect::Off)]
}

fn event() -> impl Strategy<Value = Event> {
    prop_oneof![
        6 => effect().prop_map(Event::Invoke),
        3 => (0_u64..200).prop_map(Event::SeenOff),
        1 => Just(Event::Admitted),
        1 => Just(Event::Renew),
    ]
}

/// Events with the time since the one before.
fn history() -> impl Strategy<Value = Vec<(u64, Event)>> {
    vec((0_u64..2_000, event()), 1..40)
}

fn function() -> impl Strategy<Value = Function> {
    let cycle =
        |(on, rest)| Function::duty_cycle(us(on), us(on + rest)).expect("both are positive");
    prop_oneof![
        (0_u64..20_000).prop_map(|until| Function::window(at(0), at(until))),
        (0_u64..20_000).prop_map(|limit| Function::time_limit(us(limit))),
        (0_u64..5_000).prop_map(|period| Function::lease(us(period))),
        (0_u32..10).prop_map(Function::invocations),
        (0_u32..5, 0_u64..3_000).prop_map(|(n, period)| Function::rate(n, us(period))),
        (0_u64..3_000).prop_map(|min| Function::separation(us(min))),
        (1_u64..5_000, 1_u64..5_000).prop_map(cycle),
        (0_u64..50_000).prop_map(|uj| Function::energy(Microjoules::new(uj))),
        (0_u64..50).prop_map(|mg| Function::propellant(Milligrams::new(mg))),
    ]
}

fn functions() -> impl Strategy<Value = Validity> {
    vec(function(), 1..=4).prop_map(|functions| {
        let mut validity = Validity::all_of(&functions).expect("at most four");
        validity.admitted(at(0));
        validity
    })
}

fn happen(validity: &mut Validity, now: u64, event: Event) -> Result<(), Denial> {
    match event {
        Event::Invoke(effect) => invoke(validity, now, effect)?,
        Event::SeenOff(ago) => validity.confirmed_off(at(now.saturating_sub(ago))),
        Event::Admitted => validity.admitted(at(now)),
        Event::Renew => validity.renew(at(now)),
    }
    Ok(())
}

fn after(mut validity: Validity, history: &[(u64, Event)]) -> (Validity, u64) {
    let mut now = 0;
    for (wait, event) in history {
        now += wait;
        let _ = happen(&mut validity, now, *event);
    }
    (validity, now)
}

/// When the device was on, and with which draw in mW.
#[derive(Default)]
struct OnTimes {
    past: Vec<(u64, u64, u64)>,
    present: Option<(u64, u64)>,
}

impl OnTimes {
    fn ends(&mut self, now: u64) {
        if let Some((since, draw)) = self.present.take() {
            self.past.push((since, now, draw));
        }
    }

    fn turned_on(&mut self, now: u64, draw: u64) {
        self.ends(now);
        self.present = Some((now, draw));
    }

    /// A measurement counts only if it is later than the On command.
    fn seen_off(&mut self, at: u64) {
        if self.present.is_some_and(|(since, _)| at > since) {
            self.ends(at);
        }
    }

    fn nanojoules(&self) -> u128 {
        let one = |(from, to, draw): &(u64, u64, u64)| u128::from(to - from) * u128::from(*draw);
        self.past.iter().map(one).sum()
    }

    fn within(&self, begin: u64, end: u64) -> u64 {
        let one =
            |(from, to, _): &(u64, u64, u64)| (*to).min(end).saturating_sub((*from).max(begin));
        self.past.iter().map(one).sum()
    }
}

/// Runs a history beside an agent who looks when told to, and turns the
/// device off as soon as something has run out. Answers when it was on.
fn under_an_agent(validity: &mut Validity, history: &[(u64, Event)]) -> OnTimes {
    let mut times = OnTimes::default();
    let mut now = 0;
    for (wait, event) in history {
        let next = now + wait;
        while let Some(look) = validity.look_again_at(at(now)).filter(|look| *look <= at(next)) {
            now = look.as_micros().max(now);
            if validity.ran_out(look).is_some() {
                validity.confirmed_off(at(now));
                times.seen_off(now);
                break;
            }
        }
        now = next;
        if happen(validity, now, *event).is_err() {
            continue;
        }
        match *event {
            Event::Invoke(Effect::On { draw, .. }) => times.turned_on(now, draw.get()),
            Event::SeenOff(ago) => times.seen_off(now.saturating_sub(ago)),
            _ => {}
        }
    }
    let end = now + 1;
    validity.confirmed_off(at(end));
    times.seen_off(end);
    times
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    #[test]
    fn no_history_obtains_more_energy_than_the_budget(uj in 0_u64..50_000, history in history()) {
        let mut energy = validity(Function::energy(Microjoules::new(uj)));
        let used = under_an_agent(&mut energy, &history).nanojoules();
        let budget = u128::from(uj) * 1_000;
        // The microsecond in which it runs out is the granularity.
        prop_assert!(used < budget.max(1) + 5_000, "{used} nJ of {budget}");
        let left = budget.saturating_sub(used) / 1_000;
        prop_assert_eq!(u128::from(energy.energy_left().get()), left);
    }

    #[test]
    fn no_history_obtains_more_on_time_than_its_rest_earned(
        share in 1_u64..3_000,
        rest in 1_u64..3_000,
        history in history(),
    ) {
        let mut cycle = validity(Function::duty_cycle(us(share), us(share + rest)).unwrap());
        let times = under_an_agent(&mut cycle, &history);
        for (from, _, _) in &times.past {
            for (_, to, _) in &times.past {
                let span = to.saturating_sub(*from);
                let spent = times.within(*from, *to);
                // One microsecond of granularity each time that it is turned on.
                let bound = (share + times.past.len() as u64) * rest + (span - spent) * share;
                prop_assert!(spent * rest <= bound, "{spent} us on in {from}..{to}");
            }
            prop_assert!(times.within(*from, from + share + rest) <= 2 * share);
        }
    }

    #[test]
    fn no_history_obtains_more_commands_than_the_rate(
        burst in 0_u32..5,
        period in 1_u64..3_000,
        history in history(),
    ) {
        let mut rate = validity(Function::rate(burst, us(period)));
        let mut now = 0;
        let mut agreed = Vec::new();
        for (wait, _) in &history {
            now += wait;
            if invoke(&mut rate, now, Effect::Unchanged).is_ok() {
                agreed.push(now);
            }
        }
        for (i, from) in agreed.iter().enumerate() {
            for (j, to) in agreed.iter().enumerate().skip(i) {
                let count = (j - i + 1) as u64;
                prop_assert!(count <= u64::from(burst) + (to - from) / period);
            }
        }
    }

    #[test]
    fn a_look_is_never_late(
        limits in functions(),
        history in history(),
        first in 0_u64..10_000,
        later in 0_u64..10_000,
    ) {
        let (limits, now) = after(limits, &history);
        let (first, later) = (now + first, now + first + later);
        if limits.ran_out(at(later)).is_some() {
            let look = limits.look_again_at(at(first));
            prop_assert!(look.is_some_and(|look| look <= at(later)), "{look:?} > {later}");
        }
    }

    #[test]
    fn looking_again_converges(limits in functions(), history in history()) {
        let (limits, mut now) = after(limits, &history);
        let mut looks = 0;
        while limits.ran_out(at(now)).is_none() {
            let Some(look) = limits.look_again_at(at(now)) else { break };
            prop_assert!(look > at(now));
            now = look.as_micros();
            looks += 1;
            // Four functions, each halving what is left of at most 2^36 us.
            prop_assert!(looks < 4 * 36);
        }
    }

    #[test]
    fn what_ran_out_refuses_to_turn_on(
        limits in functions(),
        history in history(),
        later in 0_u64..10_000,
    ) {
        let (limits, now) = after(limits, &history);
        if limits.ran_out(at(now + later)).is_some() {
            prop_assert!(limits.check(&ask(now + later, on(1))).is_err());
            prop_assert!(limits.check(&ask(now + later, Effect::Unchanged)).is_err());
        }
    }

    #[test]
    fn a_refusal_ends_exactly_when_it_says(
        limit in function(),
        history in history(),
        later in 0_u64..10_000,
    ) {
        let (limit, now) = after(validity(limit), &history);
        if let Err(Denial { until: Some(until), .. }) = limit.check(&ask(now + later, on(1))) {
            prop_assert!(until > at(now + later));
            let just_before = until.as_micros() - 1;
            prop_assert!(limit.check(&ask(just_before, on(1))).is_err());
            prop_assert_eq!(limit.check(&ask(just_before + 1, on(1))), Ok(()));
        }
    }

    #[test]
    fn no_clock_gives_back_what_was_used(
        uj in any::<u64>(),
        history in vec((any::<u64>(), event()), 1..40),
    ) {
        let mut energy = validity(Function::energy(Microjoules::new(uj)));
        let mut left = energy.energy_left();
        for (now, event) in history {
            let _ = happen(&mut energy, now, event);
            prop_assert!(energy.energy_left() <= left);
            left = energy.energy_left();
        }
    }

    #[test]
    fn no_number_makes_a_function_panic(
        parameters in any::<[u64; 6]>(),
        counts in any::<[u32; 2]>(),
        events in vec((any::<u64>(), any::<u64>(), event()), 1..20),
    ) {
        let [a, b, c, d, e, f] = parameters;
        let cycle = Function::duty_cycle(us(a.min(b)), us(a.max(b)));
        let all = [
            Function::window(at(a), at(b)),
            Function::time_limit(us(c)),
            Function::lease(us(d)),
            Function::invocations(counts[0]),
            Function::rate(counts[1], us(e)),
            Function::separation(us(f)),
            cycle.unwrap_or(Function::always()),
            Function::energy(Microjoules::new(a)),
            Function::propellant(Milligrams::new(b)),
        ];
        for function in all {
            let mut limit = Validity::from(function);
            for (now, amount, event) in &events {
                let _ = happen(&mut limit, *now, *event);
                let flow = MilligramsPerSecond::new(*amount);
                let most = Effect::On { draw: Milliwatts::new(*amount), flow };
                let _ = invoke(&mut limit, *now, most);
                let ran_out = limit.ran_out(at(*amount));
                let look = limit.look_again_at(at(*now));
                if ran_out.is_some() && amount >= now {
                    prop_assert!(look.is_some_and(|look| look <= at(*amount)));
                }
            }
        }
    }
}
