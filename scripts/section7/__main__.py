"""Draws the figures and renews the tables of docs/paper.md."""

import argparse
import sys
from pathlib import Path

import matplotlib

matplotlib.use("Agg")


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/paper", description="Section 7 of the paper: figures and numbers.")
    parser.add_argument("--folder", type=Path, default=Path("paper_figures"), help="of the figures, made if need be")
    parser.add_argument("--figures", default=None, metavar="3,15", help="these alone, and no tables")
    given = parser.parse_args()
    import document
    from section7 import figures, tables

    every = list(figures.FIGURES)
    wanted = every if given.figures is None else [number.strip().zfill(2) for number in given.figures.split(",")]
    unknown = [number for number in wanted if number not in figures.FIGURES]
    if unknown:
        parser.error(f"--figures {given.figures}: known are {', '.join(str(int(number)) for number in every)}")
    given.folder.mkdir(parents=True, exist_ok=True)
    for number in wanted:
        print(figures.draw(given.folder, number), flush=True)
    if given.figures is None:
        document.renew(tables.DOCUMENT, tables.TABLES)
        print(tables.DOCUMENT)
    return 0


if __name__ == "__main__":
    sys.exit(main())
