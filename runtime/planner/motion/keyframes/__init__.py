"""P_seq: configurations at the switches of a skeleton (thesis, section 3.2).

`sequence` is the bound; it asks `sliding_windows` for long skeletons, they ask `multi_start` for a few successive
switches, which solves `keyframe_program` from `initial_guesses` (with `posture_samples`, `clear_postures`,
`placement_samples` and, for closed rings, `ring_walks`).
`local_repair` draws switches anew around phases without a path, `prismatic_sweeps` sees beforehand what could only
slide through what rests. `causes` tells why a switch is refused.
"""
