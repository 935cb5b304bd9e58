"""Models composed in Python."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from acausal.compose.component import Component, freeze
from acausal.compose.mistakes import in_terms_of_python
from acausal.compose.names import check_name
from acausal.compose.places import here
from acausal.diagnostics import AcausalError, fail

if TYPE_CHECKING:
    from pathlib import Path

    from acausal.compiler import Compiled
    from acausal.drawing.schematic import Drawing
    from acausal.results.result import Result


class Model(Component):
    """A model made in Python: assign components to its attributes and connect their cuts.

    Args:
        name: Name of the model, an identifier; the name of the class if not given.
        description: What it is.
        options: ``shape``, ``inner`` and modifiers where it is used as a component, and arguments
            of ``build`` of a subclass; see :class:`Component`.

    A model may be a component of another one. When it is compiled it is closed: later changes raise
    ``N156``. A model that has been assigned to another one can still be changed until then.

    Example:
        >>> import acausal as ac
        >>> from acausal.library import electrical as el
        >>> circuit = ac.Model("rc")
        >>> circuit.source = el.ConstantVoltage(V=10)
        >>> circuit.r = el.Resistor(R="1[kOhm]")
        >>> circuit.c = el.Capacitor(C=1e-6, v=dict(start=0, fixed=True))
        >>> circuit.ground = el.Ground()
        >>> circuit.connect(circuit.source.p, circuit.r.p)
        >>> circuit.connect(circuit.r.n, circuit.c.p)
        >>> circuit.connect(circuit.c.n, circuit.source.n, circuit.ground.p)
        >>> round(float(circuit.simulate(stop_time=1e-3)["c.v"].values[-1]), 3)
        6.321
    """

    __slots__ = ("_compiled", "_experiment", "_model_name")

    _compiled: dict[Any, Compiled]
    _experiment: dict[str, float]
    _model_name: str

    def __new__(cls, *args: Any, **options: Any) -> Any:
        """Prepare an instance."""
        self = Component.__new__(cls)
        object.__setattr__(self, "_compiled", {})
        object.__setattr__(self, "_experiment", {})
        object.__setattr__(self, "_model_name", cls.__name__)
        return self

    def __init__(
        self, name: str | None = None, description: str = "", *positional: Any, **options: Any
    ) -> None:
        if name is not None:
            if not isinstance(name, str):
                fail("N151", f"{name!r} is no name", self._span, help='write ac.Model("circuit")')
            check_name(name, self._span)
            object.__setattr__(self, "_model_name", name)
        super().__init__(*positional, description=description, **options)

    @property
    def name(self) -> str:
        """Name of the model."""
        return self._model_name

    @property
    def _title(self) -> str:
        return self._model_name

    @property
    def _class_title(self) -> str:
        return self._model_name

    def __repr__(self) -> str:
        parts = len(self._parts or ()) + len(type(self)._declared)
        return (
            f"<model {self._model_name}: {parts} parts, {len(self._connections or ())} connections>"
        )

    def experiment(
        self,
        *,
        start_time: float | None = None,
        stop_time: float | None = None,
        tolerance: float | None = None,
        interval: float | None = None,
    ) -> None:
        """Set what a simulation uses if it is not told otherwise.

        Args:
            start_time: Seconds.
            stop_time: Seconds.
            tolerance: Relative tolerance.
            interval: Distance of output points, seconds.
        """
        self._changeable()
        given = {
            "StartTime": start_time, "StopTime": stop_time, "Tolerance": tolerance,
            "Interval": interval,
        }  # fmt: skip
        self._experiment.update({k: float(v) for k, v in given.items() if v is not None})

    def copy(self) -> Model:
        """Return a copy that can be changed: nothing in it is shared with this model."""
        from acausal.compose.copying import copy_of

        return cast(Model, copy_of(self))

    def compile(self, parameters: Mapping[str, float | str] | None = None) -> Compiled:
        """Compile the model; from then on it cannot be changed.

        Args:
            parameters: Values by path, ``{"r.R": 100}``: SI numbers or texts with a unit.

        Returns:
            The compiled model; the same one if it is asked for again.

        Raises:
            AcausalError: For any mistake in the model, at the line of Python that made it.
        """
        from acausal.compiler import compile_definition
        from acausal.compose.assembly import model_definition
        from acausal.memory import no_garbage_collection

        key = tuple(sorted((parameters or {}).items()))
        if key not in self._compiled:
            try:
                with no_garbage_collection():
                    definition = model_definition(self)
                    self._compiled[key] = compile_definition(definition, parameters)
            except AcausalError as error:
                raise in_terms_of_python(error, self._model_name) from None
            if self._frozen is None:
                freeze(self, here())
        return self._compiled[key]

    def simulate(self, *args: Any, **options: Any) -> Result:
        """Compile the model if need be and simulate it, see :meth:`acausal.Compiled.simulate`.

        Args:
            args: See there.
            options: ``stop_time``, ``parameters``, ``start``, ``tolerance``, ... as there.
        """
        return self.compile().simulate(*args, **options)

    def schematic(self, file: str | Path | None = None, depth: int = 1) -> Drawing:
        """Compile the model and draw it, see :meth:`acausal.Compiled.schematic`.

        Args:
            file: Where to write it, ``.svg`` or ``.png``; nowhere if None.
            depth: Levels of components.
        """
        return self.compile().schematic(file, depth)

    def report(self, file: str | Path | None = None, **options: Any) -> str:
        """Compile the model and write about it and a run, see :meth:`acausal.Compiled.report`.

        Args:
            file: Where to write the page, ``.html``; nowhere if None.
            options: ``result``, ``variables``, ``depth``, ``run`` as there.
        """
        return self.compile().report(file, **options)

    def to_acm(self) -> str:
        """Return the model as text of the language, with the Python classes it uses.

        Example:
            >>> import acausal as ac
            >>> from acausal.library import electrical as el
            >>> load = ac.Model("load")
            >>> load.r = el.Resistor(R="10[kOhm]")
            >>> print(load.to_acm())
            model load
              electrical.Resistor r(R = 10[kOhm]);
            end load;
            <BLANKLINE>
        """
        from acausal.compose.assembly import model_text

        return model_text(self)
