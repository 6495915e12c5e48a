"""A world that moves, and runs in it: planning window by window while things happen (thesis, sections 3.5 and 6).

Comes in: a task or a plan file, noise, latency. Goes out: what was carried out, as a plan file, and how well it was
tracked.

Read `run` (the loop), `world` (bodies on courses, modules that fail), `sensing` and `monitor` (what a run knows and
expects), `scene_prediction`, `planning` and `route` (windows in the scene as it will be), `steering`, `braking`,
`evasion` (what is done to a motion while it is carried out), `actuators` and `tracking` (simulated drives),
`predicted_clearance` and `dynamic_collisions`, `failures` and `breakdowns`, `plan_import`, `execution` and `results`
(the doors), `run_record`.
"""
