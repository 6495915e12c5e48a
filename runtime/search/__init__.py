"""From packed states to skeletons: best-first search, no-goods, and the replay of motion effects."""
