"""What others' tools write, as text of this language. `kinds.py` tells which file is what; each format has modules of
its own, which take sources and give a text, or raise `langs.diagnostics.SourceError` with every fault and its place in
the foreign file."""
