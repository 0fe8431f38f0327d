//! The duty cycle: on-time that rest earns back.

use super::*;

fn three_of_ten() -> Validity {
    validity(Function::duty_cycle(us(300), us(1_000)).expect("300 of 1000"))
}

const MUST_REST: Option<RanOut> = Some(RanOut { rule: Rule::DutyCycle, ends_ticket: false });

#[test]
fn nothing_and_everything_are_no_duty_cycles() {
    assert_eq!(Function::duty_cycle(us(0), us(10)), Err(NoDutyCycle));
    assert_eq!(Function::duty_cycle(us(10), us(10)), Err(NoDutyCycle));
    assert_eq!(Function::duty_cycle(us(11), us(10)), Err(NoDutyCycle));
    assert!(Function::duty_cycle(us(9), us(10)).is_ok());
}

#[test]
fn a_device_that_was_on_for_its_share_must_rest_for_the_whole_remainder() {
    let mut cycle = three_of_ten();
    invoke(&mut cycle, 0, on(W)).unwrap();
    assert_eq!((cycle.ran_out(at(299)), cycle.ran_out(at(300))), (None, MUST_REST));
    assert_eq!(cycle.check(&ask(300, on(W))), denial(Rule::DutyCycle, 700, None));
    assert_eq!(cycle.rests_until(), None);
    cycle.confirmed_off(at(310));
    assert_eq!((cycle.ran_out(at(311)), cycle.rests_until()), (None, Some(at(1_010))));
    assert_eq!(cycle.check(&ask(1_000, on(W))), denial(Rule::DutyCycle, 10, Some(1_010)));
    assert_eq!(invoke(&mut cycle, 1_010, on(W)), Ok(()));
    assert_eq!(cycle.ran_out(at(1_309)), None);
    assert_eq!(cycle.ran_out(at(1_310)), MUST_REST);
}

#[test]
fn a_short_rest_earns_its_share_and_no_rest_earns_more_than_the_bucket_holds() {
    let mut cycle = three_of_ten();
    invoke(&mut cycle, 0, on(W)).unwrap();
    cycle.confirmed_off(at(200));
    // 100 us are left, and 140 us of rest earn 60 more.
    invoke(&mut cycle, 340, on(W)).unwrap();
    assert_eq!((cycle.ran_out(at(499)), cycle.ran_out(at(500))), (None, MUST_REST));
    cycle.confirmed_off(at(341));
    invoke(&mut cycle, 1_000_000, on(W)).unwrap();
    assert_eq!(cycle.ran_out(at(1_000_299)), None);
    assert_eq!(cycle.ran_out(at(1_000_300)), MUST_REST);
}

#[test]
fn turning_off_is_agreed_to_and_is_not_yet_rest() {
    let mut cycle = three_of_ten();
    invoke(&mut cycle, 0, on(W)).unwrap();
    assert_eq!(invoke(&mut cycle, 100, Effect::Off), Ok(()));
    assert_eq!(cycle.ran_out(at(300)), MUST_REST);
}

#[test]
fn seeing_it_off_again_does_not_start_the_rest_again() {
    let mut cycle = three_of_ten();
    invoke(&mut cycle, 0, on(W)).unwrap();
    cycle.confirmed_off(at(300));
    cycle.confirmed_off(at(600));
    assert_eq!(cycle.rests_until(), Some(at(1_000)));
}
