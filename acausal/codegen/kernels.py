"""Native kernels of templates: compiled once, cached on disk by content, loaded once.

The functions of a kernel have the signature of ``docs/architecture.md``::

    residual(i64 count, f64* w, i32* index[m][count], i32* target[count], f64* out)
    value   (the same)                                   stores instead of adding
    jacobian(i64 count, f64* w, i32* index[m][count], i32* entry[q][count], f64* out)

Every kernel is a cache entry of its own. Loading fifty takes two milliseconds, so there is
nothing to gain from bundles, and a change of one class recompiles that class only.
"""

from __future__ import annotations

import ctypes
import logging
import struct
import threading
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property
from hashlib import blake2b
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

import acausal.expressions
from acausal.codegen import engine
from acausal.codegen.ir import KernelCode
from acausal.codegen.llvm import DECLARATIONS, print_kernel, print_value_kernel
from acausal.codegen.lower import lower
from acausal.expressions.differentiate import partials
from acausal.expressions.nodes import ZERO, Expr, slot
from acausal.expressions.serialize import Record, from_records, to_records
from acausal.expressions.traverse import postorder
from acausal.storage import cache_directory

_log = logging.getLogger(__name__)
_CACHE_KIND: Final = "kernel"
#: Kernels of more weight (about LLVM instructions) would take seconds to compile for speed.
_LARGE: Final = 10_000

_KERNEL_TYPE: Final = ctypes.CFUNCTYPE(
    None, ctypes.c_int64, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p
)


@dataclass(frozen=True)
class Kernel:
    """Native functions of one template.

    Attributes:
        template: Expression over integer slots.
        slots: The slots that partial derivatives were asked for.
        m: Number of operands of a member (rows of its index array).
        variable_slots: Those of ``slots``, in their order, with a structurally non-zero partial
            derivative; ``q`` of them.
        jacobian_operands: The slots that the partial derivatives read.
        jacobian_reads_time: Whether the partial derivatives read the time.
        key: Content hash of the template, the slots asked for and the code generator.
        residual: Address of the function that adds the template's value.
        jacobian: Address of the function that adds the partial derivatives.
        value: Address of the function that stores the template's value.
    """

    template: Expr = field(repr=False)  # a shared DAG may unfold without limit
    slots: tuple[int, ...]
    m: int
    variable_slots: tuple[int, ...]
    jacobian_operands: tuple[int, ...]
    jacobian_reads_time: bool
    key: str
    residual: int
    jacobian: int
    value: int

    def __reduce__(self) -> tuple[Callable[..., Kernel], tuple[object, ...]]:
        # Addresses mean nothing in another process.
        return (_restored, (*to_records(self.template), self.slots))

    @property
    def q(self) -> int:
        """Number of structurally non-zero partial derivatives."""
        return len(self.variable_slots)

    def evaluate_residual(
        self,
        w: NDArray[np.float64],
        index: NDArray[np.int32],
        target: NDArray[np.int32],
        out: NDArray[np.float64],
    ) -> None:
        """Add: ``out[target[k]] += f(w[index[:, k]])``, in the order of ``k``.

        Args:
            w: Work vector; ``w[1]`` is the time in s.
            index: Positions in ``w``, shape ``(m, count)``.
            target: Positions in ``out``, shape ``(count,)``.
            out: Accumulated into.

        Raises:
            ValueError: Wrong shapes, types or memory layout.
        """
        self._run(self._functions[0], 1, w, index, target, out)

    def evaluate_value(
        self,
        w: NDArray[np.float64],
        index: NDArray[np.int32],
        target: NDArray[np.int32],
        out: NDArray[np.float64],
    ) -> None:
        """Store: ``out[target[k]] = f(w[index[:, k]])``; arguments as ``evaluate_residual``."""
        self._run(self._functions[1], 1, w, index, target, out)

    def evaluate_jacobian(
        self,
        w: NDArray[np.float64],
        index: NDArray[np.int32],
        entry: NDArray[np.int32],
        out: NDArray[np.float64],
    ) -> None:
        """Add: ``out[entry[j, k]] += df/d(variable_slots[j])``; ``entry``: shape ``(q, count)``."""
        self._run(self._functions[2], self.q, w, index, entry, out)

    @cached_property
    def _functions(self) -> tuple[Callable[..., None], ...]:
        return tuple(_KERNEL_TYPE(a) for a in (self.residual, self.value, self.jacobian))

    def _run(
        self,
        function: Callable[..., None],
        rows: int,
        w: NDArray[np.float64],
        index: NDArray[np.int32],
        target: NDArray[np.int32],
        out: NDArray[np.float64],
    ) -> None:
        count = index.shape[-1]
        if index.shape != (self.m, count) or target.size != rows * count:
            raise ValueError(
                f"kernel of {self.m} operands and {rows} outputs given index {index.shape} "
                f"and targets {target.shape}"
            )
        for array, kind in ((w, np.float64), (index, np.int32), (target, np.int32)):
            _check_array(array, kind)
        _check_array(out, np.float64)
        function(count, w.ctypes.data, index.ctypes.data, target.ctypes.data, out.ctypes.data)


def _check_array(array: NDArray[Any], kind: type) -> None:
    if array.dtype != kind or not array.flags.c_contiguous:
        raise ValueError(f"kernels need C-contiguous arrays of {kind.__name__}")


@dataclass(frozen=True)
class TemplateCode:
    """A template in statement form, for the interpreter and for people.

    Attributes:
        m: Number of operands.
        variable_slots: As in ``Kernel``.
        residual: Code of the template's value.
        jacobian: Code of its partial derivatives, one output for each of ``variable_slots``.
    """

    m: int
    variable_slots: tuple[int, ...]
    residual: KernelCode
    jacobian: KernelCode


class _Entry(NamedTuple):
    """What the cache keeps of a kernel."""

    variable_slots: tuple[int, ...]
    jacobian_operands: tuple[int, ...]
    jacobian_reads_time: bool
    code: bytes


_loaded: dict[tuple[Expr, tuple[int, ...]], Kernel] = {}
_lock: Final = threading.Lock()


def compile_kernels(templates: Sequence[tuple[Expr, tuple[int, ...]]]) -> list[Kernel]:
    """Return the native kernels of templates, from memory, from the disk cache or compiled.

    Args:
        templates: Pairs of an expression over integer slots ``0 .. m-1`` and the slots by which
            it is differentiated.

    Returns:
        One kernel for each pair, in order. Their code stays loaded for the life of the process.
    """
    with _lock:
        wanted = dict.fromkeys(pair for pair in templates if pair not in _loaded)
        entries: dict[str, _Entry] = {}
        keys = {pair: template_key(*pair) for pair in wanted}
        compiled = 0
        for pair, key in keys.items():
            cached = _unpack(cache_directory.read(_CACHE_KIND, key))
            if cached is None:
                compiled += 1
                cached = _compile(key, *pair)
                cache_directory.write(_CACHE_KIND, key, _pack(cached))
            entries[key] = cached
        if entries:
            engine.load_objects([entry.code for entry in entries.values()])
            _log.debug("kernels: %d compiled, %d cached", compiled, len(entries) - compiled)
        for pair, key in keys.items():
            residual, jacobian, value = (engine.address_of(f"{n}_{key}") for n in _NAMES)
            entry = entries[key]
            _loaded[pair] = Kernel(
                template=pair[0],
                slots=pair[1],
                m=_slot_count(*pair),
                variable_slots=entry.variable_slots,
                jacobian_operands=entry.jacobian_operands,
                jacobian_reads_time=entry.jacobian_reads_time,
                key=key,
                residual=residual,
                jacobian=jacobian,
                value=value,
            )
        return [_loaded[pair] for pair in templates]


def _restored(
    records: tuple[Record, ...], roots: tuple[int, ...], slots: tuple[int, ...]
) -> Kernel:
    return compile_kernels([(from_records(records, roots)[0], slots)])[0]


_NAMES: Final = ("residual", "jacobian", "value")


def template_code(template: Expr, slots: Iterable[int]) -> TemplateCode:
    """Return the statement form of a template and of its partial derivatives by ``slots``."""
    slots = tuple(slots)
    derivatives = partials(template, [slot(number) for number in slots])
    kept = tuple(number for number in slots if derivatives[slot(number)] is not ZERO)
    m = _slot_count(template, slots)
    jacobian = lower([derivatives[slot(number)] for number in kept], m)
    return TemplateCode(m, kept, lower([template], m), jacobian)


def template_key(template: Expr, slots: Sequence[int]) -> str:
    """Return the content hash that names the kernel of a template on this machine."""
    order = postorder(template)
    number = {item: position for position, item in enumerate(order)}
    parts = [_generator_identity(), repr(tuple(slots))]
    for item in order:
        value = item.value.hex() if isinstance(item.value, float) else repr(item.value)
        parts.append(f"{item.op} {value} {' '.join([str(number[a]) for a in item.args])}")
    return blake2b("\n".join(parts).encode(), digest_size=16).hexdigest()


def _slot_count(template: Expr, slots: Sequence[int]) -> int:
    used = [item.value for item in postorder(template) if item.op == "slot"]
    numbers = [number for number in used if isinstance(number, int)]
    assert len(numbers) == len(used), "templates have integer slots"
    return max([*numbers, *slots], default=-1) + 1


@cache
def _generator_identity() -> str:
    """Return a hash of what turns templates into code: our own sources and LLVM."""
    digest = blake2b(engine.target_identity().encode(), digest_size=16)
    for folder in (Path(__file__).parent, Path(acausal.expressions.__file__).parent):
        for path in sorted(folder.glob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()


def _compile(key: str, template: Expr, slots: tuple[int, ...]) -> _Entry:
    code = template_code(template, slots)
    text = "".join((
        DECLARATIONS,
        print_kernel(f"residual_{key}", code.residual),
        print_kernel(f"jacobian_{key}", code.jacobian),
        print_value_kernel(f"value_{key}", f"residual_{key}"),
    ))  # fmt: skip
    read = (*code.jacobian.prologue, *code.jacobian.body)
    return _Entry(
        code.variable_slots,
        tuple(sorted({int(item.value or 0) for item in read if item.op == "load"})),
        any(item.op == "time" for item in read),
        engine.compile_object(text, _level(code)),
    )


def _level(code: TemplateCode) -> int:
    """Return the effort of code generation: it grows faster than linearly with straight code."""
    return 0 if max(code.residual.weight, code.jacobian.weight) > _LARGE else 1


_HEAD: Final = struct.Struct("<ii?")


def _pack(entry: _Entry) -> bytes:
    slots = (*entry.variable_slots, *entry.jacobian_operands)
    head = _HEAD.pack(
        len(entry.variable_slots), len(entry.jacobian_operands), entry.jacobian_reads_time
    )
    return head + struct.pack(f"<{len(slots)}i", *slots) + entry.code


def _unpack(data: bytes | None) -> _Entry | None:
    if data is None:
        return None
    try:
        variables, operands, reads_time = _HEAD.unpack_from(data)
        slots = struct.unpack_from(f"<{variables + operands}i", data, _HEAD.size)
    except struct.error:
        return None
    code = data[_HEAD.size + 4 * len(slots) :]
    return _Entry(slots[:variables], slots[variables:], reads_time, code)
