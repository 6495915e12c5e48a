"""Receding horizon (thesis, section 3.5): planning window by window, from wherever the scene is."""
