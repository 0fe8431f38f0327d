"""A small world as an integer program: one variable for each start.

Everything lies on a grid: starts, durations, windows, heating, and what the
computer does. A step is one state of everything, so limits are rows, one for
each step. The world's plans and the program's solutions are the same, but for
what the solver may do and never gains by: keep the computer up or a zone heated
for longer than the plan makes it.
"""

from collections import defaultdict
from math import gcd, inf

STEP = 600_000  # ms


class Unknown(Exception):
    """What this model does not know."""


def require(condition, what):
    if not condition:
        raise Unknown(f"this model does not know {what}")


def steps(ms):
    """A time in steps; the worlds lie on the grid."""
    whole, rest = divmod(ms, STEP)
    require(rest == 0, f"{ms} ms, off the grid of {STEP} ms")
    return whole


def charge(ppm, capacity):
    """The least charge that is no less than these millionths, in mW x steps."""
    return -(-(-(-ppm * capacity // 1_000_000)) // STEP)


class Program:
    """Bounds of variables, and rows: lower <= sum of terms <= upper."""

    def __init__(self):
        self.bounds, self.rows, self.worth = [], [], {}

    def var(self, least=0, most=1):
        self.bounds.append((least, most))
        return len(self.bounds) - 1

    def binaries(self, count):
        return [self.var() for _ in range(count)]

    def row(self, least, terms, most):
        """Terms are pairs; those of one variable add up."""
        sums = defaultdict(int)
        for var, factor in terms:
            sums[var] += factor
        sums = {var: factor for var, factor in sums.items() if factor}
        common = gcd(*sums.values(), *(side for side in (least, most) if abs(side) < inf))
        if common > 1:
            sums = {var: factor // common for var, factor in sums.items()}
            least, most = (side if abs(side) == inf else side // common for side in (least, most))
        self.rows.append((least, sums, most))

    def at_most(self, terms, most):
        self.row(-inf, terms, most)


class World:
    """The program of a world, and which variable is which start."""

    def __init__(self, world):
        self.plan, self.parameters, self.state = (world[k] for k in ("plan", "parameters", "state"))
        self.activities = self.plan["activities"]
        self.slots = steps(self.plan["end"])
        self.program = Program()
        self.check()
        self.starts = {}  # (id, step): variable
        self.users = [[] for _ in range(self.slots)]  # (activity, variable)
        self.by_id = {a["id"]: a for a in self.activities}
        self.choose()
        self.computer()
        self.heat()
        self.limits()
        self.battery()

    def check(self):
        """What is not in the model must not be in the world."""
        parameters, state = self.parameters, self.state
        asleep = state["now"] == 0 and state["mode"] == "Asleep"
        require(asleep, "a computer that is up at the begin")
        require(not (state["running"] or state["ended"] or state["heating"]), "a plan in progress")
        require(parameters["max_soc"] == 1_000_000, "a largest charge below the capacity")
        for a in self.activities:
            require(a["kind"] == "Generic" and a["data"] >= 0, "other types")
            require(not (a["impacts"] or a["constraints"]), "named timelines")
            on = [status for after in a["after"] for status in after["statuses"]]
            require(all(status == "Succeeded" for status in on), "other dependencies")
        for window in state["windows"]:
            require(window["awake"] and window["data"] <= 0, "other windows")
            steps(window["start"]), steps(window["end"])

    def windows(self, t):
        """Those in progress."""
        at = t * STEP
        return [w for w in self.state["windows"] if w["start"] <= at < w["end"]]

    def value(self, activity):
        return activity["priority"] if activity["value"] is None else activity["value"]

    def total(self):
        """Of all that is wanted: of a group, its best member."""
        best = defaultdict(int)
        for a in self.activities:
            key = a["group"] or a["id"]
            best[key] = max(best[key], self.value(a))
        return sum(best.values())

    def mandatory(self):
        """Of each mandatory priority, the highest first: activities, by number."""
        levels = defaultdict(list)
        for a in self.activities:
            if a["priority"] >= self.parameters["mandatory_from"]:
                levels[a["priority"]].append(a["id"])
        return [ids for _, ids in sorted(levels.items(), reverse=True)]

    def starts_of(self, activity):
        """Every start on the grid that ranges, cutoffs and the plan's end leave."""
        length, found = steps(activity["duration"]), set()
        for window in activity["starts"]:
            last = min(steps(window["to"]), min(steps(window["cutoff"]), self.slots) - length)
            found.update(range(max(0, steps(window["from"])), last + 1))
        return length, sorted(found)

    def choose(self):
        """At most one start of each, and of each group."""
        program, groups = self.program, defaultdict(list)
        for a in self.activities:
            length, starts = self.starts_of(a)
            for s in starts:
                var = self.starts[a["id"], s] = program.var()
                program.worth[var] = self.value(a)
                for t in range(s, s + length):
                    self.users[t].append((a, var))
            own = [(var, 1) for _, var in self.of(a["id"])]
            program.at_most(own, 1)
            if a["group"] is not None:
                groups[a["group"]] += own
        for members in groups.values():
            program.at_most(members, 1)
        for a in self.activities:
            for after in a["after"]:
                self.wait(a, self.by_id[after["prior"]])

    def of(self, id):
        return [(s, var) for (other, s), var in self.starts.items() if other == id]

    def wait(self, activity, prior):
        """If it has started, the prior has ended before."""
        length = steps(prior["duration"])
        for s, _ in self.of(activity["id"]):
            terms = [(var, 1) for at, var in self.of(activity["id"]) if at <= s]
            terms += [(var, -1) for at, var in self.of(prior["id"]) if at + length <= s]
            self.program.at_most(terms, 0)

    def computer(self):
        """Up in a step or not; when it comes up, and when a shutdown begins."""
        program, parameters, slots = self.program, self.parameters, self.slots
        self.up, self.comes, self.goes = (program.binaries(slots) for _ in range(3))
        self.wakeup = steps(parameters["wakeup"]["duration"])
        self.shutdown = steps(parameters["shutdown"]["duration"])
        awake, asleep = steps(parameters["min_awake"]), steps(parameters["min_sleep"])
        slept = -steps(self.state["mode_since"])
        first = max(0, asleep - slept) + self.wakeup
        apart = self.shutdown + asleep + self.wakeup
        for t in range(slots):
            before = [(self.up[t - 1], -1)] if t else []
            turns = [(self.comes[t], -1), (self.goes[t], 1)]
            program.row(0, [(self.up[t], 1), *before, *turns], 0)
            # So long it stays up, and so long it stays down.
            lately = range(max(0, t - awake + 1), t + 1)
            program.at_most([(self.up[t], -1), *((self.comes[i], 1) for i in lately)], 0)
            lately = range(max(0, t - apart + 1), t + 1)
            program.at_most([(self.up[t], 1), *((self.goes[i], 1) for i in lately)], 1)
            if not first <= t <= slots - awake:
                program.at_most([(self.comes[t], 1)], 0)
            if t + self.shutdown > slots:
                program.at_most([(self.goes[t], 1)], 0)
            if self.windows(t):
                program.row(1, [(self.up[t], 1)], 1)

    def turning(self, t):
        """What makes it wake up, and shut down, in this step."""
        waking = range(t + 1, min(t + self.wakeup, self.slots - 1) + 1)
        closing = range(max(0, t - self.shutdown + 1), t + 1)
        return [self.comes[i] for i in waking], [self.goes[i] for i in closing]

    def heat(self):
        """A use needs its zone heated in each of the steps before it that the
        table asks for, but where another use ends after that step and began
        before this one: that keeps the zone warm, or is heated for itself."""
        program, day = self.program, self.parameters["day"]
        self.heated = {z["name"]: program.binaries(self.slots) for z in self.parameters["zones"]}
        for zone in self.parameters["zones"]:
            heated, table = self.heated[zone["name"]], zone["table"]
            for t in range(self.slots):
                program.at_most([(heated[t], 1), (self.up[t], -1)], 0)
            uses = [
                (s, s + steps(a["duration"]), var)
                for a in self.activities
                if zone["name"] in a["zones"]
                for s, var in self.of(a["id"])
            ]
            for s, _, var in uses:
                time = (s * STEP - day["midnight"]) % day["length"]
                long = [row["duration"] for row in table if row["from"] <= time][-1]
                for t in range(s - steps(long), s):
                    warm = [(use, -1) for begin, end, use in uses if begin < s and end > t]
                    own = [(heated[t], -1)] if t >= 0 else []
                    program.at_most([(var, 1), *own, *warm], 0)

    def limits(self):
        """Bits, engines and peak power in each step; data where they are most.

        What runs bounds the computer's state, too: together that bounds
        fractions of starts much better than one by one."""
        program, parameters = self.program, self.parameters
        for t, now in enumerate(self.users):
            up, windows = self.up[t], self.windows(t)
            for bit in range(128):
                sharing = [(var, 1) for a, var in now if a["resources"] >> bit & 1]
                held = any(w["resources"] >> bit & 1 for w in windows)
                if sharing:
                    program.at_most(sharing + ([] if held else [(up, -1)]), 0)
            for id in {a["id"] for a, _ in now}:
                own = [(var, 1) for a, var in now if a["id"] == id]
                program.at_most([*own, (up, -1)], 0)
            left = parameters["engines"] - sum(w["engines"] for w in windows)
            program.at_most([(up, -left)] + [(var, a["engines"]) for a, var in now], 0)
            left = parameters["peak_limit"] - parameters["awake"]["peak"]
            left -= sum(w["peak"] for w in windows)
            peak = [(var, a["peak"]) for a, var in now] + self.heating(t, "peak")
            program.at_most([(up, -left), *peak], 0)
        for phase in ("wakeup", "shutdown"):
            require(parameters[phase]["load"]["peak"] <= parameters["peak_limit"], "such a peak")
        self.data()

    def heating(self, t, what):
        return [(self.heated[z["name"]][t], z["load"][what]) for z in self.parameters["zones"]]

    def data(self):
        """Only a window's end makes it less, so it is most before that."""
        ends = sorted((steps(w["end"]), w["data"]) for w in self.state["windows"])
        sent = 0
        for end, data in [*ends, (self.slots, 0)]:
            made = [(var, self.by_id[id]["data"]) for (id, s), var in self.starts.items() if s < end]
            self.program.at_most(made, self.plan["max_delta_data"] + sent)
            sent -= data

    def battery(self):
        """Charge in mW x steps. It may be less than it is, never more, so what
        the capacity cuts off is two inequalities."""
        program, parameters, capacity = self.program, self.parameters, self.state["capacity"]
        least = [charge(parameters["soft_min_soc"], capacity)] * (self.slots + 1)
        handover = steps(self.plan["handover"])
        wanted = charge(self.plan["handover_min_soc"], capacity)
        least[handover] = max(least[handover], wanted)
        charges = [program.var(low, capacity // STEP) for low in least]
        program.at_most([(charges[0], 1)], self.state["charge"] // STEP)
        total, all_drawn = self.state["charge"] // STEP, []
        for t, now in enumerate(self.users):
            waking, closing = self.turning(t)
            net = parameters["rtg"] - parameters["base"]
            net -= sum(w["marginal"] for w in self.windows(t))
            drawn = [(self.up[t], parameters["awake"]["marginal"])]
            drawn += [(var, parameters["wakeup"]["load"]["marginal"]) for var in waking]
            drawn += [(var, parameters["shutdown"]["load"]["marginal"]) for var in closing]
            drawn += [(var, a["marginal"]) for a, var in now] + self.heating(t, "marginal")
            program.at_most([(charges[t + 1], 1), (charges[t], -1), *drawn], net)
            total += net
            all_drawn += drawn
            if t + 1 in (handover, self.slots):
                # The same summed up: a knapsack, which solvers know how to cut.
                program.at_most(all_drawn, total - least[t + 1])
