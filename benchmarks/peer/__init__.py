"""The common motion benchmark: its scenes, its judge, and one module for either side."""
