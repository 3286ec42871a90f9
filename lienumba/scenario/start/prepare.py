"""Before anything runs: the samples, the model with its numbers, the initial states, and whether they fit together."""

from collections.abc import Mapping, Sequence
from functools import partial
from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from lienumba.batch.statuses import INVALID, NO_EQUILIBRIUM, NOT_ASSEMBLED, SUCCESS
from lienumba.errors import Problem, ScenarioError
from lienumba.integrators.codes import NONE_FOUND
from lienumba.keys.formulas import at_start
from lienumba.mechanics.elements.drivers import POSITION, type_of
from lienumba.mechanics.elements.forces import law_of
from lienumba.mechanics.elements.joints import JOINTS, named
from lienumba.mechanics.elements.quantities import POSITION as OF_POSITIONS
from lienumba.mechanics.elements.quantities import bodies_of, evaluate, is_input, level
from lienumba.mechanics.mechanism.kinematics import Instant, View
from lienumba.mechanics.mechanism.model import Counted, Driver, Law, Model, Start, Vec3, reads_state
from lienumba.mechanics.mechanism.model_numbers import map_numbers
from lienumba.mechanics.mechanism.tables import RunNumbers
from lienumba.mechanics.start import assembly, joint_frames
from lienumba.mechanics.start.assembly import Assembly
from lienumba.mechanics.system import constraints, rank
from lienumba.mechanics.system.applied_forces import generalized
from lienumba.mechanics.system.rank import Rank
from lienumba.mechanics.system.switches import at_start as beginning
from lienumba.mechanics.system.switches import permanent, switches_of
from lienumba.mechanics.tree.links import with_ways
from lienumba.mechanics.tree.spanning import closing_rows, idle
from lienumba.scenario.base.problems import Report
from lienumba.scenario.checks.times import looked_at
from lienumba.scenario.resolve import Scenario
from lienumba.scenario.start.build import build, refuse_invalid, unphysical
from lienumba.scenario.start.violations import NOT_FINITE, violations
from lienumba.words import listed

CLOSE = 1e-9  # how far what a joint and its driver say of the start may differ, relative to it


class Prepared(NamedTuple):
    """labels (runs,), samples by path (runs,), the model with arrays where it varies, states (runs, 18 k), angles of
    joints (runs,), codes; nominal: the start from which all runs choose the same rows of the redundant ones first;
    rests (runs,): the kinds of their equilibria (`codes.EQUILIBRIA`), and rotation, of axes against which they rest
    (rad/s, global, floats or arrays), where they start in such."""

    labels: list[int]
    samples: dict[str, np.ndarray]
    model: Model
    states: np.ndarray
    angles: dict[Counted, np.ndarray]
    codes: np.ndarray
    nominal: "Nominal"
    rests: np.ndarray | None = None
    rotation: Vec3 | None = None


class Nominal(NamedTuple):
    """The mechanism with its nominal numbers, at its start; `typical`: a state a little later if the start is singular,
    else the start; rank: there, of what holds at the start;
    lasting: of what is never turned on or off; built, assembled: what `scenario` says, and what became of that; rests:
    the kind of equilibrium in which it starts, where it does in one."""

    scenario: Scenario
    model: Model
    now: Instant
    typical: Instant
    rank: Rank
    lasting: Rank
    built: tuple[Model, Start]
    assembled: Assembly
    rests: int | None = None

    @property
    def singular(self) -> bool:
        return self.typical is not self.now


def check_initial(scenario: Scenario) -> Nominal:
    """The nominal start; a ScenarioError if it does not fit the joints, or the joints do not fit each other."""
    try:
        with np.errstate(all="ignore"):
            return _nominal_start(scenario)
    except np.linalg.LinAlgError:
        raise ScenarioError(NOT_FINITE) from None


def _nominal_start(scenario: Scenario) -> Nominal:
    model, start = build(scenario, {})
    _check_start(model, start)
    done = assembly.assemble(model, start, 1)
    problems = violations(done, start, 0)
    if problems and not _only_prescribed(done, start):
        raise ScenarioError(*problems)
    now = done.instant(0)
    whole, rests = with_ways(rank.nominal(done.model), now.bodies), None
    if start.rotation is not None and not problems:
        from lienumba.scenario.start.resting import resting

        rested = resting(whole, done.state.reshape(1, -1), done.angles, start.rotation)
        now, rests = rested.instant(0), int(rested.status[0])
    nominal, lasting = beginning(whole), permanent(whole)
    typical, found = now, _rank(nominal, now)
    certain = found.rank == found.rows and not nominal.drivers  # then nothing can contradict itself
    unmet = () if certain else rank.contradiction(nominal, now)
    if problems and not unmet:
        raise ScenarioError(*problems)
    if later := rank.on_the_way(nominal, now, found):
        typical, found = later, rank.rank_of(nominal, later)
    if unmet:
        raise ScenarioError.at(
            "model",
            (
                f"{listed(unmet)} contradict each other: there are {found.rows} equations of rank {found.rank} "
                f"for {found.rank + found.freedom} velocities, and no motion fulfils them all"
            ),
            (
                "remove a driver or a joint of these, correct what it prescribes, or, if this is a dead point, "
                "give velocities that fit or start beside it"
            ),
        )
    _check_massless(lasting, now)
    if nominal.drivers:
        _check_drivers(nominal, now)
        _check_played(scenario, nominal)
    _check_forces(whole, now)
    if whole.limits or whole.contacts or whole.events:
        from lienumba.scenario.start.stops import problems_of_captures, problems_of_stops

        if touching := problems_of_stops(whole, now):
            raise ScenarioError(*touching)
        if never := problems_of_captures(whole, now, scenario.data.integrator.end_time):
            raise ScenarioError(*never)
    if scenario.data.integrator.engine is not None:
        _check_engine(scenario, whole, now)
    always = _rank(lasting, typical) if switches_of(whole) else found
    return Nominal(scenario, whole, now, typical, found, always, (model, start), done, rests)


def _check_engine(scenario: Scenario, model: Model, now: Instant) -> None:
    """The engine that is asked for must know all that the mechanism has."""
    from lienumba.scenario.start.reference_engine import problems_of_engine

    if problems := problems_of_engine(scenario.data, model, now):
        raise ScenarioError(*problems)


def _rank(model: Model, now: Instant) -> Rank:
    return rank.rank_of(model, now) if closing_rows(model) else rank.independent(model)


def _only_prescribed(done: Assembly, start: Start) -> bool:
    """Whether positions fit and no velocity is given: then what does not fit is prescribed by drivers."""
    given = [x for pose in start.poses for x in (pose.velocity, pose.angular_velocity)]
    for joint, says in zip(done.model.joints, start.joints, strict=True):
        given += [says.known.get(x.rate) for x in JOINTS[joint.type].freedoms()]
    fits = bool((done.position_violations <= done.position_limits).all())
    return fits and all(x is None for x in given) and bool(done.model.drivers)


def _check_massless(model: Model, now: Instant) -> None:
    """Every motion moves a mass."""
    if loose := rank.moving_no_mass(model, now):
        raise ScenarioError.at(
            f"model.bodies.{loose[0]}.mass",
            f"at the start {listed(loose)} can move while nothing that has a mass does",
            "give a mass, joints that tie it to bodies with one, or the joint that moves it an armature",
            0.0,
        )
    for body in idle(model):
        raise ScenarioError.at(
            f"model.bodies.{model.bodies[body].name}.mass",
            "nothing that has a mass hangs on it in the tree of the joints",
            "give a mass, or the joint that carries it an armature",
            0.0,
        )


def _check_drivers(model: Model, now: Instant) -> None:
    """What a driver prescribes may not move exactly as what it drives."""
    if not any(reads_state(x) for driver in model.drivers for x in driver.value):
        return
    C = constraints.jacobian(model, now)
    moved = {row for (row, _), x in C.items() if abs(x) > CLOSE}
    for driver, rows in zip(model.drivers, constraints.rows_of(model)[len(model.joints) :], strict=False):
        if any(map(reads_state, driver.value)) and not moved.issuperset(range(rows.start, rows.stop)):
            raise ScenarioError.at(
                f"model.drivers.{driver.name}",
                "follows itself: what it prescribes moves as what it drives",
                "read another quantity",
            )


def _check_played(scenario: Scenario, model: Model) -> None:
    """What a driver reads of inputs may not jump, as what it reads of tables."""
    from lienumba.scenario.checks.drivers import check_function

    report = Report(times=looked_at(scenario.data.integrator))
    for driver in model.drivers:
        for x in driver.value:
            played = isinstance(x, Law) and any(map(is_input, x.quantities))
            if played and not bodies_of(model, x) and all(level(model, name) == OF_POSITIONS for name in x.quantities):
                at, text = f"model.drivers.{driver.name}", getattr(x.function, "text", "")
                check_function(at, text, partial(_at_time, model, x), driver.motion == "rate", report)
    if report.problems:
        raise ScenarioError(*report.problems)


def _at_time(model: Model, x: Law, t: Any) -> Any:
    return evaluate(model, x, View({}, t, {}))


def _check_forces(model: Model, now: Instant) -> None:
    """Forces must be finite at the start."""
    for force in model.forces:
        try:
            finite = all(map(isfinite, generalized(model, now, [force])))
        except ZeroDivisionError:
            raise ScenarioError.at(
                f"model.forces.{force.name}", "divides by zero at the start", "write it so that it is finite there"
            ) from None
        if not finite and force.code is not None and force.code.untraced:
            rule = f"calls {force.code.untraced[0]}, which raises at the start, or returns what is not finite"
            raise ScenarioError.at(f"model.forces.{force.name}", rule, "call it with numbers as they are at the start")
        if not finite:
            raise ScenarioError.at(f"model.forces.{force.name}", *law_of(force).infinite)


def _check_start(model: Model, start: Start) -> None:
    """What must be known before the joints can be placed."""
    problems: list[Problem] = []
    for joint, body in joint_frames.unplaced(model, start):
        says, name = start.joints[joint], model.bodies[body].name
        key = "at" if says.at is not None else "axis"
        problems.append(
            Problem(
                f"model.joints.{model.joints[joint].name}.{key}",
                f"is in the global frame, but where {name} is at the start is not given",
                (
                    f"give position and rotation of {name}, or give {'points' if key == 'at' else 'axes'} in the "
                    "bodies' own frames instead"
                ),
            )
        )
    for joint in joint_frames.without_zero(model, start):
        problems.append(
            Problem(
                f"model.joints.{model.joints[joint].name}",
                "its angle is prescribed at the start, but nothing says from where it counts",
                "give references = [[x, y, z], [x, y, z]], or the rotations of its bodies",
            )
        )
    for driver in model.drivers:
        problems += _contradicted(driver, model, start)
    if problems:
        raise ScenarioError(*problems)


def _contradicted(driver: Driver, model: Model, start: Start) -> list[Problem]:
    """What a joint says of its coordinate at the start, but its driver says otherwise."""
    if driver.coordinate is None or reads_state(driver.value[0]):
        return []
    driven = named(driver.coordinate.kind)
    keys = driven.name, driven.rate
    says, name = start.joints[driver.coordinate.joint], model.joints[driver.coordinate.joint].name
    prescribed = zip(
        keys if type_of(driver).level(driver) == POSITION else keys[1:], at_start(driver.value[0]), strict=False
    )
    return [
        Problem(
            f"model.drivers.{driver.name}",
            f"prescribes the {key} {number:.6g} at t = 0, but {_written(says.place(name, key), given)}",
            "leave the latter out",
        )
        for key, number in prescribed
        if (given := says.known.get(key)) is not None and abs(given - number) > CLOSE * max(1.0, abs(number))
    ]


def _written(place: str, given: float) -> str:
    """What a file says there."""
    return f"{place} = {'true' if place.endswith('.locked') else repr(given)}"


def design(scenario: Scenario, labels: Sequence[int]) -> dict[str, np.ndarray]:
    """The samples (runs,) of these runs, by path; a ScenarioError if they ask for what the scenario does not have."""
    if not scenario.data.sweep.vary and not scenario.parameters.tables:
        return {}
    from lienumba.scenario.checks.tables import check_samples
    from lienumba.scenario.start.design import draw

    samples = draw(scenario, labels)
    check_samples(scenario.parameters, samples, labels, scenario.data.integrator.end_time)
    return samples


def prepare(
    scenario: Scenario,
    labels: Sequence[int],
    samples: Mapping[str, np.ndarray] | None = None,
    nominal: Nominal | None = None,
    asked: int | None = None,
) -> Prepared:
    """Build and assemble these runs. A run that does not fit is marked; if none of a sweep fits, that is an error of
    the scenario. samples, nominal: if they are known; asked: how many runs there are in all."""
    data = scenario.data
    nominal = nominal or check_initial(scenario)
    samples = dict(design(scenario, labels) if samples is None else samples)
    asked = len(labels) if asked is None else asked
    runs = len(labels)
    if runs == 1 and not samples and nominal.scenario is scenario and not data.model.noise:
        (model, start), done = nominal.built, nominal.assembled
    else:
        with np.errstate(all="ignore"):  # a formula of parameters may divide by zero in some runs, which fail then
            model, start = build(scenario, samples, labels)
        done = assembly.assemble(model, start, runs)
    bad = unphysical(model, start, samples, runs)
    whole = 1 < runs == asked and asked >= data.sweep.runs
    if whole and bad.all():
        refuse_invalid(scenario, samples)
    good = done.good & _same_rank(done, nominal.lasting)
    if model.limits or model.contacts:
        from lienumba.scenario.start.stops import begin_beyond

        good &= ~begin_beyond(done.model, Instant(_rows(done.state), 0.0, {**done.angles}), runs)
    codes = np.where(bad, INVALID, np.where(good, SUCCESS, NOT_ASSEMBLED)).astype(np.int8)
    if whole and np.all(codes == NOT_ASSEMBLED):
        varied = ", ".join(samples)
        unmet = violations(done, start, 0)
        why = unmet[0] if unmet else "its state is not finite, its joints lock it, or it begins beyond a stop"
        rule = f"no sampled run can be assembled with {varied} varied"
        remedy = f"give fewer initial values, so that the joints can decide them. The first run: {why}"
        raise ScenarioError(Problem("sweep.vary", rule, remedy), *unmet[1:])
    states = np.where(np.isfinite(done.state), done.state, 0.0)
    model = with_ways(done.model, _rows(states), nominal.model)
    states = states.reshape(runs, -1)
    if start.rotation is None:
        return Prepared(list(labels), samples, model, states, done.angles, codes, nominal)
    from lienumba.scenario.start.resting import resting

    found, axes = resting(model, states, done.angles, start.rotation), start.rotation
    rests = np.where(codes == SUCCESS, found.status, NONE_FOUND).astype(np.int8)
    codes = np.where((codes == SUCCESS) & (rests == NONE_FOUND), NO_EQUILIBRIUM, codes).astype(np.int8)
    return Prepared(list(labels), samples, found.model, found.states, found.angles, codes, nominal, rests, axes)


def _rows(state: np.ndarray) -> tuple[tuple[np.ndarray, ...], ...]:
    """The states of bodies (runs, k, 18) as an Instant has them: of each body 18 arrays (runs,)."""
    return tuple(tuple(body.T) for body in state.transpose(1, 0, 2))


def _part(numbers: Any, runs: np.ndarray) -> Any:
    """What a table holds, of these runs."""
    return numbers.part(runs) if isinstance(numbers, RunNumbers) else numbers


def _same_rank(done: Assembly, nominal: Rank) -> np.ndarray:
    """Whether redundant rows are as many in each run as in the nominal one (runs,): where samples break the symmetry
    of an overconstrained mechanism, it cannot move."""
    same = np.ones(len(done.state), bool)
    if not nominal.exchangeable:
        return same
    good = np.flatnonzero(done.good)
    if len(good):
        model = map_numbers(permanent(done.model), lambda x, _: x[good] if np.ndim(x) else x, partial(_part, runs=good))
        now = Instant(_rows(done.state[good]), 0.0, {which: angle[good] for which, angle in done.angles.items()})
        same[good] = rank.ranks(model, now, len(good)) <= nominal.rank
    return same
