"""Motion programs as nonlinear least squares with equality and inequality rows (thesis, section 3.2; Toussaint 2014).

`unknowns` says where values lie, `row_groups` evaluates like rows together, `features` makes them from motion literals,
`normal_equations` or, of small programs, `dense_rows` add up the Gauss-Newton system, `systems` and `banded_cholesky`
solve it, `program` joins them, and `augmented_lagrangian` or `ipopt` solves.
"""
