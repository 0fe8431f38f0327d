//! Documents drawn at random, each one that can be loaded.

mod parameters;
mod plan;
mod state;

use faregate_agents::Categories;
use faregate_tickets::amount::Milliwatts;
use proptest::collection::btree_set;
use proptest::prelude::*;

use self::parameters::parameters;
use self::plan::plan;
use self::state::state;
use crate::parameters::{Load, Parameters, Phase};
use crate::plan::Plan;
use crate::state::State;
use crate::units::{Bytes, Ppm, Span, Time};

/// What all three of a set are.
pub(super) type Three = (Parameters, Plan, State);

pub(super) fn three() -> impl Strategy<Value = Three> {
    parameters().prop_flat_map(|parameters| {
        let (plan, state) = (plan(&parameters), state(parameters.clone()));
        (Just(parameters), plan, state)
    })
}

/// With everything that has to be escaped, and spaces where they hurt.
fn name() -> impl Strategy<Value = String> + Clone {
    "[a-z<>&\"'é;#\u{a0}🚀 ]{1,9}"
        .prop_filter("a name shows something", |name| !name.trim().is_empty())
}

fn names() -> impl Strategy<Value = Vec<String>> {
    btree_set(name(), 1..5).prop_map(|names| names.into_iter().collect())
}

fn time() -> impl Strategy<Value = Time> + Clone {
    prop_oneof![-9_i64..9, -200_000_000_i64..900_000_000, Just(60_000)].prop_map(Time::new)
}

fn span(from: i64) -> impl Strategy<Value = Span> + Clone {
    prop_oneof![from..9_999_999, (from..500).prop_map(move |min| (min * 60_000).max(from))]
        .prop_map(Span::new)
}

fn power() -> impl Strategy<Value = Milliwatts> + Clone {
    prop_oneof![Just(0), 0_u64..2_000_000, (0_u64..300).prop_map(|w| w * 1_000)]
        .prop_map(Milliwatts::new)
}

fn data() -> impl Strategy<Value = Bytes> + Clone {
    prop_oneof![Just(0), -99_999_999_i64..99_999_999, (-50_i64..50).prop_map(|mb| mb * 1_000_000)]
        .prop_map(Bytes::new)
}

fn fraction() -> impl Strategy<Value = Ppm> {
    prop_oneof![0_i64..=1_000_000, (0_i64..=100).prop_map(|of| of * 10_000)].prop_map(Ppm::new)
}

fn load() -> impl Strategy<Value = Load> {
    (power(), power()).prop_map(|(marginal, peak)| Load { marginal, peak })
}

fn phase() -> impl Strategy<Value = Phase> {
    (span(0), load()).prop_map(|(duration, load)| Phase { duration, load })
}

/// A smallest and a largest value; often none.
fn limits() -> impl Strategy<Value = (i64, i64)> + Clone {
    let end = prop_oneof![Just(i64::MIN), Just(i64::MAX), -99_i64..99, any::<i64>()];
    (end.clone(), end).prop_map(|(one, other)| (one.min(other), one.max(other)))
}

/// The first few more often: those of a plan or a window then often have a name.
fn bit() -> impl Strategy<Value = u8> {
    prop_oneof![0_u8..8, 0_u8..128]
}

fn bits() -> impl Strategy<Value = Categories> {
    prop_oneof![
        Just(Categories::NONE),
        btree_set(bit(), 0..5).prop_map(|bits| {
            Categories::from_mask(bits.into_iter().fold(0, |mask, bit| mask | 1 << bit))
        }),
    ]
}

fn zones_of(parameters: &Parameters) -> Vec<String> {
    parameters.zones.iter().map(|zone| zone.name.clone()).collect()
}
