"""Stage Functions: a residual and its dense Jacobian over a few slots, evaluated for many instances at once."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from ..hulls import Array
from .kinematics import Expression

Indices = NDArray[np.int64]


@cache
def _bucket(count: int) -> int:
    """The batch size, at most a third above `count`, for which a mapped Function is kept."""
    size = 1
    while size < count:
        size = size + max(1, size // 3)
    return size


class StageBatch:
    """One Function of one output, mapped over instances, with its own memory for inputs and output."""

    def __init__(self, mapped: Any, widths: Sequence[int], size: int, rows: int) -> None:
        """`mapped` takes `widths` numbers of each of `size` instances and gives `rows`."""
        self.buffer, self.trigger = mapped.buffer()
        inputs = [np.ones((size, max(1, width))) for width in widths]
        self.inputs = [(i, array) for i, array in enumerate(inputs) if widths[i]]
        self.output = np.zeros((size, rows))
        for i, array in enumerate(inputs):
            self.buffer.set_arg(i, array.reshape(-1).data)
        self.buffer.set_res(0, self.output.reshape(-1).data)

    def __call__(self, *arguments: Array) -> Array:
        """Outputs (N, …), valid until the next call, of N <= size instances with arguments (N, …)."""
        count = len(arguments[0])
        for i, array in self.inputs:
            array[:count] = arguments[i]
        self.trigger()
        return self.output[:count]


class PlacedBatch:
    """The same of instances whose variables are always those at `places` (N, inputs) of a vector, with `constants`
    (N, parameters) that stay."""

    def __init__(self, batch: StageBatch, places: Indices, constants: Array) -> None:
        self._trigger = batch.trigger
        self._places, self._found = places.reshape(-1), batch.output[: len(places)]
        self._batch = batch
        arrays = dict(batch.inputs)
        self._variables = arrays[0].reshape(-1)[: places.size] if 0 in arrays else None
        if 1 in arrays:
            arrays[1][: len(places)] = constants

    def __call__(self, z: Array) -> Array:
        """Outputs (N, …) at z, valid until the next call."""
        if self._variables is not None:
            z.take(self._places, out=self._variables, mode="clip")  # "raise" would copy
        self._trigger()
        return self._found


class Stage:
    """A residual r(X, P) with `rows` rows over `inputs` variables X and `parameters` constants P."""

    def __init__(self, name: str, variables: Expression, constants: Expression, residual: Expression) -> None:
        self.name = name
        self.inputs: int = variables.numel()
        self.parameters: int = constants.numel()
        self.rows: int = residual.numel()
        self._expressions = (variables, constants, ca.densify(residual))
        self._functions: dict[str, Any] = {}
        self._mapped: dict[tuple[str, int], Any] = {}
        self._batches: dict[tuple[str, int], StageBatch] = {}

    def _function(self, what: str) -> Any:
        if what not in self._functions:
            x, p, r = self._expressions
            if what == "values":
                made = ca.Function("values", [x, p], [r])
            elif what == "jacobians":
                made = ca.Function("jacobians", [x, p], [ca.densify(ca.jacobian(r, x)).T])
            else:
                weights = ca.SX.sym("weights", self.rows)
                made = ca.Function("hessians", [x, p, weights], [ca.densify(ca.hessian(ca.dot(weights, r), x)[0])])
            self._functions[what] = made
        return self._functions[what]

    def _made(self, what: str, size: int) -> StageBatch:
        """What finds "values", "jacobians" or "hessians" of at most `size` instances."""
        function = self._function(what)
        if (what, size) not in self._mapped:
            self._mapped[what, size] = function.map(size) if size > 1 else function
        widths = [function.nnz_in(i) for i in range(function.n_in())]
        return StageBatch(self._mapped[what, size], widths, size, function.nnz_out(0))

    def batch(self, what: str, count: int) -> StageBatch:
        """What finds "values", "jacobians" or "hessians" of `count` instances; other rows use it, too."""
        size = _bucket(count)
        found = self._batches.get((what, size))
        if found is None:
            found = self._batches[what, size] = self._made(what, size)
        return found

    def placed(self, what: str, places: Indices, constants: Array) -> PlacedBatch:
        """What finds "values" or "jacobians" at places (N, inputs) of vectors, for rows that ask for them often."""
        return PlacedBatch(self._made(what, _bucket(len(places))), places, constants)

    def values(self, variables: Array, constants: Array) -> Array:
        """Residuals (N, rows) of N instances, from variables (N, inputs) and constants (N, parameters)."""
        return self.batch("values", len(variables))(variables, constants).copy()

    def jacobians(self, variables: Array, constants: Array, scale: float = 1.0) -> Array:
        """Dense Jacobians (N, rows, inputs), times `scale`."""
        flat = scale * self.batch("jacobians", len(variables))(variables, constants)
        return flat.reshape(-1, self.rows, self.inputs)

    def hessians(self, variables: Array, constants: Array, weights: Array) -> Array:
        """Hessians (N, inputs, inputs) of weights · r, for weights (N, rows)."""
        found = self.batch("hessians", len(variables))(variables, constants, weights)
        return found.reshape(-1, self.inputs, self.inputs).copy()
