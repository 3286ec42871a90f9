"""Renews the tables of docs/accuracy.md."""

import argparse
import sys

import document
from precision import tables


def main() -> int:
    parser = argparse.ArgumentParser(prog="scripts/accuracy", description="Accuracy and its costs, in tables.")
    parser.add_argument("--only", default="", metavar="TEXT", help="tables whose names begin so")
    given = parser.parse_args()
    wanted = {name: table for name, table in tables.TABLES.items() if name.startswith(given.only)}
    if not wanted:
        parser.error(f"--only {given.only}: known are {'; '.join(tables.TABLES)}")
    for name, table in wanted.items():
        document.renew(tables.DOCUMENT, {name: table})
        print(name, flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
