//! Bounded Validity: what each function of the library agrees to, what runs
//! out, and what no history of commands can obtain.

use faregate_tickets::amount::{Microjoules, Milligrams, MilligramsPerSecond, Milliwatts};
use faregate_tickets::clock::{Duration, Instant};
use faregate_tickets::device::Effect;
use faregate_tickets::telemetry::{Channel, Mode, Modes, Telemetry};
use faregate_tickets::validity::{
    Ask, Denial, Function, NoDutyCycle, RanOut, Rule, TooManyFunctions, Validity,
};

#[path = "validity/budgets.rs"]
mod budgets;
#[path = "validity/conditions.rs"]
mod conditions;
#[path = "validity/duty_cycle.rs"]
mod duty_cycle;
#[path = "validity/histories.rs"]
mod histories;

const W: u64 = 1_000;

fn at(us: u64) -> Instant {
    Instant::from_micros(us)
}

fn us(us: u64) -> Duration {
    Duration::from_micros(us)
}

fn on(draw: u64) -> Effect {
    Effect::on(Milliwatts::new(draw))
}

fn ask(now: u64, effect: Effect) -> Ask<'static> {
    Ask { now: at(now), effect, telemetry: None }
}

fn denial(rule: Rule, short_by: u64, until: Option<u64>) -> Result<(), Denial> {
    Err(Denial { rule, short_by, until: until.map(at) })
}

fn over(rule: Rule) -> Option<RanOut> {
    Some(RanOut { rule, ends_ticket: true })
}

/// What a gate does with a command: check, and only then commit.
fn invoke(validity: &mut Validity, now: u64, effect: Effect) -> Result<(), Denial> {
    let ask = ask(now, effect);
    validity.check(&ask)?;
    validity.commit(&ask);
    Ok(())
}

fn validity(function: Function) -> Validity {
    let mut validity = Validity::from(function);
    validity.admitted(Instant::START);
    validity
}

mod joining {
    use super::*;

    #[test]
    fn without_functions_everything_is_agreed_to_and_nothing_runs_out() {
        let mut always = Validity::all_of(&[]).unwrap();
        assert_eq!(always, Validity::always());
        assert_eq!(invoke(&mut always, u64::MAX, on(u64::MAX)), Ok(()));
        assert_eq!((always.ran_out(at(u64::MAX)), always.look_again_at(at(0))), (None, None));
        assert_eq!((always.lease(), always.has_interlock()), (None, false));
    }

    #[test]
    fn each_of_four_functions_can_refuse() {
        let others = Function::window(at(0), at(100));
        for place in 0..4 {
            let mut functions = [others; 4];
            functions[place] = Function::invocations(0);
            let validity = Validity::all_of(&functions).unwrap();
            assert_eq!(validity.check(&ask(1, on(W))), denial(Rule::Invocations, 1, None));
        }
    }

    #[test]
    fn each_of_four_functions_is_committed_and_can_run_out() {
        for place in 0..4 {
            let mut functions = [Function::invocations(9); 4];
            functions[place] = Function::energy(Microjoules::new(1));
            let mut validity = Validity::all_of(&functions).unwrap();
            assert_eq!(invoke(&mut validity, 0, on(1)), Ok(()));
            assert!(validity.look_again_at(at(0)).unwrap() <= at(1_000));
            assert_eq!(validity.ran_out(at(1_000)), over(Rule::Energy));
            validity.confirmed_off(at(400));
            assert_eq!(validity.ran_out(at(1_000)), None);
        }
    }

    #[test]
    fn a_fifth_function_is_refused_unless_it_limits_nothing() {
        let four = Validity::all_of(&[Function::invocations(1); 4]).unwrap();
        assert_eq!(four.and(Function::invocations(1)), Err(TooManyFunctions));
        assert_eq!(four.and(Function::always()), Ok(four));
        assert_eq!(Validity::all_of(&[Function::invocations(1); 5]), Err(TooManyFunctions));
    }

    #[test]
    fn of_two_limits_that_ran_out_the_one_that_ends_the_ticket_is_named() {
        let cycle = Function::duty_cycle(us(10), us(20)).unwrap();
        let limit = Function::time_limit(us(10));
        for functions in [[cycle, limit], [limit, cycle]] {
            let mut both = Validity::all_of(&functions).unwrap();
            both.commit(&ask(0, on(W)));
            assert_eq!(both.ran_out(at(10)), over(Rule::TimeLimit));
        }
    }

    #[test]
    fn two_budgets_leave_what_the_tighter_one_leaves() {
        let budgets = [10, 7].map(|uj| Function::energy(Microjoules::new(uj)));
        assert_eq!(Validity::all_of(&budgets).unwrap().energy_left(), Microjoules::new(7));
        assert_eq!(Validity::always().energy_left(), Microjoules::ZERO);
    }
}

mod authority {
    use super::*;

    #[test]
    fn a_window_is_open_from_its_beginning_until_just_before_its_end() {
        let window = validity(Function::window(at(10), at(20)));
        assert_eq!(window.check(&ask(7, on(W))), denial(Rule::Window, 3, Some(10)));
        assert_eq!(window.check(&ask(10, on(W))), Ok(()));
        assert_eq!(window.check(&ask(19, on(W))), Ok(()));
        assert_eq!(window.check(&ask(20, on(W))), denial(Rule::Window, 0, None));
        assert_eq!(window.check(&ask(25, on(W))), denial(Rule::Window, 5, None));
        assert_eq!((window.ran_out(at(19)), window.ran_out(at(20))), (None, over(Rule::Window)));
        assert_eq!(window.look_again_at(at(0)), Some(at(20)));
    }

    #[test]
    fn a_time_limit_runs_from_the_first_on_command_across_confirmed_off() {
        let mut limit = validity(Function::time_limit(us(100)));
        assert_eq!(invoke(&mut limit, 500, Effect::Unchanged), Ok(()));
        assert_eq!(limit.look_again_at(at(500)), None);
        assert_eq!(invoke(&mut limit, 1_000, on(W)), Ok(()));
        assert_eq!(invoke(&mut limit, 1_010, Effect::Off), Ok(()));
        limit.confirmed_off(at(1_020));
        assert_eq!(invoke(&mut limit, 1_050, on(W)), Ok(()));
        assert_eq!(limit.look_again_at(at(1_050)), Some(at(1_100)));
        assert_eq!(limit.check(&ask(1_107, on(W))), denial(Rule::TimeLimit, 7, None));
        assert_eq!(limit.ran_out(at(1_099)), None);
        assert_eq!(limit.ran_out(at(1_100)), over(Rule::TimeLimit));
    }

    #[test]
    fn a_time_limit_of_nothing_agrees_to_nothing() {
        let limit = validity(Function::time_limit(us(0)));
        assert_eq!(limit.check(&ask(5, on(W))), denial(Rule::TimeLimit, 0, None));
    }

    #[test]
    fn a_lease_starts_with_the_ticket_and_every_command_renews_it() {
        let mut lease = Validity::from(Function::lease(us(100)));
        assert_eq!(lease.check(&ask(5, on(W))), denial(Rule::Lease, 5, None));
        lease.admitted(at(1_000));
        assert_eq!(invoke(&mut lease, 1_099, Effect::Unchanged), Ok(()));
        assert_eq!(invoke(&mut lease, 1_198, Effect::Off), Ok(()));
        lease.renew(at(1_297));
        assert_eq!(lease.look_again_at(at(1_297)), Some(at(1_397)));
        assert_eq!(lease.ran_out(at(1_396)), None);
        assert_eq!(lease.ran_out(at(1_397)), over(Rule::Lease));
        assert_eq!(lease.lease(), Some(us(100)));
    }

    #[test]
    fn a_lease_that_is_over_is_not_renewed_but_restored() {
        let mut lease = validity(Function::lease(us(100)));
        lease.renew(at(100));
        assert_eq!(lease.check(&ask(100, on(W))), denial(Rule::Lease, 0, None));
        lease.admitted(at(200));
        assert_eq!(lease.check(&ask(299, on(W))), Ok(()));
    }

    #[test]
    fn who_may_not_command_may_not_turn_off_either() {
        let ended =
            [Function::window(at(0), at(1)), Function::time_limit(us(0)), Function::lease(us(1))];
        for function in ended {
            assert!(validity(function).check(&ask(1, Effect::Off)).is_err(), "{function:?}");
        }
    }
}

mod commands {
    use super::*;

    #[test]
    fn so_many_invocations_are_agreed_to_and_no_more() {
        let mut three = validity(Function::invocations(3));
        for _ in 0..3 {
            assert_eq!(invoke(&mut three, 0, Effect::Unchanged), Ok(()));
        }
        assert_eq!(invoke(&mut three, 0, on(W)), denial(Rule::Invocations, 1, None));
    }

    #[test]
    fn the_last_invocation_may_leave_the_device_on() {
        let mut one = validity(Function::invocations(1));
        assert_eq!(invoke(&mut one, 0, on(W)), Ok(()));
        assert_eq!((one.ran_out(at(9)), one.look_again_at(at(9))), (None, None));
    }

    #[test]
    fn a_rate_allows_its_burst_and_then_one_per_period() {
        let mut rate = validity(Function::rate(2, us(100)));
        assert_eq!(invoke(&mut rate, 1_000, on(W)), Ok(()));
        assert_eq!(invoke(&mut rate, 1_000, on(W)), Ok(()));
        assert_eq!(invoke(&mut rate, 1_000, on(W)), denial(Rule::Rate, 100, Some(1_100)));
        assert_eq!(invoke(&mut rate, 1_099, on(W)), denial(Rule::Rate, 1, Some(1_100)));
        assert_eq!(invoke(&mut rate, 1_100, on(W)), Ok(()));
        assert_eq!(invoke(&mut rate, 1_150, on(W)), denial(Rule::Rate, 50, Some(1_200)));
    }

    #[test]
    fn a_burst_of_none_never_agrees() {
        let rate = validity(Function::rate(0, us(100)));
        for now in [0, 1, u64::MAX] {
            assert_eq!(
                rate.check(&ask(now, on(W))).map_err(|d| (d.rule, d.until)),
                Err((Rule::Rate, None))
            );
        }
    }

    #[test]
    fn commands_keep_their_separation() {
        let mut apart = validity(Function::separation(us(100)));
        assert_eq!(invoke(&mut apart, 0, on(W)), Ok(()));
        assert_eq!(invoke(&mut apart, 99, on(W)), denial(Rule::Separation, 1, Some(100)));
        assert_eq!(invoke(&mut apart, 100, on(W)), Ok(()));
        assert_eq!(invoke(&mut apart, 150, on(W)), denial(Rule::Separation, 50, Some(200)));
    }

    #[test]
    fn turning_off_is_neither_refused_nor_counted() {
        let mut limits = Validity::all_of(&[
            Function::invocations(1),
            Function::rate(1, us(100)),
            Function::separation(us(100)),
        ])
        .unwrap();
        assert_eq!(invoke(&mut limits, 0, Effect::Off), Ok(()));
        assert_eq!(invoke(&mut limits, 0, on(W)), Ok(()));
        assert!(limits.check(&ask(0, on(W))).is_err());
        assert_eq!(invoke(&mut limits, 0, Effect::Off), Ok(()));
    }
}

mod a_clock_that_goes_back {
    use super::*;

    #[test]
    fn counts_no_use_twice() {
        let cycle = Function::duty_cycle(us(100), us(200)).unwrap();
        for function in [Function::energy(Microjoules::new(100)), cycle] {
            let mut limits = validity(function);
            invoke(&mut limits, 1_000, on(W)).unwrap();
            invoke(&mut limits, 500, on(W)).unwrap();
            assert_eq!(limits.ran_out(at(1_099)), None);
            assert!(limits.ran_out(at(1_100)).is_some());
        }
    }

    #[test]
    fn earns_no_rest_twice() {
        let mut cycle = validity(Function::duty_cycle(us(100), us(200)).unwrap());
        invoke(&mut cycle, 1_000, on(W)).unwrap();
        cycle.confirmed_off(at(1_090));
        invoke(&mut cycle, 500, on(W)).unwrap();
        assert_eq!(cycle.ran_out(at(1_099)), None);
        assert!(cycle.ran_out(at(1_100)).is_some());
    }

    #[test]
    fn takes_no_lease_away() {
        let mut lease = validity(Function::lease(us(100)));
        lease.admitted(at(1_000));
        lease.renew(at(500));
        assert_eq!(lease.ran_out(at(1_099)), None);
        assert_eq!(lease.ran_out(at(1_100)), over(Rule::Lease));
    }

    #[test]
    fn brings_no_command_closer() {
        for function in [Function::separation(us(100)), Function::rate(1, us(100))] {
            let mut limits = validity(function);
            invoke(&mut limits, 1_000, on(W)).unwrap();
            assert!(limits.check(&ask(500, on(W))).is_err());
            // Not agreed to, but committed all the same: it has to be survived.
            limits.commit(&ask(500, on(W)));
            assert!(limits.check(&ask(1_099, on(W))).is_err());
        }
    }
}

mod words {
    use super::*;

    #[test]
    fn a_denial_says_which_rule_by_how_much_and_until_when() {
        let refusal =
            |rule, short_by, until| denial(rule, short_by, until).unwrap_err().to_string();
        assert_eq!(
            refusal(Rule::Rate, 5, Some(2_000_000)),
            "command rate exceeded: short by 5 us, until 2.000000 s"
        );
        assert_eq!(refusal(Rule::Energy, 7, None), "energy budget used up: short by 7 uJ");
        assert_eq!(
            refusal(Rule::TelemetryAge, u64::MAX, None),
            "telemetry too old: never measured"
        );
        assert_eq!(refusal(Rule::Mode, 0, None), "not in this mode");
    }
}
