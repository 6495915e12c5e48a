"""The planner's ground floor: poses, splines, signed distances, and the graph of what is attached to what.

Comes in: arrays of poses `(…, 7)`, joints and shapes of the IR. Goes out: the same at other times, distances, groups.
Nothing here knows of programs, bounds or search. The verifier keeps its own arithmetic and imports nothing from here.

Read `transforms` (rigid transforms of many instants), `splines` (the curves of plan files), `attachments` (which things
form one robot in a phase, and what carries what), `resampling` (poses by chaining kinematics from what rests),
`signed_distances` (points to convex shapes), `start_contacts` (what is so near at the start that no margin can be asked
for).
"""
