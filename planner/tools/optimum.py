#!/usr/bin/env python3
"""The best that can be made of small worlds, by an exact solver.

Reads lines of JSON from `small_worlds` and writes lines of CSV: activities,
seed, checksum, optimum, bound, total. CP-SAT chooses which activities run and
when, and when the computer is up, so that the sum of values is largest.

The model is the planner's own world but for two things. Starts lie on the
worlds' grid of five minutes, where the planner's are free to the millisecond:
the planner can come out above the optimum of the grid. And the solver may keep
the computer up or prolong a phase wherever it likes, where the planner has
rules for it: that only ever helps the solver.

Usage: optimum.py [--seconds LIMIT] < worlds.jsonl > optima.csv
"""

import argparse
import json
import sys

from ortools.sat.python import cp_model

STEP = 300_000  # ms


def steps(ms):
    """A time in steps; the worlds lie on the grid."""
    whole, rest = divmod(ms, STEP)
    if rest:
        raise SystemExit(f"{ms} ms do not lie on the grid of {STEP} ms")
    return whole


def starts_of(activity, end):
    """Every start on the grid that ranges, cutoffs and the plan's end leave."""
    length = steps(activity["duration"])
    found = set()
    for window in activity["starts"]:
        last = min(steps(window["to"]), min(steps(window["cutoff"]), end) - length)
        found.update(range(max(0, steps(window["from"])), last + 1))
    return length, sorted(found)


def require(condition, what):
    if not condition:
        raise SystemExit(f"this model does not know {what}")


def check(world):
    """What is not in the model must not be in the world."""
    plan, parameters, state = world["plan"], world["parameters"], world["state"]
    require(state["now"] == 0 and state["mode"] == "Asleep", "a computer that is up at the begin")
    require(not state["windows"] and not state["running"], "windows and running activities")
    require(parameters["max_soc"] == 1_000_000, "a largest charge below the capacity")
    require(plan["handover"] == plan["end"], "a handover before the end")
    for activity in plan["activities"]:
        require(activity["priority"] < parameters["mandatory_from"], "mandatory activities")
        require(activity["kind"] == "Generic" and activity["data"] >= 0, "other types")
        extras = ("after", "zones", "impacts", "constraints", "group")
        require(not any(activity[name] for name in extras), "what activities ask of others")


def computer(model, parameters, state, slots):
    """The computer in each step: up, waking up, shutting down, or asleep."""
    require(steps(parameters["wakeup"]["duration"]) == 1, "a wakeup that is not one step")
    require(steps(parameters["shutdown"]["duration"]) == 1, "a shutdown that is not one step")
    up, waking, closing, asleep = (
        [model.new_bool_var(f"{name}{t}") for t in range(slots)]
        for name in ("up", "waking", "closing", "asleep")
    )
    min_awake = steps(parameters["min_awake"])
    min_sleep = steps(parameters["min_sleep"])
    slept = -steps(state["mode_since"])
    for t in range(slots):
        model.add_exactly_one(up[t], waking[t], closing[t], asleep[t])
        before = t - 1
        if t == 0:
            model.add(up[0] == 0)
            model.add(closing[0] == 0)
            continue
        # Up comes after up or waking up, and so on.
        model.add_bool_or(up[before], waking[before]).only_enforce_if(up[t])
        model.add(asleep[before] == 1).only_enforce_if(waking[t])
        model.add(up[before] == 1).only_enforce_if(closing[t])
        model.add_bool_or(asleep[before], closing[before]).only_enforce_if(asleep[t])
        for later in range(t, min(t + min_awake, slots)):
            model.add(up[later] == 1).only_enforce_if(waking[before])
        for later in range(t, min(t + min_sleep, slots)):
            model.add(asleep[later] == 1).only_enforce_if(closing[before])
    for t in range(max(0, min_sleep - slept)):
        model.add(waking[t] == 0)
    # Waking up so late that the shortest awake phase does not fit is not done.
    for t in range(max(0, slots - min_awake), slots):
        model.add(waking[t] == 0)
    return up, waking, closing


def ceiling(ppm, capacity):
    return -(-ppm * capacity // 1_000_000)


def solve(world, seconds):
    check(world)
    plan, parameters, state = world["plan"], world["parameters"], world["state"]
    slots = steps(plan["end"])
    model = cp_model.CpModel()
    up, waking, closing = computer(model, parameters, state, slots)
    users = [[] for _ in range(slots)]
    chosen, worth, data = [], [], []
    for activity in plan["activities"]:
        length, starts = starts_of(activity, slots)
        choices = []
        for start in starts:
            choice = model.new_bool_var(f"{activity['id']}@{start}")
            choices.append(choice)
            for t in range(start, start + length):
                users[t].append((activity, choice))
        model.add_at_most_one(choices)
        value = activity["value"] if activity["value"] is not None else activity["priority"]
        chosen += choices
        worth += [value] * len(choices)
        data += [activity["data"]] * len(choices)
    # Nothing is sent down, so the volume is largest at the end.
    model.add(cp_model.LinearExpr.weighted_sum(chosen, data) <= plan["max_delta_data"])
    limits(model, parameters, users, (up, waking, closing))
    battery(model, plan, parameters, state, users, (up, waking, closing))
    model.maximize(cp_model.LinearExpr.weighted_sum(chosen, worth))
    solver = cp_model.CpSolver()
    solver.parameters.max_time_in_seconds = seconds
    solver.parameters.num_workers = 2
    status = solver.solve(model)
    if status not in (cp_model.OPTIMAL, cp_model.FEASIBLE):
        raise SystemExit(f"no solution: {solver.status_name(status)}")
    return round(solver.objective_value), round(solver.best_objective_bound)


def limits(model, parameters, users, phases):
    """Bits, engines and peak power, in each step."""
    up, waking, closing = phases
    for t, now in enumerate(users):
        # One at most of what shares a bit, and none where the computer is not up:
        # together that bounds fractions of starts much better than one by one.
        for bit in range(128):
            sharing = [choice for a, choice in now if a["resources"] >> bit & 1]
            if sharing:
                model.add(sum(sharing) <= up[t])
        for activity in {a["id"]: a for a, _ in now}.values():
            model.add(sum(c for a, c in now if a["id"] == activity["id"]) <= up[t])
        model.add(sum(a["engines"] * c for a, c in now) <= parameters["engines"])
        peak = sum(a["peak"] * c for a, c in now)
        peak += parameters["awake"]["peak"] * up[t]
        peak += parameters["wakeup"]["load"]["peak"] * waking[t]
        peak += parameters["shutdown"]["load"]["peak"] * closing[t]
        model.add(peak <= parameters["peak_limit"])


def battery(model, plan, parameters, state, users, phases):
    """Charge in mW x steps. It may be less than it is, never more, so clamping
    at the capacity is two inequalities."""
    up, waking, closing = phases
    soft = ceiling(parameters["soft_min_soc"], state["capacity"])
    least = [-(-soft // STEP)] * (len(users) + 1)
    handover = ceiling(plan["handover_min_soc"], state["capacity"])
    least[-1] = max(least[-1], -(-handover // STEP))
    capacity = state["capacity"] // STEP
    charges = [model.new_int_var(low, capacity, f"charge{t}") for t, low in enumerate(least)]
    model.add(charges[0] <= state["charge"] // STEP)
    for t, now in enumerate(users):
        net = parameters["rtg"] - parameters["base"]
        net -= parameters["awake"]["marginal"] * up[t]
        net -= parameters["wakeup"]["load"]["marginal"] * waking[t]
        net -= parameters["shutdown"]["load"]["marginal"] * closing[t]
        net -= sum(a["marginal"] * c for a, c in now)
        model.add(charges[t + 1] <= charges[t] + net)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=120, help="for each world")
    seconds = parser.parse_args().seconds
    print("activities,seed,checksum,optimum,bound,total")
    for line in sys.stdin:
        given = json.loads(line)
        optimum, bound = solve(given["world"], seconds)
        activities = given["world"]["plan"]["activities"]
        total = sum(a["value"] if a["value"] is not None else a["priority"] for a in activities)
        row = (given["activities"], given["seed"], given["checksum"], optimum, bound, total)
        print(*row, sep=",", flush=True)
        print(f"{row[0]} activities, seed {row[1]}: {optimum} of {total}", file=sys.stderr)


if __name__ == "__main__":
    main()
