"""The bounds P_seq, P_seqPath and P_path as motion programs, and what solves them."""
