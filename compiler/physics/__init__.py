"""What parts weigh, what joints bear, and how ends and bodies hold."""
