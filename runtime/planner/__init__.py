"""The planner: from a compiled task to actions and motion that all bounds accept.

Comes in: `ir.Problem`, options, a budget. Goes out: an `Outcome` of `lgp.py`, with plans as records of
`runtime/plan.py`.

Read `lgp.py` first: algorithm 1 of the thesis, candidate after candidate. `search/` proposes sequences of actions,
`bounds/` judges their skeletons, coarse and cheap bounds first, `motion/` holds the programs that the bounds solve,
`conflicts/` what their refusals teach the search and the user, `receding/` the windows of a receding horizon,
`plan_assembly.py` the way from accepted motion to a plan file.
"""
