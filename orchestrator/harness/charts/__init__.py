"""Charts as data, and their drawing with Plotly."""
