"""Receding horizon with backtracking. The planner of one window, for whoever runs it, is

    windows.remember(problem, options, budget, tell) -> Memory
    windows.plan_window(problem, reached, options, horizon, budget, memory, *, seed, forbidden, lookahead) -> Window

with `state.start(problem)` as the first `reached`, and `Window.reached` after what was planned.
"""
