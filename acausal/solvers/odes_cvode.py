"""CVODE through scikits-odes on the explicit form: variable order, variable step BDF, dense."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from acausal.solvers.explicit_form import ExplicitForm
from acausal.solvers.odes import OdesIntegrator, odes_module
from acausal.solvers.system import NativeSystem

Array = NDArray[np.float64]


class OdesCVODEIntegrator(OdesIntegrator):
    """The integrator ``odes-cvode``; see :class:`acausal.solvers.protocol.Integrator`."""

    def _use(self, system: NativeSystem) -> None:
        self._system = system
        self._module = odes_module("cvode")
        options = self._options
        self._form = ExplicitForm(
            system,
            self._t,
            self.y,
            self.yp,
            options.relative_tolerance,
            options.absolute_tolerance,
            options.labels,
        )
        self._x = np.zeros(self._form.size)

    def _derivative(self, tau: float, x: Array, out: Array) -> int:
        t = self._t_base + tau
        before = self._form.evaluations

        def work() -> Array:
            out[:] = self._form.derivative(t, x)
            return out

        code = self._guard(work, t)
        self._residuals += self._form.evaluations - before
        return code

    def _jacobian(self, tau: float, x: Array, f: Array, matrix: Array) -> int:
        self._jacobians += 1
        t = self._t_base + tau

        def work() -> Array:
            matrix[:] = self._form.jacobian(t, x)
            return matrix

        return self._guard(work, t)

    def _begin(self, first_step: float) -> Any:
        options = self._common_options(first_step)
        self._atol = self._form.absolute_tolerances(self._options.absolute_tolerance)
        options.update(
            atol=self._atol,  # kept: the solver has a pointer to it
            lmm_type="BDF",
            nonlinsolver="newton",
            linsolver="dense",
            jacfn=self._jacobian,
        )
        # Where the start is no solution, say so here and not as a step that is too small.
        self._form.point(self._t, self._form.x(self.y))
        solver = self._module.CVODE(self._derivative, **options)
        self._start_x = self._form.x(self.y)
        solver.init_step(0.0, self._start_x)
        return solver

    def _begin_again(self) -> None:
        self._start_x = self._form.x(self.y)
        self._solver.reinit_IC(0.0, self._start_x)

    def _call(self, tau: float) -> tuple[int, float]:
        result = self._solver.step(tau, self._x)
        flag = int(result.flag)
        return flag, float(result.values.t if flag >= 0 else result.errors.t)

    def _read(self, t: float) -> tuple[Array, Array]:
        return self._form.point(t, self._x)
