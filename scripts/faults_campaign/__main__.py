"""python -m faults_campaign [KILLS [SEED]]"""

import sys
import tempfile
from pathlib import Path

from faults_campaign.kills import campaign

SCENARIO = Path(__file__).parents[2] / "scenarios" / "heavy_top_monte_carlo.toml"
OPTIONS = [
    "--set", "sweep.runs=12000", "--set", "integrator.step=1e-4", "--set", "output.every=0.1",
    "--set", "output.mode=summary", "--set", 'output.full_runs="100:4000"',
]  # fmt: skip


def main(kills: int, seed: int) -> int:
    with tempfile.TemporaryDirectory() as folder:
        report = campaign(SCENARIO, Path(folder), OPTIONS, kills, seed, lambda line: print(line, flush=True))
    print(
        f"{report.kills} kills with -9, {report.sweeps} sweeps finished and compared: "
        + (f"DIFFERENT: {', '.join(report.different)}" if report.different else "every bit the same")
    )
    return 1 if report.different else 0


if __name__ == "__main__":
    numbers = [int(text) for text in sys.argv[1:]]
    sys.exit(main(*[*numbers, *(60, 2015)[len(numbers) :]]))
