"""A call in a loop does its expensive things once: counted, not timed."""

import sys
from collections import Counter
from collections.abc import Callable
from types import FrameType

import lienumba
from lienumba.mechanics.system.output_variables import usual
from tests.rigs.places import SCENARIOS

TOP = SCENARIOS / "heavy_top.toml"
OF_A_SCENARIO = (
    "scenario.resolve._resolved", "scenario.resolve.to_dict", "scenario.base.toml.dumps", "engine.results._fates",
    "scenario.start.prepare._nominal_start", "mechanics.start.assembly._assemble",
)  # fmt: skip
OF_RUNS = (
    "scenario.start.prepare.prepare", "engine.programs.batch_of", "integrators.tracing.template.split",
    "batch.integrate.integrate", "engine.results.piece", "engine.results.dataset",
)  # fmt: skip


def counted(function: Callable[[], object]) -> Counter[str]:
    """How often functions of lienumba are called, by module and name."""
    calls: Counter[str] = Counter()

    def note(frame: FrameType, event: str, _: object) -> None:
        module = frame.f_globals.get("__name__", "")
        if event == "call" and module.startswith("lienumba."):
            calls[f"{module.removeprefix('lienumba.')}.{frame.f_code.co_name}"] += 1

    sys.setprofile(note)
    try:
        function()
    finally:
        sys.setprofile(None)
    return calls


def test_a_run_reads_starts_and_labels_once() -> None:
    lienumba.run(TOP)
    calls = counted(lambda: lienumba.run(TOP))
    assert {name: calls[name] for name in (*OF_A_SCENARIO, *OF_RUNS)} == dict.fromkeys((*OF_A_SCENARIO, *OF_RUNS), 1)


def test_a_prepared_scenario_is_not_read_again() -> None:
    ready = lienumba.prepare(TOP)
    ready.run()
    calls = counted(ready.run)
    assert {name: calls[name] for name in OF_RUNS} == dict.fromkeys(OF_RUNS, 1)
    assert not [name for name in OF_A_SCENARIO if calls[name]]


def test_each_variable_is_computed_once() -> None:
    ready = lienumba.prepare(TOP)
    ready.run()
    assert counted(ready.run)["mechanics.system.output_variables.values"] == len(usual())


def test_more_runs_are_no_more_calls() -> None:
    ready = lienumba.prepare(TOP)

    def calls(runs: int) -> int:
        samples = {"bodies.top.mass": [14.0 + n for n in range(runs)]}
        ready.run(samples=samples)
        found = counted(lambda: ready.run(samples=samples))
        return sum(count for name, count in found.items() if "<" not in name and not name.startswith("scenario."))

    assert calls(8) == calls(2)
