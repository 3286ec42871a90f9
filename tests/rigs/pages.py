"""A double pendulum and what is made of it, and pages taken apart again."""

import base64
import copy
import json
import re
from functools import cache
from html.parser import HTMLParser
from typing import Any

import numpy as np

import lienumba
from lienumba.present.html.page import page

TITLE = "Zwei Pendel </script><b>fett</b> \"quoted\" 'and' & <!-- %{x} ∑"
PENDULUM: dict[str, Any] = {
    "title": TITLE,
    "model": {
        "gravity": [0, 0, -9.81],
        "bodies": [
            {"name": "oben", "mass": 1.0, "inertia": [0.02, 0.025, 0.008], "angular_velocity": [0.3, 1.0, 0.2],
             "rotation": {"axis": [0, 1, 0], "angle": 0.4}},
            {"name": "unten", "mass": 0.7, "inertia": [0.02, 0.02, 0.001], "angular_velocity": [0.5, -1.0, 2.0],
             "rotation": {"axis": [0, 1, 0], "angle": -0.3}},
        ],
        "joints": [
            {"name": "hook", "type": "spherical", "bodies": ["ground", "oben"], "points": [[0, 0, 0], [0, 0, 0.3]]},
            {"name": "elbow", "type": "spherical", "bodies": ["oben", "unten"], "points": [[0, 0, -0.3], [0, 0, 0.3]]},
        ],
    },
    "quantities": [{"name": "tip", "type": "point", "body": "unten", "point": [0, 0, -0.3]}],
    "integrator": {"method": "rk4", "step": 2e-3, "end_time": 0.4},
    "output": {"every": 0.01},
    "sweep": {
        "runs": 40, "seed": 3, "nominal": True,
        "vary": {
            "bodies.oben.mass": {"distribution": "normal", "std": 0.1},
            "bodies.unten.angular_velocity[1]": {"distribution": "uniform", "low": -3.0, "high": 1.0},
        },
    },
}  # fmt: skip


def pendulum(runs: int = 40, **changes: Any) -> dict[str, Any]:
    """The scenario of so many runs, with other values at these paths of sections: output__mode = "summary"."""
    scenario = copy.deepcopy(PENDULUM)
    scenario["sweep"]["runs"] = runs
    for path, value in changes.items():
        *sections, key = path.split("__")
        place = scenario
        for section in sections:
            place = place.setdefault(section, {})
        place[key] = value
    return scenario


@cache
def swept() -> Any:
    """The dataset of the pendulum as it is."""
    return lienumba.run(pendulum())


def page_of(ds: Any, name: str = "pendel.nc", allow_code: bool = False, check: int = 0) -> str:
    return page(ds, name, allow_code, lambda event: None, check)


CAPTION = re.compile(r"<figcaption>(.*?)</figcaption><div class=\"plot\" style=\"height: \d+px\" data-chart")
INLINE = ("strong", "code", "small", "a")


class _Texts(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.texts: list[str] = []
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.ids: dict[str, str] = {}

    def handle_starttag(self, tag: str, attributes: Any) -> None:
        self.tags.append((tag, dict(attributes)))
        self.texts += [] if tag in INLINE else [" "]

    def handle_data(self, data: str) -> None:
        tag, attributes = self.tags[-1] if self.tags else ("", {})
        if attributes.get("id"):
            self.ids.setdefault(attributes["id"], data)
        if tag not in ("script", "style"):
            self.texts.append(data)


class Read:
    """A page as a browser has it: `tags` with attributes, `text` for people, `data` for its scripts, its policy."""

    def __init__(self, text: str) -> None:
        parser = _Texts()
        parser.feed(text)
        self.tags, self.ids = parser.tags, parser.ids
        self.text = " ".join("".join(parser.texts).split())
        self.data = json.loads(parser.ids["data"], parse_constant=_refuse)
        self.policy = next(a["content"] or "" for t, a in self.tags if a.get("http-equiv"))
        captions = (re.sub("<.*?>", "", caption) for caption in CAPTION.findall(text))
        keys = [a["data-chart"] or "" for _, a in self.tags if "data-chart" in a]
        self.captions = list(zip(keys, captions, strict=True))

    def chart(self, title: str) -> dict[str, Any]:
        """The chart under a caption that begins so."""
        return self.data["charts"][next(key for key, caption in self.captions if caption.startswith(title))]


def array(packed: dict[str, str]) -> np.ndarray:
    found = np.frombuffer(base64.b64decode(packed["bdata"]), packed["dtype"])
    return found.reshape([int(n) for n in packed["shape"].split(",")]) if "shape" in packed else found


def _refuse(constant: str) -> None:
    raise AssertionError(f"{constant} is no JSON")
