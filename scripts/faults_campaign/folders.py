"""Folders of shards, and parts of a sweep, that somebody or something has changed: what goes on with them ends with a
sentence, or with every bit."""

import json
import random
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from faults_campaign.datasets import TEXTS, bits
from lienumba.store.deflate import checksum
from lienumba.store.shards import LABEL, MANIFEST

KINDS = ("bits", "gone", "swapped", "renamed", "folder", "link", "type", "labels", "manifest", "manifest",
         "no manifest", "strange", "empty")  # fmt: skip

WHOLE = ("all of them", "all of them, backwards")  # of parts: what comes of these is the sweep


def changed_shards(source: Path, target: Path, pick: random.Random) -> str:
    """Copy the folder of a sweep that was interrupted, and change one thing in it."""
    shutil.copytree(source, target, dirs_exist_ok=True)
    shards = sorted(target.glob("*.npy"))
    one, other = pick.sample(shards, 2)
    kind = pick.choice(KINDS)
    if kind == "bits":
        return f"shard: {bits(one, one, pick)}"
    if kind == "gone":
        one.unlink()
    elif kind == "swapped":
        content = one.read_bytes()
        one.write_bytes(other.read_bytes())
        other.write_bytes(content)
    elif kind == "renamed":
        one.rename(target / pick.choice(["run-0-0-00000000.npy", f"x{one.name}", one.name.replace("run", "other")]))
    elif kind == "folder":
        one.unlink()
        one.mkdir()
    elif kind == "link":
        one.unlink()
        one.symlink_to(other if pick.random() < 0.5 else target / "nowhere")
    elif kind in ("type", "labels"):
        _resaved(one, kind, pick)
    elif kind == "manifest":
        _other_manifest(target / MANIFEST, pick)
    elif kind == "no manifest":
        (target / MANIFEST).unlink()
    elif kind == "strange":
        (target / "notes.txt").write_text("mine")
    else:
        one.write_bytes(b"")
    return f"shard: {kind}"


def _resaved(path: Path, kind: str, pick: random.Random) -> None:
    """Records of another type, or of other runs, with a checksum that fits."""
    records: Any = np.load(path)
    if kind == "type":
        records = pick.choice([records[list(records.dtype.names[:-1])], np.arange(3), np.zeros((2, 2)), records[:0]])
    else:
        labels = records[LABEL]
        records[LABEL] = pick.choice([labels + 1000, labels * 0, -labels - 5])
    path.unlink()
    partial = path.with_name("x.npy")
    np.save(partial, records)
    stem = path.stem.rpartition("-")[0]
    partial.rename(path.with_name(f"{stem}-{checksum(partial.read_bytes()):08x}.npy"))


def _other_manifest(path: Path, pick: random.Random) -> None:
    manifest = json.loads(path.read_text())
    kind = pick.choice(["value", "gone", "whole", "cut"])
    key = pick.choice([*manifest])
    if kind == "value":
        manifest[key] = pick.choice([*TEXTS, 5, None, [], {}, [[1]]])
    elif kind == "gone":
        del manifest[key]
    elif kind == "whole":
        manifest = pick.choice([[], 5, "x", None, {}])
    text = json.dumps(manifest)
    path.write_text(text[: pick.randrange(len(text))] if kind == "cut" else text)


def changed_parts(parts: list[Path], folder: Path, pick: random.Random) -> Iterator[tuple[str, list[Path]]]:
    """What may be given to merge, and what was done to it."""
    *own, alien = parts
    damaged = folder / "damaged.nc"
    bits(own[0], damaged, pick)
    yield WHOLE[0], own
    yield WHOLE[1], own[::-1]
    yield "one is missing", pick.sample(own, 2)
    yield "one is there twice", [*own, pick.choice(own)]
    yield "one is of another sweep", [*own[:-1], alien]
    yield "one is damaged", [damaged, *own[1:]]
    yield "one is no file", [folder, *own[1:]]
