#!/usr/bin/env python3
"""The best that can be made of small worlds, by an exact solver.

Reads lines of JSON from `small_worlds` and writes lines of CSV: activities,
seed, checksum, optimum, bound, total, and the plan that is worth the optimum, as
numbers of activities with the steps at which they start. Values are of
mandatory and optional activities together; of the mandatory ones as many are in
as can be, the most important first. Where time was up, the bound is above the
optimum. The total is of all activities, and of a group its best member's.

HiGHS maximises the program that model.py makes of a world. Each of the plans
that come with a world is forced into the program first: where one does not fit,
the model is wrong, and that is an error.

Usage: optimum.py [--seconds LIMIT] [--verify] < worlds.jsonl > optima.csv
"""

import argparse
import json
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from math import inf, isclose
from os import cpu_count

import highspy
import numpy

from model import STEP, Unknown, World


class Wrong(Exception):
    """The model is, or the planner."""


def sides(values):
    """As HiGHS wants them."""
    infinite = {inf: highspy.kHighsInf, -inf: -highspy.kHighsInf}
    return numpy.array([infinite.get(value, value) for value in values], float)


def linear(program, fixed, worth):
    """The program as HiGHS takes it; some variables are fixed."""
    bounds = list(program.bounds)
    for var, value in fixed.items():
        bounds[var] = (value, value)
    lp = highspy.HighsLp()
    lp.num_col_, lp.num_row_ = len(bounds), len(program.rows)
    lp.col_lower_, lp.col_upper_ = (sides(side) for side in zip(*bounds))
    lp.col_cost_ = sides(worth.get(var, 0) for var in range(len(bounds)))
    lp.sense_ = highspy.ObjSense.kMaximize
    lower, rows, upper = zip(*program.rows)
    lp.row_lower_, lp.row_upper_ = sides(lower), sides(upper)
    lp.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    lp.a_matrix_.start_ = numpy.cumsum([0, *map(len, rows)])
    lp.a_matrix_.index_ = numpy.array([var for row in rows for var in row])
    lp.a_matrix_.value_ = sides(factor for row in rows for factor in row.values())
    kinds = highspy.HighsVarType
    is_binary = ((least, most) == (0, 1) for least, most in program.bounds)
    # Charges follow from what is chosen.
    lp.integrality_ = [kinds.kInteger if binary else kinds.kContinuous for binary in is_binary]
    return lp


def solver(program, seconds, fixed={}, worth=None):
    """Ready to run; without a worth of variables, values are maximised."""
    highs = highspy.Highs()
    for name, value in {
        "output_flag": False,
        "threads": 1,
        "time_limit": float(seconds),
        "mip_rel_gap": 0.0,
        # Values are whole numbers.
        "mip_abs_gap": 0.99,
    }.items():
        highs.setOptionValue(name, value)
    highs.passModel(linear(program, fixed, program.worth if worth is None else worth))
    return highs


def force(world, plan, seconds):
    """The plan must be one of the program's solutions, of the same value."""
    for id, at in plan:
        if (id, at / STEP) not in world.starts:
            raise Wrong(f"activity {id} starts at {at} ms, where the model has no start")
    chosen = {world.starts[id, at // STEP] for id, at in plan}
    fixed = {var: int(var in chosen) for var in world.starts.values()}
    highs = solver(world.program, seconds, fixed)
    highs.run()
    if highs.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        status = highs.modelStatusToString(highs.getModelStatus())
        raise Wrong(f"a plan of the planner's does not fit into the model: {status}")
    value = sum(world.value(world.by_id[id]) for id, _ in plan)
    if not isclose(highs.getObjectiveValue(), value):
        raise Wrong("a plan of the planner's has another value in the model")
    return fixed, value


def require_mandatory(world, plans, seconds):
    """As many of each mandatory priority as can be, the highest first."""
    for ids in world.mandatory():
        starts = {var: 1 for id in ids for _, var in world.of(id)}
        known = max((sum(fixed[var] for var in starts) for fixed, _ in plans), default=0)
        if known < len(ids):
            highs = solver(world.program, seconds, worth=starts)
            highs.run()
            if highs.getModelStatus() != highspy.HighsModelStatus.kOptimal:
                raise Unknown("how many mandatory activities can be in: time is up")
            known = round(highs.getObjectiveValue())
        world.program.row(known, starts.items(), known)
        plans = [plan for plan in plans if sum(plan[0][var] for var in starts) == known]
    return plans


def solve(line, seconds, verify):
    """One world: a row, and a line for people."""
    given, begin = json.loads(line), time.monotonic()
    which = f"{given['activities']} activities, seed {given['seed']}"
    try:
        world = World(given["world"])
        plans = [force(world, plan, seconds) for plan in given["plans"]]
        if verify:
            return (), f"{which}: {len(plans)} plans fit into the model"
        plans = require_mandatory(world, plans, seconds)
    except (Unknown, Wrong) as error:
        return None, f"{which}: {error}"
    highs, known = solver(world.program, seconds), 0
    if plans:
        fixed, known = max(plans, key=lambda plan: plan[1])
        hint = numpy.array(list(fixed), numpy.int32), numpy.array(list(fixed.values()), float)
        highs.setSolution(len(fixed), *hint)
    highs.run()
    info, chosen = highs.getInfo(), highs.getSolution().col_value
    optimum, bound = round(info.objective_function_value), int(info.mip_dual_bound + 1e-6)
    if optimum < known or bound < optimum:
        return None, f"{which}: {optimum} is below what is known, or above {bound}"
    plan = " ".join(f"{id}@{s}" for (id, s), var in world.starts.items() if chosen[var] > 0.5)
    head = [given[name] for name in ("activities", "seed", "checksum")]
    proven = "proven" if bound == optimum else f"at most {bound}"
    told = f"{which}: {optimum} of {world.total()}, {proven}, {time.monotonic() - begin:.1f} s"
    return (*head, optimum, bound, world.total(), plan), told


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=120, help="for each world")
    parser.add_argument("--verify", action="store_true", help="only force the plans into the model")
    chosen = parser.parse_args()
    if not chosen.verify:
        print("activities,seed,checksum,optimum,bound,total,plan")
    lines, wrong, proven = sys.stdin.readlines(), 0, 0
    with ProcessPoolExecutor(cpu_count()) as pool:
        limits = [chosen.seconds] * len(lines), [chosen.verify] * len(lines)
        for number, (row, told) in enumerate(pool.map(solve, lines, *limits), 1):
            print(f"[{number}/{len(lines)}] {told}", file=sys.stderr, flush=True)
            wrong += row is None
            if row:
                proven += row[3] == row[4]
                print(*row, sep=",", flush=True)
    print(f"{len(lines)} worlds, {wrong} wrong, {proven} optima proven", file=sys.stderr)
    sys.exit(1 if wrong or not lines else 0)


if __name__ == "__main__":
    main()
