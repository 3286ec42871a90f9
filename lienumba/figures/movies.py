"""Frames into a file: GIF by Pillow, MP4 by ffmpeg, which is on the path or in the package imageio-ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from tempfile import TemporaryFile
from typing import TYPE_CHECKING

import numpy as np

from lienumba.errors import ScenarioError

if TYPE_CHECKING:
    from PIL.Image import Image

GIF, MP4 = ".gif", ".mp4"
COLORS = 256  # of all frames of a GIF
# H.264 with half the colour resolution is what every browser plays; its size is even.
H264 = ("-c:v", "libx264", "-pix_fmt", "yuv420p", "-crf", "20", "-movflags", "+faststart", "-f", "mp4")
SAME = ("-map_metadata", "-1", "-fflags", "+bitexact", "-flags:v", "+bitexact")  # the same frames, the same bytes


def write_gif(frames: Iterator[np.ndarray], fps: int, target: Path) -> None:
    """Write frames (height, width, 3) of bytes as a GIF that goes on for ever; one palette serves all."""
    from PIL import Image

    images = [Image.fromarray(frame) for frame in frames]
    palette = _palette(images)
    first, *others = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    first.save(
        target, format="GIF", save_all=True, append_images=others, duration=_durations(len(images), fps), loop=0,
        optimize=False,
    )  # fmt: skip


def write_mp4(frames: Iterator[np.ndarray], fps: int, target: Path) -> None:
    """Write frames (height, width, 3) of bytes, of even height and width, as an MP4."""
    command = ffmpeg()
    first = next(frames)
    size = f"{first.shape[1]}x{first.shape[0]}"
    raw = ("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", size, "-r", str(fps), "-i", "-")
    with TemporaryFile() as said:
        process = subprocess.Popen(
            [command, "-y", "-v", "error", *raw, *H264, *SAME, str(target)], stdin=subprocess.PIPE, stderr=said
        )
        assert process.stdin is not None
        try:
            with process.stdin as pipe:
                for frame in chain([first], frames):
                    pipe.write(frame.tobytes())
        except BrokenPipeError:
            pass  # ffmpeg has ended, and says why
        except BaseException:
            process.kill()
            process.wait()
            raise
        if process.wait() != 0:
            said.seek(0)
            why = said.read().decode(errors="replace").strip().splitlines() or ["it says nothing"]
            raise ScenarioError(
                f"ffmpeg ({command}) could not write an MP4 ({why[-1]}); in the clone of lienumba, pip install "
                '".[animate]"'
            )


def ffmpeg() -> str:
    """The ffmpeg of the path, or that of imageio-ffmpeg."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        from imageio_ffmpeg import get_ffmpeg_exe

        return str(get_ffmpeg_exe())
    except (ImportError, RuntimeError):
        raise ScenarioError(
            'an MP4 needs ffmpeg, which is missing; in the clone of lienumba, pip install ".[animate]", or write a GIF'
        ) from None


def _palette(images: list[Image]) -> Image:
    """The colours of some of the images."""
    from PIL import Image

    some = [images[round(k * (len(images) - 1) / 3)] for k in range(4)]
    width, height = some[0].size
    sheet = Image.new("RGB", (width, height * len(some)))
    for n, image in enumerate(some):
        sheet.paste(image, (0, n * height))
    return sheet.quantize(COLORS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def _durations(frames: int, fps: int) -> list[int]:
    """How long each frame is shown in ms: hundredths of a second, which is what a GIF has, right in the mean."""
    ends = [round(100 * (k + 1) / fps) for k in range(frames)]
    return [10 * (end - start) for start, end in zip([0, *ends], ends, strict=False)]
