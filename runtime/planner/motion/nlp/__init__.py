"""Motion programs as nonlinear least squares with equality and inequality rows (thesis, section 3.2; Toussaint 2014).

`unknowns` says where values lie, `row_groups` evaluates like rows together, `features` makes them from motion literals,
`normal_equations` and `banded_cholesky` add up and factor the Gauss-Newton system, `program` joins them, and
`augmented_lagrangian` or `ipopt` solves.
"""
