"""python -m faults_campaign.suicide N FOLDER ARGUMENTS: lienumba with these arguments, which kills itself right before
the N-th change in a folder: whatever is opened to be written, made, named or removed there."""

import os
import signal
import sys
from typing import Any

CHANGES = {"open", "os.mkdir", "os.rmdir", "os.rename", "os.link", "os.remove", "os.truncate"}  # of Python's audit


def main(call: int, folder: str, arguments: list[str]) -> None:
    seen = [0]

    def audit(event: str, given: tuple[Any, ...]) -> None:
        if event not in CHANGES or not str(given[0]).startswith(folder):
            return
        if event == "open" and not given[2] & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            return
        seen[0] += 1
        if seen[0] > call:
            os.kill(os.getpid(), signal.SIGKILL)

    from lienumba.cli import main as lienumba
    from lienumba.store import shards

    shards.PAUSE = 0.0  # every chunk is a shard
    sys.argv = ["lienumba", *arguments]
    sys.addaudithook(audit)
    lienumba()


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2], sys.argv[3:])
