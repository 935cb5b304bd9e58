"""The pipeline on one page: from a file to a model that can be simulated.

Every stage is a function from one record to the next; this module alone knows them all. It times
them, logs them, and keeps what `acausal inspect` prints.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from acausal.memory import no_garbage_collection

if TYPE_CHECKING:
    import networkx

    from acausal.diagnostics import Diagnostic
    from acausal.drawing.schematic import Drawing
    from acausal.elimination.eliminate import Elimination
    from acausal.flattening.flatten import Flattened
    from acausal.inspection.display import Equations
    from acausal.instantiation.template import Template
    from acausal.modeling.classes import ClassDef
    from acausal.results.result import Result
    from acausal.results.snapshot import Snapshot
    from acausal.simulation.changed_values import ChangedValues
    from acausal.simulation.system import System
    from acausal.structural.incidence import Chains
    from acausal.structural.pantelides import Offsets

_log = logging.getLogger(__name__)


@dataclass
class Stages:
    """What each stage of one compilation has made, and how long it took.

    Attributes:
        definition: The class (parse, declare).
        given: Parameter values from outside, by path.
        templates: The class templates (instantiate).
        flattened: Numbering, junctions and flat model (connect, flatten).
        elimination: What is left, and what was taken out (eliminate).
        chains: Variables and their derivatives.
        offsets: How often rows and variables are differentiated (reduce index).
        system: What the simulation gets.
        timings: Seconds by stage.
    """

    definition: ClassDef | None = None
    given: dict[str, float] = field(default_factory=dict)
    templates: list[Template] = field(default_factory=list)
    flattened: Flattened | None = None
    elimination: Elimination | None = None
    chains: Chains | None = None
    offsets: Offsets | None = None
    system: System | None = None
    timings: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Time a stage."""
        begun = time.perf_counter()
        yield
        self.timings[stage] = time.perf_counter() - begun
        _log.info("%s: %.4f s", stage, self.timings[stage])


@no_garbage_collection()
def compile_class(
    definition: ClassDef,
    parameters: Mapping[str, float] | None = None,
    stages: Stages | None = None,
) -> Stages:
    """Take a class through all stages.

    Args:
        definition: The model.
        parameters: Values by path, SI units; they win over the model's own.
        stages: Receives the results; given to see how far a failing compilation came.

    Raises:
        AcausalError: For any mistake in the model.
    """
    from acausal.assembly.assemble import family_kernels
    from acausal.connections.spanning import instantiate_rooted
    from acausal.diagnosis.floating import refuse_floating
    from acausal.diagnosis.singular import explain_singularity
    from acausal.elimination.eliminate import eliminate
    from acausal.elimination.rests import with_rests
    from acausal.events.lowering import lower_events
    from acausal.flattening.flatten import flatten
    from acausal.flattening.open_inputs import refuse_open_inputs
    from acausal.simulation.build import build_system
    from acausal.structural.differentiate import differentiate
    from acausal.structural.incidence import chains_of, incidence_of
    from acausal.structural.pantelides import Singularity, pantelides

    stages = Stages() if stages is None else stages
    stages.definition = definition
    stages.given = dict(parameters or {})
    with stages.timed("instantiate"):
        stages.templates, given = instantiate_rooted(definition, dict(parameters or {}))
    with stages.timed("flatten"):
        flattened = stages.flattened = flatten(stages.templates, given)
        refuse_open_inputs(flattened)
        refuse_floating(flattened)
        flattened.forget_junctions()
    with stages.timed("events"):
        flattened.model = lower_events(flattened.model)
    with stages.timed("eliminate"):
        elimination = eliminate(flattened.model)
        elimination = replace(elimination, model=with_rests(elimination.model))
        stages.elimination = elimination
        reduced = elimination.model
    with stages.timed("reduce index"):
        chains = stages.chains = chains_of(reduced.derivative, elimination.active)
        signature = incidence_of(reduced.families, reduced.n_rows, chains).signature()
        offsets = pantelides(signature, chains.highest)
        if isinstance(offsets, Singularity) or len(elimination.redundant_rows):
            if not isinstance(offsets, Singularity):
                from acausal.structural.pantelides import singularity

                offsets = singularity(signature)
            raise explain_singularity(flattened, elimination, chains, offsets)
        stages.offsets = offsets
        differentiated = differentiate(
            reduced.families, reduced.n_rows, chains, offsets.c, offsets.d
        )
    with stages.timed("generate"):
        family_kernels(differentiated.families)
    with stages.timed("build"):
        stages.system = build_system(flattened, elimination, differentiated, offsets, signature)
    return stages


class Compiled:
    """A compiled model, ready to run as often as wanted.

    Example:
        >>> compiled = compile_file("examples/rlc.acm")
        >>> result = compiled.simulate(stop_time=0.1)
        >>> result["c.v"].values.shape
        (501,)

    Attributes:
        system: What the simulation gets.
        timings: Seconds by stage of the compilation.
        warnings: What was noticed and is no error.
        stages: What each stage has made; None if the model came from the cache.
        again: Compiles the model once more, for those who need the stages nevertheless.
    """

    def __init__(
        self,
        system: System,
        timings: dict[str, float],
        warnings: tuple[Diagnostic, ...] = (),
        stages: Stages | None = None,
        again: Callable[[], Stages] | None = None,
    ) -> None:
        self.system = system
        self.timings = timings
        self.warnings = warnings
        self.stages = stages
        self._again = again
        self._changes: ChangedValues | None = None
        # What was compiled, and which values have been changed since.
        self._values_of: tuple[Compiled, dict[str, float], dict[str, float]] = (self, {}, {})

    @property
    def name(self) -> str:
        """Name of the model."""
        return self.system.name

    def connection_graph(self) -> networkx.MultiGraph[Any]:
        """Return the components and the junctions where their cuts meet, as a networkx graph.

        :mod:`acausal.connections.graph` tells what its nodes and edges carry, and answers the
        usual questions: islands, loops, neighbours.
        """
        from acausal.connections.graph import connection_graph

        flattened = self._all_stages().flattened
        assert flattened is not None
        return connection_graph(flattened)

    def schematic(self, file: str | Path | None = None, depth: int = 1) -> Drawing:
        """Draw the connection graph with the symbols of the components.

        Args:
            file: Where to write it, ``.svg`` or ``.png``; nowhere if None.
            depth: Levels of components; above 1, components that are made of others are frames
                around what they are made of.

        Returns:
            The drawing: ``.svg`` is its text, a notebook shows it.

        Raises:
            AcausalError: ``F111`` for a depth below 1, ``F112`` for very many parts, and as
                :meth:`Drawing.write`.

        Example:
            >>> drawing = compile_file("examples/rlc.acm").schematic()
        """
        from acausal.drawing.schematic import schematic

        flattened = self._all_stages().flattened
        assert flattened is not None
        drawing = schematic(flattened.numbering.groups[-1].template, depth, self.name)
        if file is not None:
            drawing.write(file)
        return drawing

    def report(
        self,
        file: str | Path | None = None,
        result: Result | None = None,
        variables: Sequence[str] = (),
        depth: int = 1,
        run: bool = True,
    ) -> str:
        """Write about the model and a run of it on one web page that needs nothing else.

        Args:
            file: Where to write it, ``.html``; nowhere if None.
            result: A run of this model; it is simulated as it says itself if None.
            variables: Patterns of the variables to plot; the states if there are none.
            depth: Levels of components in the schematic.
            run: False for a page about the model alone.

        Returns:
            The page. If there is no consistent start, it says why.

        Raises:
            AcausalError: ``N901`` if a pattern matches nothing, ``F20x`` if the file cannot be
                written.

        Example:
            >>> page = compile_file("examples/rlc.acm").report()
        """
        from acausal.diagnostics import AcausalError
        from acausal.reporting.report import report_page, write_page

        failure: tuple[Diagnostic, ...] = ()
        if result is None and run:
            try:
                result = self.simulate()
            except AcausalError as error:
                failure = error.diagnostics
        page = report_page(self._all_stages(), result, variables, depth, failure)
        if file is not None:
            write_page(file, page)
        return page

    def simulate(
        self,
        start_time: float | None = None,
        stop_time: float | None = None,
        tolerance: float | None = None,
        solver: str = "ida",
        points: int | None = None,
        interval: float | None = None,
        progress: Callable[[float, float], None] | None = None,
        variables: Sequence[str] | None = None,
        max_step: float = float("inf"),
        parameters: Mapping[str, float | str] | None = None,
        start: Mapping[str, float | str] | None = None,
        continue_from: Snapshot | None = None,
        dense: bool = False,
        output: str | Path | None = None,
        keep: bool = True,
    ) -> Result:
        """Simulate the model.

        Args:
            start_time: Seconds; the model's own, or 0.
            stop_time: Seconds; the model's own, or one second after the start.
            tolerance: Relative tolerance; the model's own, or 1e-6.
            solver: ``ida``, ``odes-ida``, ``odes-cvode`` or ``radau``.
            points: Number of equidistant output points, 501 by default.
            interval: Distance of output points in seconds; wins over ``points``.
            progress: Called with the time reached and the stop time.
            variables: Patterns of the variables to keep; everything by default.
            max_step: Largest step of the integrator, seconds.
            parameters: Values by path for this run: numbers in SI units, or texts such as
                ``"10[kOhm]"``. Nothing is compiled for them unless they decide about the
                structure of the model.
            start: Start values of states by path, likewise; they count as fixed.
            continue_from: Where an earlier run of the same model stood (``result.end``, or a
                stored one); this run goes on from there, with other parameters if they are given.
            dense: Keep the integrator's own polynomials: ``result.at(t, "x")`` is then as exact
                as the run itself at any time.
            output: Write this file while the run goes on (``.nc``, ``.h5``, ``.parquet`` or
                ``.csv``); it is complete also after an interruption or when the disk is full.
            keep: Keep the result in memory, too; if not, memory stays flat, and the result reads
                the file when it is asked.

        Returns:
            The result; if the run failed on its way, what there is, with the reason in
            ``diagnostics`` and ``ending``.

        Raises:
            AcausalError: If there is no consistent start, or what is asked for is impossible.
        """
        from acausal.diagnostics import fail
        from acausal.simulation.engine import simulate
        from acausal.simulation.request import Request

        if continue_from is not None and (start or start_time is not None):
            fail("R010", "a run that goes on has no start values and no start time of its own",
                 help="leave out start and start_time, or leave out continue_from")  # fmt: skip
        if interval is None and points is None:
            interval = self.system.experiment.interval
        request = Request(
            start_time, stop_time, tolerance, solver, points, interval, variables, progress,
            max_step, None, continue_from, dense, output, keep,
        )  # fmt: skip
        model = self.with_values(parameters or {}, start or {})
        return replace(simulate(model.system, request), compiled=model)

    def with_values(
        self,
        parameters: Mapping[str, float | str],
        start: Mapping[str, float | str] | None = None,
    ) -> Compiled:
        """Return the model with other parameters and start values.

        Args:
            parameters: Values by path: numbers in SI units, or texts such as ``"10[kOhm]"``.
            start: Start values of states by path, likewise; they count as fixed.

        Raises:
            AcausalError: For unknown names, wrong units, and what the values make impossible.

        Example:
            >>> heavier = compile_file("examples/pendulum.acm").with_values({"m": 2})
        """
        from acausal.simulation.changed_values import StructureChanges

        if not parameters and not start:
            return self
        origin, before, starts_before = self._values_of
        given = {**before, **parameter_numbers(parameters)}
        starts = {**starts_before, **parameter_numbers(start or {})}
        stages = origin._all_stages()
        assert stages.definition is not None
        try:
            system = origin.changed_values().system(given, starts)
        except StructureChanges:
            every = {**stages.given, **given}
            return _compiled(compile_class(stages.definition, every)).with_values({}, starts)
        result = Compiled(system, self.timings, self.warnings, stages, self._again)
        result._values_of = origin, given, starts
        return result

    @property
    def equations(self) -> Equations:
        """The equations as formulas: LaTeX, and shown as such by notebooks."""
        from acausal.inspection.display import equations_of
        from acausal.reference.mathml import mathml

        flattened = self._all_stages().flattened
        assert flattened is not None
        return equations_of(flattened, mathml)

    def _repr_html_(self) -> str:
        """Return what a notebook shows: counts, states, parameters."""
        from acausal.inspection.display import compiled_html

        return compiled_html(self._all_stages())

    def changed_values(self) -> ChangedValues:
        """Return what makes systems with other parameters and start values of this one."""
        from acausal.simulation.changed_values import ChangedValues

        if self._changes is None:
            flattened = self._all_stages().flattened
            assert flattened is not None
            self._changes = ChangedValues(flattened, self.system)
        return self._changes

    def _all_stages(self) -> Stages:
        """Return what the stages made, compiled once more if the model came from the cache."""
        if self.stages is None:
            assert self._again is not None
            self.stages = self._again()
        return self.stages


def compile_file(
    path: str | Path, model: str | None = None, parameters: Mapping[str, float | str] | None = None
) -> Compiled:
    """Compile a model of a file.

    Args:
        path: The file.
        model: Name of the model; the last one of the file by default.
        parameters: Values by path: numbers in SI units, or texts such as ``"10[kOhm]"``.

    Raises:
        AcausalError: For a file that cannot be read and for any mistake in the model.
    """
    from acausal.simulation.compiled_cache import recall, remember

    given = parameter_numbers(parameters or {})
    begun = time.perf_counter()
    found = recall(Path(path), model, given)
    if found is not None:
        system, warnings = found
        timings = {"recall": time.perf_counter() - begun}
        again = partial(_stages_of_path, Path(path), model, given)
        return Compiled(system, timings, warnings, again=again)
    stages, sources = _compile_path(Path(path), model, given)
    compiled = _compiled(stages)
    with stages.timed("remember"):
        remember(Path(path), model, given, sources, (compiled.system, compiled.warnings))
    return compiled


def compile_text(
    text: str, model: str | None = None, parameters: Mapping[str, float | str] | None = None
) -> Compiled:
    """Compile a model of a text, see :func:`compile_file`."""
    from acausal.modeling.load import choose_model, load_text

    classes, _ = load_text(text)
    return compile_definition(choose_model(classes, model, "the text"), parameters)


def compile_definition(
    definition: ClassDef, parameters: Mapping[str, float | str] | None = None
) -> Compiled:
    """Compile a model that was read, or made in Python, see :func:`compile_file`."""
    return _compiled(compile_class(definition, parameter_numbers(parameters or {})))


def _compiled(stages: Stages) -> Compiled:
    assert stages.system is not None and stages.elimination is not None
    return Compiled(stages.system, stages.timings, stages.elimination.model.warnings, stages)


def _compile_path(
    path: Path, model: str | None, given: Mapping[str, float], stages: Stages | None = None
) -> tuple[Stages, list[Path]]:
    from acausal.modeling.load import choose_model, load_file

    stages = Stages() if stages is None else stages
    with stages.timed("parse"):
        classes, root = load_file(path)
        definition = choose_model(classes, model, str(path))
    compile_class(definition, given, stages)
    return stages, [path, *root.sources]


def _stages_of_path(path: Path, model: str | None, given: Mapping[str, float]) -> Stages:
    return _compile_path(path, model, given)[0]


class GivenValue(float):
    """A number in SI units that knows its dimension, if it was given with a unit."""

    dimension: tuple[Any, ...] | None = None


def parameter_numbers(parameters: Mapping[str, float | str]) -> dict[str, float]:
    """Return parameter values as SI numbers; texts may carry a unit, or be true or false.

    Raises:
        AcausalError: ``F110`` for a text that is no number.
    """
    result: dict[str, float] = {}
    for name, value in parameters.items():
        if not isinstance(value, str):
            result[name] = float(value)
            continue
        from acausal.diagnostics import fail
        from acausal.instantiation.environment import ClassEnvironment
        from acausal.instantiation.expressions import elaborate
        from acausal.instantiation.values import constants
        from acausal.modeling.classes import ClassDef
        from acausal.syntax import tree
        from acausal.syntax.parser import parse_expression

        try:
            result[name] = float(value)
            continue
        except ValueError:
            expression = parse_expression(value, f"<{name}>")
        nowhere = ClassDef(tree.ClassDefinition(expression.span, "model", "command"), None)
        number = elaborate(expression, ClassEnvironment(None, nowhere))
        numbers = constants(number) if number.text is None else None
        if numbers is None or numbers.shape:
            fail("F110", f"{value} is not a number", expression.span,
                 help=f"write {name}=12.5 or {name}=10[kOhm]")  # fmt: skip
        value_ = GivenValue(float(numbers))
        value_.dimension = number.unit if isinstance(number.unit, tuple) else None
        result[name] = value_
    return result


def check_file(path: str | Path, model: str | None = None) -> Any:
    """Compile a model without simulating it and return a summary with counts.

    Raises:
        AcausalError: For any mistake in the model.
    """
    from acausal.inspection.summary import summary

    stages, _ = _compile_path(Path(path), model, {})
    return summary(stages)


def inspect_file(
    path: str | Path,
    model: str | None = None,
    stage: str = "all",
    latex: bool = False,
    parameters: Mapping[str, float | str] | None = None,
) -> str:
    """Return what a stage, or each stage, has made of a model, as text.

    A single stage can be shown if a later one fails: the junctions of a model without a ground.

    Raises:
        AcausalError: For any mistake in the model that keeps it from coming to the stage.
    """
    from acausal.diagnostics import AcausalError
    from acausal.inspection.inspect import inspect, reached

    stages = Stages()
    try:
        _compile_path(Path(path), model, parameter_numbers(parameters or {}), stages)
    except AcausalError:
        if not reached(stages, stage):
            raise
    return inspect(stages, stage, latex)
