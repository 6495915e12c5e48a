"""P_path: the motion of a whole skeleton in one program (thesis, section 3.2).

`whole_path` solves the `path_program` from `path_guesses`; with its switches pinned it also serves phases that are no
set of open chains, which `closed_chains` solves for P_seqPath, around what is in the way by `projected_trees`. `relief`
bends phases that load a drive too much.
"""
