#!/bin/sh
# CasADi 3.8.2: short_circuit=True is documented as a matter of speed (only the branch that is taken is computed). It also
# changes which branch that is, where the condition is a number and no comparison. In MX:
# - if_else(x, a, b) takes a wherever x is not 0; with short_circuit the condition is rounded towards 0 first, so that 0.3, 0.999
#   and -0.5 give b;
# - conditional(x, [a, b], default) gives the default unless x is 0 or 1 exactly; with short_circuit 0.9 gives a, 1.5 gives b.
# Who turns it on for speed keeps to comparisons as conditions (x != 0, x > 0). tamplang uses neither with a number as condition.
set -eu
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" install -q --disable-pip-version-check casadi==3.8.2 numpy==2.4.6
cat > "$folder/look.py" <<'PY'
import casadi as ca

x = ca.MX.sym("x")
plain, lazy = (ca.Function("f", [x], [ca.if_else(x, 10, 20, short)]) for short in (False, True))
for value in (0.0, 0.3, 0.999, 1.0, -0.5):
    print(f"if_else({value:g}, 10, 20): {float(plain(value)):g}, with short_circuit {float(lazy(value)):g}")
    assert float(plain(value)) == (10 if value else 20)
    assert float(lazy(value)) == (10 if abs(value) >= 1 else 20)
plain, lazy = (ca.Function("f", [x], [ca.conditional(x, [10, 20], 99, short)]) for short in (False, True))
for value in (0.0, 0.9, 1.0, 1.5, 2.0):
    print(f"conditional({value:g}, [10, 20], 99): {float(plain(value)):g}, with short_circuit {float(lazy(value)):g}")
    assert float(plain(value)) == (99 if value != int(value) or value >= 2 else 10 * (int(value) + 1))
    assert float(lazy(value)) == (99 if value >= 2 else 10 * (int(value) + 1))
PY
"$folder/venv/bin/python" "$folder/look.py"
