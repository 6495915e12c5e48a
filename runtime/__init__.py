"""Compiled task to plan and evidence: search, motion programs, the LGP loop, the verifier and the report."""
