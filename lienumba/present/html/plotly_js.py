"""plotly.js, from the Python package of plotly."""

from __future__ import annotations

import base64
import gzip
import hashlib

from lienumba.errors import ScenarioError


def library() -> str:
    """The text of plotly.js."""
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise ScenarioError(
            'a report needs plotly, which is missing; in the clone of lienumba, pip install ".[report]"'
        ) from None
    text: str = get_plotlyjs()
    return text


def packed(text: str) -> str:
    """A text as the page unpacks it: gzip in base64, the same at any time."""
    return base64.b64encode(gzip.compress(text.encode(), 9, mtime=0)).decode()


def digest(script: str) -> str:
    """By what the policy of the page knows a script that may run."""
    return f"'sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}'"
