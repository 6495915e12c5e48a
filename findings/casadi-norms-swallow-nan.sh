#!/bin/sh
# In CasADi 3.8.2 the infinity norm and the greatest entry of a vector that holds a NaN are those of its other entries, with numbers
# (DM), scalar expressions (SX) and matrix expressions (MX) alike: `norm_inf([1, NaN, 0])` is 1, where NumPy's is NaN. So the usual
# test of a solution, that the greatest residual is below a tolerance, passes a residual that is no number. The other usual test fails
# too: of a symbol, `x != x` is simplified to 0 when it is written, so that a Function of it never tells a NaN.
# The 1- and 2-norm do give NaN. Who checks residuals takes the array to NumPy first, or adds a test with a sum.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check casadi==3.8.2 numpy==2.4.6
cat > "$folder/look.py" <<'PY'
import casadi as ca
import numpy as np

residual = [1.0, float("nan"), 0.0]
numbers = ca.norm_inf(ca.DM(residual)), ca.mmax(ca.DM(residual))
print("numbers:", *numbers, "and NumPy's norm", np.linalg.norm(residual, np.inf))
assert [float(n) for n in numbers] == [1.0, 1.0], "a NaN is told now"
assert np.isnan(np.linalg.norm(residual, np.inf))

for kind in (ca.SX, ca.MX):
    x = kind.sym("x", 3)
    values = ca.Function("norms", [x], [ca.norm_inf(x), ca.mmax(x), ca.norm_1(x), ca.norm_2(x)])(residual)
    print(kind.__name__, "infinity norm, greatest entry, 1-norm, 2-norm:", *values)
    assert [float(v) for v in values[:2]] == [1.0, 1.0], "a NaN is told now"
    assert all(np.isnan(float(v)) for v in values[2:]), "a NaN is no longer told"
    own = ca.Function("own", [x], [x[0] != x[0]])([float("nan"), 0.0, 0.0])
    print(kind.__name__, "x != x of NaN:", own)
    assert float(own) == 0.0, "a NaN differs from itself now"
PY
"$folder/venv/bin/python" "$folder/look.py"
