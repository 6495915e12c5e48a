"""Receding horizon (thesis, section 3.5): a plan window by window, with backtracking and sub-goals.

`receding_horizon` is the loop, `window` plans one window from the state of `mid_run_state`, `subgoals` orders the parts
of the goal, `horizon_length` says how many actions get motion, `run_tree` keeps the tree for the report.
"""
