"""A run of a scene: its rows, its files, where it goes on, and what it gives."""
