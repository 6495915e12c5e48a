#!/bin/sh
# CasADi 3.8.2 takes an expression for linear when its derivative holds no unknown. The derivative of floor, sign, a comparison or
# fmod with a constant is a constant, so these count as linear: `is_linear` says so, `linear_coeff` returns coefficients in
# which their steps are missing without a word, and `qpsol`, which is built on them, solves a problem with a row that is not the one
# that was written: floor(x) <= 1 lets x = 2.7 pass, `success` is True, and even the value of the row that it returns is 0, not 2.
# `if_else`, `fabs` and `fmax` are told as not linear, so one expects the same of the others.
# Who classes rows by `is_linear` evaluates what `linear_coeff` gave at a few points first, or refuses steps by name.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check casadi==3.8.2
cat > "$folder/look.py" <<'PY'
import casadi as ca

for kind in (ca.SX, ca.MX):
    x = kind.sym("x")
    told = {
        "floor(x)": ca.is_linear(ca.floor(x), x),
        "sign(x)": ca.is_linear(ca.sign(x), x),
        "x > 0": ca.is_linear(x > 0, x),
        "fmod(x, 1)": ca.is_linear(ca.fmod(x, 1), x),
        "fabs(x)": ca.is_linear(ca.fabs(x), x),
        "if_else": ca.is_linear(ca.if_else(x > 0, x, 2 * x), x),
    }
    print(kind.__name__, "linear:", told)
    assert [*told.values()] == [True, True, True, True, False, False], "classed otherwise now"

x = ca.SX.sym("x", 2)
slope, rest = ca.linear_coeff(ca.floor(x[0]) + x[1], x)
print("linear_coeff(floor(x0) + x1): slope", slope, "rest", rest)
assert str(slope) == "[[0, 1]]" and str(rest) == "0", "the step is no longer dropped"

x = ca.SX.sym("x")
problem = {"x": x, "f": (x - 2.7) ** 2, "g": ca.floor(x)}
quiet = {"print_time": False, "print_iter": False, "print_header": False, "print_info": False}
solver = ca.qpsol("solver", "qrqp", problem, quiet)
found = solver(x0=0, lbg=-ca.inf, ubg=1)
print("least (x - 2.7)^2 with floor(x) <= 1: x =", found["x"], "row told as", found["g"], "success", solver.stats()["success"])
assert abs(float(found["x"]) - 2.7) < 1e-6 and float(found["g"]) == 0.0 and solver.stats()["success"], "solved otherwise"
PY
"$folder/venv/bin/python" "$folder/look.py"
