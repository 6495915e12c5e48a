"""Stage Functions: a residual and its dense Jacobian over a few slots, evaluated for many instances at once."""

from __future__ import annotations

from functools import cache
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from .kinematics import Expression

Array = NDArray[np.float64]


@cache
def _bucket(count: int) -> int:
    """The batch size, at most a third above `count`, for which a mapped Function is kept."""
    size = 1
    while size < count:
        size = size + max(1, size // 3)
    return size


class _Batch:
    """One Function mapped over `size` instances, with its own input and output memory."""

    def __init__(self, function: Any, size: int) -> None:
        mapped = function.map(size) if size > 1 else function
        self.buffer, self.trigger = mapped.buffer()
        self.inputs = [np.zeros((size, max(1, function.nnz_in(i)))) for i in range(function.n_in())]
        self.outputs = [np.zeros((size, function.nnz_out(i))) for i in range(function.n_out())]
        for i, array in enumerate(self.inputs):
            self.buffer.set_arg(i, array.reshape(-1).data)
            array[:] = 1.0
        for i, array in enumerate(self.outputs):
            self.buffer.set_res(i, array.reshape(-1).data)

    def __call__(self, *arguments: Array) -> list[Array]:
        count = len(arguments[0])
        for array, argument in zip(self.inputs, arguments, strict=True):
            width = argument.shape[1]
            if width:
                array[:count, :width] = argument
        self.trigger()
        return [array[:count] for array in self.outputs]


class Stage:
    """A residual r(X, P) with `rows` rows over `inputs` variables X and `parameters` constants P."""

    def __init__(self, name: str, variables: Expression, constants: Expression, residual: Expression) -> None:
        self.name = name
        self.inputs: int = variables.numel()
        self.parameters: int = constants.numel()
        self.rows: int = residual.numel()
        self._expressions = (variables, constants, ca.densify(residual))
        self._functions: dict[str, Any] = {}
        self._batches: dict[tuple[str, int], _Batch] = {}

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

    def _call(self, what: str, *arguments: Array) -> list[Array]:
        size = _bucket(len(arguments[0]))
        batch = self._batches.get((what, size))
        if batch is None:
            batch = self._batches[what, size] = _Batch(self._function(what), size)
        return batch(*arguments)

    def values(self, variables: Array, constants: Array, scale: float = 1.0) -> Array:
        """Residuals (N, rows), times `scale`, of N instances: variables (N, inputs), constants (N, parameters)."""
        values: Array = scale * self._call("values", variables, constants)[0]
        return values

    def jacobians(self, variables: Array, constants: Array, scale: float = 1.0) -> Array:
        """Dense Jacobians (N, rows, inputs), times `scale`."""
        flat = scale * self._call("jacobians", variables, constants)[0]
        return flat.reshape(-1, self.rows, self.inputs)

    def hessians(self, variables: Array, constants: Array, weights: Array) -> Array:
        """Hessians (N, inputs, inputs) of weights · r, for weights (N, rows)."""
        return self._call("hessians", variables, constants, weights)[0].reshape(-1, self.inputs, self.inputs).copy()
