"""What users call: an animation of a result, as a page, a file, or in a notebook."""

from __future__ import annotations

import os
from collections.abc import Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from acausal.animation.annotations import SHAPES, Shape, read_shapes
from acausal.animation.build import Drawn, Wish, build_scene, drawn_components
from acausal.diagnostics import AcausalError, fail
from acausal.diagnostics.suggest import nearest
from acausal.syntax import tree
from acausal.syntax.parser import parse_expression

if TYPE_CHECKING:
    from acausal.animation.scene import Scene
    from acausal.compiler import Compiled
    from acausal.results.result import Result

#: An expression of variables, a number, or a point made of them.
Term: TypeAlias = "str | float | Sequence[str | float]"
SUFFIXES = (".html", ".gif", ".mp4")


class Animation:
    """An animation of a result: the shapes of its components, and own ones.

    Args:
        result: The result.
        model: The compiled model, if the result does not know it (one that was read from a file).
        components: Whether the components are drawn as their classes say.
        speed: Simulated seconds per second; by default a round number so that it takes some ten
            seconds.
        title: Text above; by default name and description of the model.
        camera: Arguments of the camera, e.g. ``{"azimuth": 90, "follow": ("x", "y")}``.

    Raises:
        AcausalError: ``D115`` if ``components`` was asked for and the model is not known.

    Example:
        >>> from acausal import Animation, compile_file
        >>> result = compile_file("examples/pendulum.acm").simulate(stop_time=5)
        >>> animation = Animation(result).line((0, 0), ("sin(phi)", "-cos(phi)"))
        >>> animation.circle(("sin(phi)", "-cos(phi)"), radius=0.1).save("pendulum.html")
    """

    def __init__(
        self, result: Result, model: Compiled | None = None, *, components: bool | None = None,
        speed: float | None = None, title: str | None = None, camera: dict[str, Term] | None = None,
    ) -> None:  # fmt: skip
        self.result = result
        self._own: list[Shape] = []
        self._speed = _positive("speed", speed)
        self._title = title
        self._camera = {k: _term(v, f"camera {k}") for k, v in (camera or {}).items()}
        known = model if model is not None else getattr(result, "compiled", None)
        if components and known is None:
            fail("D115", f"the result of {result.model_name} does not know how its components look",
                 notes=["files hold numbers, not classes"],
                 help="give the compiled model: Animation(result, compile_file(...)), or draw own "
                 "shapes: Animation(result).circle(at=('x', 'y'))")  # fmt: skip
        self._model = known if components is not False else None
        self._drawn: Drawn | None = None

    # ---- shapes ---------------------------------------------------------------------------------

    def shape(self, kind: str, **arguments: Term | bool) -> Animation:
        """Add a shape; returns the animation, so that calls can be chained.

        Args:
            kind: ``Line``, ``Rod``, ``Spring``, ``Damper``, ``Piston``, ``Arrow``, ``Circle``,
                ``Sphere``, ``Wheel``, ``Gear``, ``Box``, ``Cylinder``, ``Tyre``, ``Car``,
                ``Joint``, ``Ground``, ``Wall``, ``Axes``, ``Polygon``, ``Trail``, ``Text``.
            arguments: As in annotations; ``from`` may be written ``from_``. Points are paths of
                frames, or tuples of expressions in variables, metres.

        Raises:
            AcausalError: ``D111`` for an unknown kind, ``D112`` for wrong arguments.
        """
        texts = {}
        for name, value in arguments.items():
            name = name.rstrip("_")
            quoted = (name == "text" and kind == "Text") or (
                name == "color" and isinstance(value, str)
            )
            texts[name] = f'"{value}"' if quoted else _text(value)
        call = f"{kind}({', '.join(f'{name} = {text}' for name, text in texts.items())})"
        if kind not in SHAPES:
            close = nearest(kind, list(SHAPES))
            known = f"the shapes are {', '.join(SHAPES)}"
            fail("D111", f"there is no shape {kind}", help=f"write {close[0]}" if close else known)
        self._own += read_shapes(parsed := parse_expression(call, "<Animation>"), parsed.span)
        return self

    def line(self, from_: Term, to: Term, **style: Term | bool) -> Animation:
        """Add a thin line between two points (``thickness`` in pixels, ``dashed``, ``color``)."""
        return self.shape("Line", from_=from_, to=to, **style)

    def rod(self, from_: Term, to: Term, **style: Term | bool) -> Animation:
        """Add a bar between two points (``width`` in metres, ``color``)."""
        return self.shape("Rod", from_=from_, to=to, **style)

    def spring(self, from_: Term, to: Term, **style: Term | bool) -> Animation:
        """Add a coil spring between two points (``radius``, ``coils``)."""
        return self.shape("Spring", from_=from_, to=to, **style)

    def circle(self, at: Term, **style: Term | bool) -> Animation:
        """Add a disc, in space a ball (``radius`` in metres; ``marked`` shows how it turns)."""
        return self.shape("Circle", at=at, **style)

    def box(self, at: Term, **style: Term | bool) -> Animation:
        """Add a rectangle, in space a box (``length``, ``width``, ``height``, ``angle``)."""
        return self.shape("Box", at=at, **style)

    def arrow(self, at: Term, vector: Term, **style: Term | bool) -> Animation:
        """Add an arrow, for instance of a force (``scale`` in metres per unit of the vector)."""
        return self.shape("Arrow", at=at, vector=vector, **style)

    def trail(self, at: Term, **style: Term | bool) -> Animation:
        """Add the path of a point (``duration`` in seconds; all of it by default)."""
        return self.shape("Trail", at=at, **style)

    def text(self, at: Term, text: str, **style: Term | bool) -> Animation:
        """Add a text at a point (``size`` in pixels)."""
        return self.shape("Text", at=at, text=text, **style)

    # ---- results --------------------------------------------------------------------------------

    def scene(self, fps: float = 60.0, most: int = 1500) -> Scene:
        """Return everything as numbers: what is drawn where, at ``fps`` times per second.

        Raises:
            AcausalError: ``D113`` for shapes that cannot be evaluated, ``D114`` if there is nothing
                to draw.
        """
        if self._drawn is None:
            self._drawn = Drawn() if self._model is None else _drawn(self._model)
        if not self._own and self._model is None:
            name = self.result.model_name
            fail("D115", f"the result of {name} does not know how its components look",
                 notes=["a result that was read from a file, or of a sweep, holds numbers only"],
                 help="give the compiled model: Animation(result, compiled), or add shapes: "
                 ".circle(at=('x', 'y'))")  # fmt: skip
        wish = Wish(self._speed, fps, most, self._camera, self._title)
        return build_scene(self.result, self._drawn, self._own, wish)

    def html(self) -> str:
        """Return one web page that needs nothing else."""
        from acausal.animation.page import page

        return page(self.scene())

    def save(
        self, file: str | os.PathLike[str], *, fps: float = 25.0, width: int = 800, height: int = 0
    ) -> Path:
        """Write a file: ``.html`` to play with, ``.gif`` or ``.mp4`` to show.

        Args:
            file: Its suffix chooses the format.
            fps: Pictures per second of a GIF or MP4. GIFs know hundredths of seconds only.
            width: Pixels of a GIF or MP4.
            height: Likewise; it follows the scene if 0.

        Raises:
            AcausalError: ``F201`` unknown suffix, ``F202`` cannot write, ``F205`` for MP4 without
                the package ``imageio-ffmpeg``, and what :meth:`scene` raises.
        """
        from acausal.results.files import check_target, whole_file

        check_target(file, SUFFIXES)
        suffix = Path(file).suffix.lower()
        if suffix == ".html":
            content = self.html().encode()
            with whole_file(file) as unfinished:
                Path(unfinished).write_bytes(content)
            return Path(file)
        from acausal.animation import video

        rate = _positive("fps", fps)
        assert rate is not None
        rate = video.gif_rate(rate) if suffix == ".gif" else rate
        if not 16 <= width <= 4096 or not 0 <= height <= 4096:
            fail("D116", f"a picture of {width} by {height} pixels is not possible",
                 help="give a width from 16 to 4096; the height may be left out")  # fmt: skip
        finer = video.TIMES_PER_PICTURE
        scene = self.scene(finer * rate, finer * video.MOST_PICTURES)
        video.write_video(scene, file, rate, width, height)
        return Path(file)

    def _repr_html_(self) -> str:
        """Show the player in a notebook."""
        try:
            content = self.html()
        except AcausalError as error:
            return f"<pre>{escape(str(error))}</pre>"
        return (
            '<iframe style="width:100%;height:520px;border:0" sandbox="allow-scripts" '
            f'srcdoc="{escape(content)}"></iframe>'
        )

    def __repr__(self) -> str:
        return f"<Animation of {self.result.model_name}, {len(self._own)} own shapes>"


def animate(
    result: Result, file: str | os.PathLike[str] | None = None, model: Compiled | None = None,
    *, fps: float = 25.0, speed: float | None = None, width: int = 800, height: int = 0,
    title: str | None = None, camera: dict[str, Term] | None = None,
) -> Animation:  # fmt: skip
    """Animate a result as its components say, and write the file if one is given.

    Args:
        result: The result of a simulation.
        file: ``.html``, ``.gif`` or ``.mp4``; None to show it in a notebook.
        model: The compiled model, if the result does not know it.
        fps: Pictures per second of a GIF or MP4.
        speed: Simulated seconds per second.
        width: Pixels of a GIF or MP4.
        height: Likewise; it follows the scene if 0.
        title: Text above.
        camera: Arguments of the camera.

    Raises:
        AcausalError: As :class:`Animation`, :meth:`Animation.save`.
    """
    animation = Animation(result, model, components=True, speed=speed, title=title, camera=camera)
    if file is not None:
        animation.save(file, fps=fps, width=width, height=height)
    return animation


def _drawn(model: Compiled) -> Drawn:
    flattened = model._all_stages().flattened
    assert flattened is not None
    return drawn_components(flattened)


def _positive(name: str, value: float | None) -> float | None:
    if value is not None and not (0 < value < float("inf")):
        fail("D116", f"{name} = {value:g} of an animation is not possible",
             help="give a positive number")  # fmt: skip
    return value


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (int, float)):
        return f"({value!r})"
    if isinstance(value, Sequence) or hasattr(value, "tolist"):
        return "{" + ", ".join(_text(part) for part in value) + "}"
    fail("D113", f"{value!r} is no argument of a shape",
         help="give a number, an expression as a text, or a tuple of them")  # fmt: skip


def _term(value: Term, source: str) -> tree.Expression:
    return parse_expression(_text(value), f"<{source}>")
