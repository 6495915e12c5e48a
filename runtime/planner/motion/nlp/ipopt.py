"""The same programs through IPOPT with exact Hessians: reference and fallback (Wächter and Biegler 2006)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np

from ....budget import Budget
from ....skeleton import Array
from .augmented_lagrangian import SolverOptions, SolverResult, SolverStatus
from .program import Program
from .settings import SOLVER
from .unknowns import Indices


def _construct(self: Any, name: str, inputs: list[int], outputs: list[Any], function: Any) -> None:
    ca.Callback.__init__(self)
    self.inputs, self.outputs, self.function = inputs, outputs, function
    self.construct(name, {})


def _evaluate(self: Any, arguments: Any) -> list[Any]:
    results = self.function(*[np.array(a).ravel() for a in arguments])
    return [ca.DM(pattern, ca.DM(result)) for pattern, result in zip(self.outputs, results, strict=True)]


_Call: Any = type(
    "_Call",
    (ca.Callback,),
    {
        "__doc__": "A function of a program as CasADi calls it: from vectors to matrices of fixed patterns.",
        "__init__": _construct,
        "get_n_in": lambda self: len(self.inputs),
        "get_n_out": lambda self: len(self.outputs),
        "get_sparsity_in": lambda self, i: ca.Sparsity.dense(self.inputs[i], 1),
        "get_sparsity_out": lambda self, i: self.outputs[i],
        "eval": _evaluate,
    },
)


class _Pattern:
    """A sparse pattern of (row, column) entries that may repeat; repeated ones add up."""

    def __init__(self, rows: Indices, columns: Indices, shape: tuple[int, int]) -> None:
        keys, self.into = np.unique(columns * shape[0] + rows, return_inverse=True)
        self.sparsity = ca.Sparsity.triplet(
            *shape, (keys % shape[0]).tolist(), (keys // shape[0]).tolist()
        )  # fmt: skip
        self.size = len(keys)

    def values(self, entries: Array) -> Array:
        return np.asarray(np.bincount(self.into, entries, minlength=self.size), dtype=np.float64)


def _functions(program: Program, x: Array) -> tuple[dict[str, Any], dict[str, Any]]:
    """The problem in CasADi's terms, and all its functions, which CasADi itself does not keep alive."""
    n = program.unknowns
    _, equality, inequality = program.residuals(x)
    m = len(equality) + len(inequality)
    _, rows, columns = program.jacobian(x)
    pattern = _Pattern(rows, columns, (m, n))
    below, along = np.meshgrid(np.arange(n), np.arange(program.width), indexing="ij")
    inside = (below + along < n).ravel()
    triangle = _Pattern(below.ravel()[inside], (below + along).ravel()[inside], (n, n))

    def cost(x: Array, *_: Array) -> list[Any]:
        return [program.objective(x)]

    def gradient(x: Array, *_: Array) -> list[Any]:
        residuals = program.residuals(x)
        none = (np.zeros(len(equality)), np.zeros(len(inequality)))
        flat = (residuals[0], np.zeros(len(equality)), np.full(len(inequality), -1.0))
        return [program.objective(x), program.normal(x, flat, none, 1.0)[0]]

    def constraints(x: Array, *_: Array) -> list[Any]:
        return [np.concatenate(program.residuals(x)[1:])]

    def jacobian(x: Array, *_: Array) -> list[Any]:
        return [np.concatenate(program.residuals(x)[1:]), pattern.values(program.jacobian(x)[0])]

    def hessian(x: Array, _: Array, weight: Array, multipliers: Array) -> list[Any]:
        split = (multipliers[: len(equality)], multipliers[len(equality) :])
        band = program.hessian(x, float(weight[0]), split)
        return [triangle.values(band.ravel()[inside])]

    def call(name: str, inputs: list[int], outputs: list[Any], function: Callable[..., list[Any]]) -> Any:
        return _Call(name, inputs, outputs, function)

    scalar, dense = ca.Sparsity.dense(1, 1), ca.Sparsity.dense
    symbol = ca.MX.sym("x", n)
    calls = {
        "f": call("f", [n], [scalar], cost),
        "g": call("g", [n], [dense(m, 1)], constraints),
        "grad_f": call("grad_f", [n, 0], [scalar, dense(n, 1)], gradient),
        "jac_g": call("jac_g", [n, 0], [dense(m, 1), pattern.sparsity], jacobian),
        "hess_lag": call("hess_lag", [n, 0, 1, m], [triangle.sparsity], hessian),
    }
    problem = {"x": symbol, "f": calls["f"](symbol), "g": calls["g"](symbol)}
    return problem, calls


def solve_ipopt(program: Program, start: Array, options: SolverOptions, budget: Budget) -> SolverResult:
    """Minimise `program` from `start`, to an optimum. Raises OutOfTime."""
    budget.check()
    problem, calls = _functions(program, start)
    settings: Any = {
        "print_level": 0, "sb": "yes", "max_iter": SOLVER.ipopt_iterations, "tol": 1e-4,
        "constr_viol_tol": options.tolerance / 10, "acceptable_tol": 1e-2, "acceptable_iter": 5,
        "acceptable_constr_viol_tol": options.tolerance,
        "max_wall_time": min(1e6, max(1e-3, budget.remaining)), "mu_strategy": "adaptive",
    }  # fmt: skip
    given: Any = {name: calls[name] for name in ("grad_f", "jac_g", "hess_lag")}
    solver = ca.nlpsol(
        "ipopt", "ipopt", problem, {**given, "print_time": False, "no_nlp_grad": True, "ipopt": settings}
    )
    _, equality, inequality = program.residuals(start)
    lower = np.concatenate([np.zeros(len(equality)), np.full(len(inequality), -math.inf)])
    solution = solver(x0=start, lbg=lower, ubg=np.zeros(len(lower)))
    budget.check()
    x = np.array(solution["x"]).ravel()
    statistics = solver.stats()
    status = SolverStatus.FEASIBLE if statistics["success"] else SolverStatus.STALLED
    return SolverResult(x, int(statistics["iter_count"]), status)
