"""Schedulers and workers of dask as they are started from a shell, each a process of its own."""

import os
import subprocess
import sys
import time
from pathlib import Path

from tests.rigs.places import ROOT

ENVIRONMENT = os.environ | {
    "PYTHONPATH": os.pathsep.join([str(ROOT), os.environ.get("PYTHONPATH", "")]),
    "DASK_DISTRIBUTED__SCHEDULER__ALLOWED_FAILURES": "0",  # so that each death of a worker reaches the client
}
PATIENCE = 60.0  # s, for a machine that has other things to do


class Processes:
    """A scheduler, and workers of one thread that come and go."""

    def __init__(self, folder: Path) -> None:
        self.file, self.folder = folder / "scheduler.json", folder
        self.workers: list[subprocess.Popen[bytes]] = []
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-show")
        wait_for(self.file.exists)

    @property
    def address(self) -> str:
        import json

        return json.loads(self.file.read_text())["address"]

    def add(self) -> None:
        self.workers.append(self._start("worker", "--nthreads", "1", "--no-nanny", "--local-directory", self.folder))

    def kill_workers(self) -> None:
        for worker in self.workers:
            worker.kill()
            worker.wait()
        self.workers.clear()

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()

    def _start(self, kind: str, *options: object) -> "subprocess.Popen[bytes]":
        command = [
            sys.executable,
            "-m",
            f"distributed.cli.dask_{kind}",
            "--scheduler-file",
            self.file,
            "--no-dashboard",
        ]
        with open(self.folder / "log.txt", "ab") as log:
            return subprocess.Popen(
                [*map(str, command), *map(str, options)], env=ENVIRONMENT, cwd=self.folder,
                stdout=log, stderr=log,
            )  # fmt: skip


def wait_for(condition, patience: float = PATIENCE) -> None:
    end = time.monotonic() + patience
    while not condition():
        assert time.monotonic() < end, "did not come about"
        time.sleep(0.05)
