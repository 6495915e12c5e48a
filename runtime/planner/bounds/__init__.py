"""Bounds on one skeleton: P_seq, P_seqPath, P_path (thesis, section 3.2), asked in this order.

`multi_bound` asks them and turns refusals into conflicts; `verdicts` says what a bound said; `solves` keeps the
settings and counters of one run; `requests` are the questions as values, which `speculation` answers ahead in other
processes, and `kept_answers` where the same task was solved before in this one.
"""
