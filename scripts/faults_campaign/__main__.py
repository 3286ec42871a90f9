"""python -m faults_campaign [KILLS [SEED [DATASETS]]]"""

import sys
import tempfile
from pathlib import Path

from faults_campaign.attack import campaign as attack
from faults_campaign.kills import Report, at_every_change, campaign
from faults_campaign.removals import removals

SCENARIO = Path(__file__).parents[2] / "scenarios" / "heavy_top_monte_carlo.toml"
OPTIONS = [
    "--set", "sweep.runs=12000", "--set", "integrator.step=1e-4", "--set", "output.every=0.1",
    "--set", "output.mode=summary", "--set", 'output.full_runs="100:4000"',
]  # fmt: skip
SHORT = [*OPTIONS[:1], "sweep.runs=64", *OPTIONS[2:6], "--set", "integrator.end_time=0.2", *OPTIONS[6:-1],
         'output.full_runs="8:40"']  # fmt: skip
PORTION = 100  # changed datasets that one process meets


def main(kills: int, seed: int, datasets: int) -> int:
    def tell(line: str) -> None:
        print(line, flush=True)

    with tempfile.TemporaryDirectory() as folder:
        random = campaign(SCENARIO, Path(folder), OPTIONS, kills, seed, tell)
    with tempfile.TemporaryDirectory() as folder:
        chosen = at_every_change(SCENARIO, Path(folder), SHORT, tell)
    with tempfile.TemporaryDirectory() as folder:
        found = attack(Path(folder), seed, -(-datasets // PORTION), PORTION, tell)
    with tempfile.TemporaryDirectory() as folder:
        removed = removals(Path(folder), tell)
    for fault in removed.faults:
        tell(fault)
    tell(f"at random moments: {_told(random)}")
    tell(f"before and behind every change of a file: {_told(chosen)}")
    for what, outcome in (("changed datasets", found), ("datasets without one of their variables", removed)):
        count = sum(outcome.codes.values())
        tell(f"{outcome.files} {what}, {count} commands: {len(outcome.faults) or 'no'} faults")
    return 1 if random.different or chosen.different or found.faults or removed.faults else 0


def _told(report: Report) -> str:
    same = f"DIFFERENT: {', '.join(report.different)}" if report.different else "every bit the same, nothing left over"
    return f"{report.kills} kills with -9, {report.sweeps} sweeps finished and compared: {same}"


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:]]
    sys.exit(main(*[*numbers, *(60, 2015, 1000)[len(numbers) :]]))
