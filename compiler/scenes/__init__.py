"""One task with its parameters: scenes unrolled, everything put in its place, the state at the start."""
