"""Back ends of the logic: successor functions on packed states, estimates, costs-to-go, and the export to PDDL."""
