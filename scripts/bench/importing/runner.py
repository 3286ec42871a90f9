"""Models compared in processes of their own, some at a time, each for so long at most."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from bench.importing.compare import Row, compare
from bench.importing.files import File

POLL = 0.1  # s


@dataclass
class _Running:
    file: File
    process: subprocess.Popen[bytes]
    out: Path
    until: float

    def row(self) -> Row:
        late = self.process.poll() is None
        if late:
            self.process.kill()
        code = self.process.wait()
        try:
            row = Row(**json.loads(self.out.read_text()))
        except (OSError, ValueError):
            row = Row(self.file.name, self.file.kind)
        if late or code:
            row.trouble = "took too long" if late else f"the process ended with {code}"
        return row


def rows(listed: Iterable[File], at_once: int, limit: float, motions: bool) -> Iterator[Row]:
    """Of each file, as they are done; limit: seconds of one."""
    waiting, running = list(listed), []
    script = str(Path(__file__).resolve().parents[2] / "import_check")
    with tempfile.TemporaryDirectory() as folder:
        while waiting or running:
            while waiting and len(running) < at_once:
                file = waiting.pop(0)
                out = Path(folder) / f"{len(waiting)}.json"
                command = [sys.executable, script, "--one", file.name, "--out", str(out)]
                command += [] if motions else ["--no-motions"]
                environment = os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
                process = subprocess.Popen(command, env=environment, cwd=folder, stderr=subprocess.DEVNULL)
                running.append(_Running(file, process, out, time.monotonic() + limit))
            time.sleep(POLL)
            for one in [x for x in running if x.process.poll() is not None or time.monotonic() > x.until]:
                running.remove(one)
                yield one.row()


def one(file: File, out: Path, motions: bool) -> None:
    """The row of a file, as JSON: what there is of it after each part."""
    for row in compare(file.path, file.name, motions):
        again = out.with_suffix(".new")
        again.write_text(json.dumps(asdict(row)))
        again.replace(out)
