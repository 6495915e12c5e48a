"""What is learnt from refusals, for the search and for the user.

`forbidden_sequences` keeps refused sequences of actions in the search's terms, `nogoods` what verdicts on one window
say about similar ones; `infeasibility` makes the records that explain a refusal, `shortfall` and `nearest_miss` say
what a task that is proved infeasible lacks.
"""
