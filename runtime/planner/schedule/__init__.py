"""Time: phases as short as their limits allow, and robots that work at once.

A verified plan is a row of phases, one after the other. Where its length counts, each phase runs through its curve by
the fastest law of time that begins and ends gently (`time_optimal.py`, `profiles.py`). Then each robot moves from its
own last switch to its own next one (`dependencies.py`): phases are put as early as what they wait for and what is in
their way allow, the one with the longest tail first (`list_schedule.py`, `clearance.py`), and written as one plan
(`scheduled_plan.py`). `stage.py` does all of that; what it gives is asked of the verifier like any plan.
"""
