"""From packed states to skeletons: the symbolic half of the loop (thesis, section 3.3).

`best_first` proposes sequences of actions, cheapest first, with what `learned_penalties` and the planner's conflicts
have taught it; `slack_maximisation` picks among equal ones the one with most room; `skeleton_replay` replays a
sequence into the intervals that its motion literals hold. `stepper` steps one action on plain sets of facts, for plan
files, windows and runs.
"""
