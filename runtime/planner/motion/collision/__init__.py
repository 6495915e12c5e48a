"""Clearances as rows of motion programs.

`pairs_in_phases` says which pairs must keep clear when, `broad_phase` which of them come near, `clearance_rows`
measures these.
"""
