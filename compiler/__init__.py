"""Tree to compiled task: imports, names, types, checks, the IR and its three back ends."""
