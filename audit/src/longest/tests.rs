use std::collections::BTreeMap;

use super::{Measure, longest};
use crate::body::{Body, Node};
use crate::code::{Flow, Instruction};
use crate::loops::{Loop, Region};

/// Each instruction costs one, each loop turns three times.
struct Three;

impl Measure for Three {
    fn cost(&self, _: u64) -> u64 {
        1
    }

    fn turns(&self, _: &Loop) -> u64 {
        3
    }
}

/// A function with these ways, entered at 0.
fn body(ways: &[(u64, &[u64])]) -> Body {
    let node = |(address, follow): &(u64, &[u64])| {
        let instruction = Instruction {
            address: *address,
            next: address + 1,
            flow: Flow::On,
            conditional: false,
            writes: Vec::new(),
            locked: false,
            breaks: None,
            text: String::new(),
        };
        let node = Node { instruction, follow: follow.to_vec(), calls: None, is_tail: false };
        (*address, node)
    };
    Body { entry: 0, nodes: ways.iter().map(node).collect::<BTreeMap<_, _>>() }
}

fn most(ways: &[(u64, &[u64])]) -> u64 {
    let body = body(ways);
    longest(&body, &Region::of(&body), &Three)
}

#[test]
fn the_longer_branch_counts() {
    assert_eq!(most(&[(0, &[1, 3]), (1, &[2]), (2, &[3]), (3, &[])]), 4);
}

#[test]
fn a_loop_counts_its_turns_and_one_way_out() {
    // 0, three times (1, 2), then 1, 2 once more on the way out, 3.
    assert_eq!(most(&[(0, &[1]), (1, &[2]), (2, &[1, 3]), (3, &[])]), 1 + 3 * 2 + 2 + 1);
}

#[test]
fn a_loop_that_looks_first_leaves_from_its_entry() {
    assert_eq!(most(&[(0, &[1]), (1, &[2, 3]), (2, &[1]), (3, &[])]), 1 + 3 * 2 + 1 + 1);
}

#[test]
fn a_loop_that_begins_the_function_is_a_loop() {
    assert_eq!(most(&[(0, &[0, 1]), (1, &[])]), 3 + 1 + 1);
}

#[test]
fn loops_in_loops_multiply() {
    // The inner one, 2, is 3 turns and 1 way out; the outer turn is 1, that, 3.
    let turn = 1 + 4 + 1;
    assert_eq!(
        most(&[(0, &[1]), (1, &[2]), (2, &[2, 3]), (3, &[1, 4]), (4, &[])]),
        1 + 3 * turn + turn + 1
    );
}

#[test]
fn a_loop_that_is_entered_in_the_middle_has_a_turn_more() {
    // Ways: 0 to 1 or 2; 1 to 2; 2 back to 1 or on to 3.
    assert_eq!(most(&[(0, &[1, 2]), (1, &[2]), (2, &[1, 3]), (3, &[])]), 1 + 4 * 2 + 2 + 1);
}

#[test]
fn what_is_left_of_a_loop_has_no_turns() {
    // From 1 the loop is left by 4, which does not lead back.
    assert_eq!(most(&[(0, &[1]), (1, &[2, 4]), (2, &[1]), (4, &[5]), (5, &[])]), 1 + 3 * 2 + 1 + 2);
}
