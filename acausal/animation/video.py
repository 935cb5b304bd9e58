"""GIF and MP4 files of a scene."""

from __future__ import annotations

import io
import os
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from acausal.animation.raster import picture_size, pictures
from acausal.animation.scene import Scene
from acausal.diagnostics import fail
from acausal.results.files import whole_file

if TYPE_CHECKING:
    from PIL.Image import Image


#: A scene for a video knows this many times for each picture, so that trails are smooth.
TIMES_PER_PICTURE = 4
#: Most pictures of a video.
MOST_PICTURES = 3000


def gif_rate(fps: float) -> float:
    """Return the nearest rate a GIF can have: it counts hundredths of seconds, two at least."""
    return 100.0 / max(2, round(100.0 / fps))


def write_video(
    scene: Scene, file: str | os.PathLike[str], fps: float, width: int, height: int
) -> None:
    """Write a scene as GIF or MP4, as the suffix says.

    Args:
        scene: The scene, with :data:`TIMES_PER_PICTURE` times for each picture.
        file: Where to.
        fps: Frames per second.
        width: Pixels.
        height: Pixels; 0 follows the scene.

    Raises:
        AcausalError: ``F202`` cannot write, ``F205`` if ``imageio-ffmpeg`` is missing for MP4.
    """
    size = picture_size(scene, width, height)
    if Path(file).suffix.lower() == ".gif":
        content = _gif(scene, fps, *size)
        with whole_file(file) as unfinished:
            Path(unfinished).write_bytes(content)
        return
    try:
        import imageio_ffmpeg
    except ImportError:
        fail("F205", "MP4 files need the Python package imageio-ffmpeg",
             help="pip install 'acausal[video]', or write a .gif or .html")  # fmt: skip
    with whole_file(file) as unfinished:
        writer = imageio_ffmpeg.write_frames(
            str(unfinished), size, fps=fps, codec="libx264", macro_block_size=2, quality=7,
            output_params=["-f", "mp4", "-movflags", "+faststart", "-fflags", "+bitexact"],
        )  # fmt: skip
        writer.send(None)
        try:
            for image in pictures(scene, *size, TIMES_PER_PICTURE):
                writer.send(np.ascontiguousarray(image).tobytes())
        finally:
            writer.close()


def _gif(scene: Scene, fps: float, width: int, height: int) -> bytes:
    from PIL import Image

    frames = list(pictures(scene, width, height, TIMES_PER_PICTURE))
    # One palette for all, from pictures over the whole time: colours do not flicker.
    samples = [frames[round(k * (len(frames) - 1) / 5)] for k in range(6)]
    sheet = Image.new("RGB", (width, height * len(samples)))
    for k, sample in enumerate(samples):
        sheet.paste(sample, (0, k * height))
    palette = sheet.quantize(128, method=Image.Quantize.MEDIANCUT)
    flat: list[Image.Image] = [
        frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames
    ]
    buffer = io.BytesIO()
    flat[0].save(
        buffer, format="GIF", save_all=True, append_images=flat[1:], loop=0,
        duration=round(1000 / fps), disposal=1,
    )  # fmt: skip
    return buffer.getvalue()
