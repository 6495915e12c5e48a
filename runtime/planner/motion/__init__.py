"""The motion programs of the bounds, and what solves them.

A program's unknowns are module poses and joints per slice; its rows come from motion literals, limits and clearances.
`nlp/` is the form of all programs and their solvers, `collision/` the rows of clearances, `keyframes/` P_seq on the
switches alone, `phases/` P_seqPath phase by phase in joint values, `path/` P_path on the whole. `settings` holds the
numbers that steer them; `time_scaling` and `end_conditions` give a path its times, `acceptance` is the planner's last
look at the curve that is stored.
"""
