//! The example sols show what their descriptions say.

#[expect(dead_code, reason = "each test program uses a part of it")]
mod support;

use std::collections::BTreeSet;
use std::fs;

use faregate_planner::plan::Kind;
use faregate_planner::timed::{Fate, Limit, Reason};
use faregate_planner::units::Time;
use faregate_planner::{Activity, ActivityId, Parameters, Plan, TimedPlan, file};
use serde_json::Value;
use support::{Said, Scratch, call, root};

/// An example, planned.
struct Sol {
    plan: Plan,
    parameters: Parameters,
    timed: TimedPlan,
    document: Value,
    said: Said,
}

fn read(name: &str) -> (String, Vec<u8>) {
    let path = root().join("examples/sols").join(name);
    let bytes = fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    (name.to_owned(), bytes)
}

fn sol(name: &str) -> Sol {
    let (file_name, bytes) = read("parameters.xml");
    let parameters = file::parameters(&file_name, &bytes).expect("parameters").value;
    let (file_name, bytes) = read(&format!("{name}/plan.xml"));
    let plan = file::plan(&file_name, &bytes, Some(&parameters)).expect("a plan").value;
    let scratch = Scratch::new();
    let out = scratch.path("timed.json");
    let sols = root().join("examples/sols");
    let path = |name: &str| sols.join(name).to_str().expect("a path of letters").to_owned();
    let said = call(&[
        "plan".to_owned(),
        "make".to_owned(),
        path(&format!("{name}/plan.xml")),
        "--parameters".to_owned(),
        path("parameters.xml"),
        "--state".to_owned(),
        path(&format!("{name}/state.xml")),
        "--format".to_owned(),
        "json".to_owned(),
        "--out".to_owned(),
        out.to_str().expect("a path of letters").to_owned(),
    ]);
    let text = fs::read(&out).unwrap_or_else(|error| panic!("{error}: {said:?}"));
    let timed = serde_json::from_slice(&text).expect("a timed plan");
    Sol { plan, parameters, timed, document: said.json(), said }
}

impl Sol {
    fn activity(&self, id: ActivityId) -> &Activity {
        self.plan.activities.iter().find(|activity| activity.id == id).expect("it is in the plan")
    }

    fn is_mandatory(&self, id: ActivityId) -> bool {
        self.activity(id).priority >= self.parameters.mandatory_from
    }

    fn out(&self) -> impl Iterator<Item = (ActivityId, &Reason)> {
        self.timed.rows.iter().filter_map(|row| match &row.fate {
            Fate::Out(reason) => Some((row.id, reason)),
            _ => None,
        })
    }

    fn scheduled(&self) -> usize {
        self.timed.rows.iter().filter(|row| self.timed.slot(row.id).is_some()).count()
    }

    /// What the left-out optional ones that are stopped by a limit are stopped by.
    fn limits(&self) -> Vec<Limit> {
        let limits = self.out().filter_map(|(_, reason)| match reason {
            Reason::Limit { limit, .. } => Some(limit.clone()),
            _ => None,
        });
        limits.collect()
    }

    fn is_stopped_by(&self, limit: &Limit) -> bool {
        self.limits().contains(limit)
    }

    /// Sleeps: from the plan's first instant to its end.
    fn sleeps(&self) -> usize {
        let begins =
            [None].into_iter().chain(self.timed.awake.iter().map(|phase| Some(phase.asleep)));
        let ends = self.timed.awake.iter().map(|phase| phase.wakeup).chain([self.plan.end]);
        begins.zip(ends).filter(|(begin, end)| begin.is_none_or(|begin| begin < *end)).count()
    }

    /// Uses of a zone that was warm already, from a use before.
    fn shared_zones(&self) -> BTreeSet<&str> {
        let uses = self
            .plan
            .activities
            .iter()
            .filter_map(|activity| Some((activity, self.timed.slot(activity.id)?.start)));
        let cold = |zone: &str, start: Time| {
            self.timed.preheats.iter().any(|preheat| preheat.zone == zone && preheat.end == start)
        };
        let warm = uses.flat_map(|(activity, start)| {
            activity.zones.iter().map(String::as_str).filter(move |zone| !cold(zone, start))
        });
        warm.collect()
    }

    fn expanded(&self) -> usize {
        let expanding = self
            .plan
            .activities
            .iter()
            .filter(|activity| matches!(activity.kind, Kind::Expanding { .. }));
        let longer = expanding.filter(|activity| {
            let slot = self.timed.slot(activity.id);
            slot.is_some_and(|slot| slot.length() > activity.placed())
        });
        longer.count()
    }

    fn missed(&self) -> Vec<ActivityId> {
        let out = self.out().filter(|(id, reason)| {
            self.is_mandatory(*id)
                && self.activity(*id).kind != Kind::Cleanup
                && !matches!(reason, Reason::GroupTaken(_) | Reason::WaitsForOutcome(_))
        });
        out.map(|(id, _)| id).collect()
    }

    fn keeps_every_limit(&self) {
        assert_eq!(self.document["violations"], Value::Array(Vec::new()), "{}", self.said.err);
    }
}

#[test]
fn the_busy_sol_leaves_something_out_for_each_reason_and_everything_mandatory_is_in() {
    let sol = sol("busy");
    assert_eq!(sol.said.code, 0, "{}{}", sol.said.out, sol.said.err);
    sol.keeps_every_limit();
    assert!(sol.plan.activities.len() >= 30, "{}", sol.plan.activities.len());
    for limit in [Limit::SoftMinimum, Limit::Handover, Limit::Peak, Limit::Data] {
        assert!(sol.is_stopped_by(&limit), "{limit:?}: {:#?}", sol.out().collect::<Vec<_>>());
    }
    let reasons = || sol.out().map(|(_, reason)| reason);
    assert!(reasons().any(|reason| matches!(reason, Reason::GroupTaken(_))));
    assert!(reasons().any(|reason| matches!(reason, Reason::PriorOut(_))));
    assert!(reasons().any(|reason| matches!(reason, Reason::WaitsForOutcome(_))));
    assert_eq!(sol.missed(), []);
}

#[test]
fn the_busy_sol_sleeps_heats_shares_a_zone_and_lengthens_the_drive() {
    let sol = sol("busy");
    assert!(sol.sleeps() >= 2, "{:#?}", sol.timed.awake);
    assert!(sol.timed.preheats.len() >= 4, "{:#?}", sol.timed.preheats);
    assert!(!sol.shared_zones().is_empty());
    assert_eq!(sol.expanded(), 1);
}

#[test]
fn the_winter_sol_leaves_out_for_want_of_energy_alone() {
    let sol = sol("winter");
    assert_eq!(sol.said.code, 0, "{}{}", sol.said.out, sol.said.err);
    sol.keeps_every_limit();
    let limits = sol.limits();
    assert!(
        limits.contains(&Limit::SoftMinimum) && limits.contains(&Limit::Handover),
        "{limits:?}"
    );
    let of_energy = [Limit::SoftMinimum, Limit::Handover];
    assert!(limits.iter().all(|limit| of_energy.contains(limit)), "{limits:?}");
    assert!(limits.len() >= 4 && sol.scheduled() >= 5, "{limits:?}");
}

#[test]
fn the_conjunction_leaves_out_for_want_of_memory_alone_and_wakes_before_the_battery_is_too_full() {
    let sol = sol("conjunction");
    assert_eq!(sol.said.code, 0, "{}{}", sol.said.out, sol.said.err);
    sol.keeps_every_limit();
    let limits = sol.limits();
    assert!(limits.len() >= 4 && limits.iter().all(|limit| *limit == Limit::Data), "{limits:?}");
    assert_eq!(sol.out().count(), limits.len());
    let freed = sol.plan.activities.iter().find(|activity| activity.data.get() < 0).expect("one");
    assert!(sol.timed.slot(freed.id).is_some(), "what frees memory is never refused for it");
    let idle = sol.timed.awake.iter().filter(|phase| {
        let slots = sol.timed.rows.iter().filter_map(|row| sol.timed.slot(row.id));
        !slots.into_iter().any(|slot| slot.start < phase.down && phase.up < slot.end)
    });
    assert!(idle.count() >= 1, "{:#?}", sol.timed.awake);
}

#[test]
fn a_plan_that_cannot_be_met_ends_with_2_and_says_why() {
    let sol = sol("too-much");
    assert_eq!(sol.said.code, 2, "{}{}", sol.said.out, sol.said.err);
    sol.keeps_every_limit();
    let missed = sol.missed();
    assert!(missed.len() >= 3, "{missed:?}");
    let reasons: Vec<_> = sol.out().map(|(_, reason)| reason).collect();
    assert!(reasons.iter().any(|reason| matches!(reason, Reason::PriorOut(_))), "{reasons:#?}");
    for limit in [Limit::SoftMinimum, Limit::Computer] {
        assert!(sol.is_stopped_by(&limit), "{limit:?}: {reasons:#?}");
    }
    assert!(
        sol.timed.excess.iter().any(|excess| excess.limit == Limit::Data),
        "{:?}",
        sol.timed.excess
    );
    let unavoidable = &sol.timed.unavoidable;
    assert!(unavoidable.iter().any(|excess| excess.limit == Limit::Handover), "{unavoidable:?}");
}

#[test]
fn the_document_has_these_names_and_no_others() {
    let sol = sol("too-much");
    let names = |value: &Value| {
        let object = value.as_object().expect("an object");
        object.keys().cloned().collect::<BTreeSet<_>>()
    };
    let set = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<BTreeSet<_>>();
    let whole = ["activities", "awake", "excess", "timelines", "unavoidable", "violations"];
    assert_eq!(names(&sol.document), set(&whole));
    for row in sol.document["activities"].as_array().expect("rows") {
        assert_eq!(names(row), set(&["id", "status", "start_s", "end_s", "reason"]));
        let is_out = row["status"] == "left_out";
        assert_eq!(row["start_s"].is_null(), is_out, "{row}");
        assert_eq!(row["reason"].is_string(), is_out, "{row}");
    }
    for row in sol.document["excess"].as_array().expect("rows") {
        assert_eq!(names(row), set(&["by", "limit", "amount"]));
    }
    for phase in sol.document["awake"].as_array().expect("phases") {
        assert!(phase[0].as_f64() < phase[1].as_f64(), "{phase}");
    }
    let timelines = sol.document["timelines"].as_object().expect("timelines");
    for name in ["charge", "peak", "data", "awake", "engines"] {
        assert!(!timelines[name].as_array().expect("points").is_empty(), "{name}");
    }
}
