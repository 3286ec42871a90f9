"""A real kernel, and cells as a notebook keeps their outputs."""

import time
from dataclasses import dataclass, field

from jupyter_client.manager import KernelManager

PATIENCE = 120.0  # s, for a machine that has other things to do


@dataclass
class Cell:
    """outputs: the last content of each display, in order; updates: how often one was replaced."""

    outputs: list[dict] = field(default_factory=list)
    streams: str = ""
    error: str = ""
    traceback: str = ""
    updates: int = 0
    places: dict[str, int] = field(default_factory=dict)

    def take(self, kind, content):
        if kind in ("display_data", "execute_result"):
            name = content.get("transient", {}).get("display_id")
            if name is not None:
                self.places[name] = len(self.outputs)
            self.outputs.append(content["data"])
        elif kind == "update_display_data":
            self.outputs[self.places[content["transient"]["display_id"]]] = content["data"]
            self.updates += 1
        elif kind == "stream":
            self.streams += content["text"]
        elif kind == "error":
            self.error, self.traceback = f"{content['ename']}: {content['evalue']}", "\n".join(content["traceback"])


class Kernel:
    """Runs cells; `interrupt_when(cell)` true: the kernel is interrupted, once."""

    def __init__(self, folder):
        self.manager = KernelManager(kernel_name="python3")
        self.manager.start_kernel(cwd=str(folder))
        self.client = self.manager.client()
        self.client.start_channels()
        self.client.wait_for_ready(timeout=PATIENCE)

    def close(self):
        self.client.stop_channels()
        self.manager.shutdown_kernel(now=True)
        self.manager.context.destroy()

    def run(self, code, interrupt_when=None):
        message, cell, deadline = self.client.execute(code), Cell(), time.monotonic() + PATIENCE
        while time.monotonic() < deadline:
            got = self.client.get_iopub_msg(timeout=PATIENCE)
            if got["parent_header"].get("msg_id") != message:
                continue
            if got["msg_type"] == "status" and got["content"]["execution_state"] == "idle":
                self.client.get_shell_msg(timeout=PATIENCE)
                return cell
            cell.take(got["msg_type"], got["content"])
            if interrupt_when is not None and interrupt_when(cell):
                interrupt_when = None
                self.manager.interrupt_kernel()
        raise AssertionError("the cell did not end")
