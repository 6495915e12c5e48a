"""Back end of motion: stage Functions of the motion predicates, and the spheres that cover shapes."""
